"""Cost maps: what it costs to pass through each place of a scene, with units.

cost(p) = 1 + w · Σ_k penalty_k(p), per unit of length: 1 where no zone reaches. d_k is the signed
distance to object k and r_k the reach of its zone, both in set units. The penalty of preset

- ``physical`` (default) is max(0, r_k − d_k): the deeper the dearer; w has unit 1 / set unit;
- ``paper`` is d_k where d_k ≤ r_k: it grows *away* from the object up to the rim, so that a
  planner on it hugs the object (the paper's; here for comparison);
- ``count`` is 1 where d_k ≤ r_k.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, MultiPolygon, Polygon
from demospec.planning._results import Zone
from demospec.scene import Scene

Preset = Literal["physical", "paper", "count"]

WEIGHT = 1.0
"""w, per hundredth of the map's longer side: so much depth doubles the price of a unit of length, a
few times as much makes any detour cheaper."""

MAX_CELLS = 25_000_000
"""Largest map that is made; a larger one is taken for a slip in the resolution."""


@dataclass(frozen=True)
class CostMap:
    """The zones of one scene over a rectangle of the plane.

    Args:
        zones: What to keep out of.
        bounds: (x_min, y_min, x_max, y_max), set units, y down as in the picture.
        cell: Edge of one cell, set units; > 0.
        weight: w, per set unit; ≥ 0.
        preset: Which penalty, see above.
        metres_per_unit: Or None where the set does not say.
    """

    zones: tuple[Zone, ...]
    bounds: tuple[float, float, float, float]
    cell: float = 1.0
    weight: float = WEIGHT
    preset: Preset = "physical"
    metres_per_unit: float | None = None

    def __post_init__(self) -> None:
        if self.preset not in get_args(Preset):
            raise InputError(f"one of {', '.join(get_args(Preset))}", self.preset, field="preset")
        if not (np.isfinite(self.weight) and self.weight >= 0):
            raise InputError("a weight >= 0", self.weight, field="weight")
        if not (np.isfinite(self.cell) and self.cell > 0):
            raise InputError("a cell size > 0", self.cell, field="resolution")
        rows, columns = self.shape
        if rows * columns > MAX_CELLS:
            raise InputError(
                f"a map of at most {MAX_CELLS} cells", f"{columns}x{rows}", field="resolution"
            )

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns): whole cells that cover `bounds`."""
        x0, y0, x1, y1 = self.bounds
        # A bound that is a multiple of the cell but for rounding does not get a further cell.
        return (
            max(1, int(np.ceil((y1 - y0) / self.cell - 1e-9))),
            max(1, int(np.ceil((x1 - x0) / self.cell - 1e-9))),
        )

    @property
    def extent(self) -> float:
        """The longer side, set units."""
        return float(max(self.bounds[2] - self.bounds[0], self.bounds[3] - self.bounds[1]))

    def centers(self) -> FloatArray:
        """(rows, columns, 2): centre of every cell, set units; row 0 is the top."""
        rows, columns = self.shape
        x = self.bounds[0] + (np.arange(columns) + 0.5) * self.cell
        y = self.bounds[1] + (np.arange(rows) + 0.5) * self.cell
        return np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1)

    def cell_of(self, point: ArrayLike) -> tuple[int, int]:
        """(row, column) of the cell that holds a point; points outside get the nearest cell."""
        x, y = np.asarray(point, dtype=np.float64)[:2]
        rows, columns = self.shape
        row = int(np.clip((y - self.bounds[1]) // self.cell, 0, rows - 1))
        return row, int(np.clip((x - self.bounds[0]) // self.cell, 0, columns - 1))

    def clearance(self, points: ArrayLike) -> FloatArray:
        """(...): distance to the nearest object that matters, set units; negative inside it.

        +inf where nothing matters.
        """
        return self._least(points, required=False)

    def margin(self, points: ArrayLike) -> FloatArray:
        """(...): smallest (distance − clearance to keep), set units; < 0 where forbidden."""
        return self._least(points, required=True)

    def _least(self, points: ArrayLike, *, required: bool) -> FloatArray:
        p = np.asarray(points, dtype=np.float64)
        least = np.full(p.shape[:-1], np.inf)
        for zone in self.zones:
            gap = zone.shape.signed_distance(p)
            np.minimum(least, gap - zone.radius if required else gap, out=least)
        return least

    def cost(self, points: ArrayLike) -> FloatArray:
        """(...): price of a unit of length there, ≥ 1, finite everywhere."""
        p = np.asarray(points, dtype=np.float64)
        penalty = np.zeros(p.shape[:-1])
        for zone in self.zones:
            gap = zone.shape.signed_distance(p)
            if self.preset == "physical":
                penalty += np.maximum(0.0, zone.reach - gap)
            else:
                price = np.maximum(0.0, gap) if self.preset == "paper" else 1.0
                penalty += np.where(gap <= zone.reach, price, 0.0)
        return 1.0 + self.weight * penalty

    @cached_property
    def array(self) -> FloatArray:
        """(rows, columns): `cost` at the cell centres."""
        return self.cost(self.centers())

    @cached_property
    def signed_distance(self) -> FloatArray:
        """(rows, columns): `margin` at the cell centres, set units: a signed-distance grid."""
        return self.margin(self.centers())

    @cached_property
    def forbidden(self) -> NDArray[np.bool_]:
        """(rows, columns): True where a cell's centre is in a zone. Exact, and fast."""
        return self.within(0.0)

    def within(self, inflate: float) -> NDArray[np.bool_]:
        """(rows, columns): True where the margin at the cell's centre is below `inflate`.

        A margin changes by at most the distance moved, so blocks of cells far from the rim
        are decided at once and only those near it are refined.
        """
        if not all(isinstance(z.shape, (Disc, Capsule, Polygon, MultiPolygon)) for z in self.zones):
            # A distance map as a network sees it may change faster than the place.
            return np.asarray(self.signed_distance < inflate)
        rows, columns = self.shape
        block = 16
        r, c = (m.ravel() for m in np.mgrid[0 : -(-rows // block), 0 : -(-columns // block)])
        mask = np.zeros((-(-rows // block) * block, -(-columns // block) * block), dtype=bool)
        origin = np.asarray(self.bounds[:2])
        while True:
            middle = origin + (np.stack([c, r], axis=1) + 0.5) * (block * self.cell)
            margin = self.margin(middle) - inflate
            if block == 1:
                mask[r, c] = margin < 0
                return mask[:rows, :columns]
            reach = block * self.cell * np.sqrt(0.5)
            inside, open_ = margin < -reach, np.abs(margin) <= reach
            for i, j in zip(r[inside] * block, c[inside] * block, strict=True):
                mask[i : i + block, j : j + block] = True
            r, c, block = r[open_] * 2, c[open_] * 2, block // 2
            r, c = (r[:, None] + [0, 0, 1, 1]).ravel(), (c[:, None] + [0, 1, 0, 1]).ravel()

    def path_cost(self, points: ArrayLike, spacing: float | None = None) -> float:
        """∫ cost ds along a polyline (n, 2), by the trapezoid rule at `spacing` (a quarter of a
        cell)."""
        from demospec.demonstrations import densify

        step = self.cell / 4 if spacing is None else spacing
        p = densify(np.asarray(points, dtype=np.float64), step)
        steps = np.hypot(*np.diff(p, axis=0).T)
        price = self.cost(p)
        return float((steps * (price[1:] + price[:-1]) / 2).sum())


def map_bounds(scene: Scene, zones: tuple[Zone, ...] = ()) -> tuple[float, float, float, float]:
    """The rectangle that plans stay in: the picture, or what the scene's parts span.

    Without a picture: start, goal and objects with their clearances, and a tenth of the
    largest extent around them, so that there is a way around each object.
    """
    size = scene.size_px
    if size is not None:
        return (0.0, 0.0, float(size[0]), float(size[1]))
    boxes = [(*scene.start[:2], *scene.start[:2]), (*scene.goal[:2], *scene.goal[:2])]
    boxes += [o.outline.bounds for o in scene.objects or ()]
    for zone in zones:
        x0, y0, x1, y1 = zone.shape.bounds
        boxes.append((x0 - zone.reach, y0 - zone.reach, x1 + zone.reach, y1 + zone.reach))
    low = np.min([b[:2] for b in boxes], axis=0)
    high = np.max([b[2:] for b in boxes], axis=0)
    pad = max(0.1 * float((high - low).max()), 1e-6)
    return (
        float(low[0] - pad),
        float(low[1] - pad),
        float(high[0] + pad),
        float(high[1] + pad),
    )
