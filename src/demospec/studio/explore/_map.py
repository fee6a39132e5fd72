"""Validity maps fast enough to follow the hand, and as lines that the browser draws crisp.

A clearance rule's map is read from one distance grid per object, which is kept: where one
object moves, one grid is computed again. Every other model is asked by `validity_map`.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from demospec.demonstrations import View, bezier_points
from demospec.frames import FloatArray
from demospec.rules import ClearanceRule, RuleView, known_of
from demospec.scene import Scene, SceneObject
from demospec.specification import ValidityMap, plane_bounds, validity_map

SIZE = 51
"""Control points of a large map along a side; a small one has `SMALL`."""
SMALL = 31
_CELLS = 140
_POINTS = 120
_REACH = 8.0
"""Grid cells beyond which a margin is only known to be large: boundaries lie at 0."""

Bounds = tuple[float, float, float, float]


@dataclass(frozen=True)
class BendMap:
    """What is said of every bend of the path.

    Args:
        accepted: Logit ≥ 0 where a path is known to be accepted.
        possible: Logit ≥ 0 where it is not known to be rejected. Between the two nothing that
            was shown decides; of a model that always decides both are one.
    """

    accepted: ValidityMap
    possible: ValidityMap

    @property
    def share(self) -> float:
        """Share of all bends that are accepted."""
        return float(self.accepted.p_valid.mean())

    @property
    def unknown(self) -> float:
        """Share of all bends that nothing decides."""
        return max(0.0, float(self.possible.p_valid.mean()) - self.share)


def explore_map(view: View, type: str, size: int = SIZE) -> BendMap:
    """The map of one type over the plane of control points.

    For clearance rules the distance is interpolated between grid points a 140th of the plane
    apart (1 px where the picture has 100): the boundary is drawn to about a third of that. The
    verdict on a path never comes from here.
    """
    if not isinstance(view, RuleView) or view.model.of_type(type).clearance is None:
        found = validity_map(view, type, size=size)
        return BendMap(found, found)
    clear_of, keep_off = thresholds(view, type)
    accepted, possible = (
        _map_of(view.scene, view.model.of_type(type).clearance, each, type, size)
        for each in (clear_of, keep_off)
    )
    both = np.minimum(accepted.logits, possible.logits)
    return BendMap(replace(accepted, logits=both, p_valid=(both >= 0).astype(np.float64)), possible)


def thresholds(view: RuleView, type: str) -> tuple[dict[str, float], dict[str, float]]:
    """Class → distance from which a path is known to be accepted, and below which rejected.

    As `RuleView.verdicts` has them. Where a rule explains nothing, everything is open.
    """
    rules = view.model.of_type(type)
    assert rules.clearance is not None
    c = rules.clearance
    known = known_of(c.value, c.interval, rules.evidence, rules.fit)
    there = tuple(dict.fromkeys(o.symbol for o in view.scene.listed_objects()))
    if not known.decided:
        return dict.fromkeys(there, np.inf), {}
    learned = "at_most" in rules.evidence
    clear_of = {s: known.keep_from(s) for s in there if learned or not known.unknown(s)}
    return clear_of, {s: d for s, d in known.reject_below.items() if s in there}


def _map_of(
    scene: Scene, rule: ClearanceRule | None, distances: Mapping[str, float], type: str, size: int
) -> ValidityMap:
    assert rule is not None
    bounds = plane_bounds(scene)
    start, goal = _pair(scene.start), _pair(scene.goal)
    field, spacing = _margin_field(scene, distances, rule.distance, bounds, start, goal)
    far = _REACH * spacing
    logits = np.clip(_least_along(field, bounds, start, goal, size), -far, far)
    return ValidityMap(
        type=type,
        x=np.linspace(bounds[0], bounds[2], size),
        y=np.linspace(bounds[1], bounds[3], size),
        logits=logits,
        p_valid=(logits >= 0).astype(np.float64),
        start=start,
        goal=goal,
    )


def boundary_path(found: ValidityMap, level: float = 0.0, *, closed: bool = True) -> str:
    """The lines logit = `level` as the ``d`` of an SVG path, in pixels of the scene.

    Closed, and filled with the even-odd rule, it is the accepted region; the map's rim then
    belongs to the line.
    """
    from skimage.measure import find_contours

    logits = np.asarray(found.logits) - level
    reach = max(float(np.abs(logits[np.isfinite(logits)]).max(initial=0.0)), 1e-6)
    # Far from the boundary the size says nothing; huge sizes would spoil the interpolation.
    scale = min(reach, 6.0 * _median_step(logits))
    values = np.clip(np.nan_to_num(logits), -scale, scale)
    if closed:
        values = np.pad(values, 1, constant_values=-scale)
    nx, ny = len(found.x), len(found.y)
    parts = []
    for line in find_contours(values, 0.0):  # type: ignore[no-untyped-call]
        row, column = (line - (1.0 if closed else 0.0)).T
        x = np.interp(column, np.arange(nx), found.x)
        y = np.interp(row, np.arange(ny), found.y)
        text = "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))
        parts.append(f"M{text}" + ("Z" if closed else ""))
    return "".join(parts)


def _median_step(logits: FloatArray) -> float:
    """How much a logit changes from one cell to the next, typically; > 0."""
    steps = np.abs(np.diff(logits, axis=1))
    steps = steps[(steps > 0) & np.isfinite(steps)]
    return float(np.median(steps)) if len(steps) else 1.0


def _pair(place: Any) -> tuple[float, float]:
    return (float(place[0]), float(place[1]))


def _frame(bounds: Bounds, start: tuple[float, float], goal: tuple[float, float]) -> Bounds:
    """The plane, widened to hold both ends: every curve lies inside."""
    return (
        min(bounds[0], start[0], goal[0]),
        min(bounds[1], start[1], goal[1]),
        max(bounds[2], start[0], goal[0]),
        max(bounds[3], start[1], goal[1]),
    )


def _axes(frame: Bounds) -> tuple[FloatArray, FloatArray, float]:
    spacing = max(frame[2] - frame[0], frame[3] - frame[1]) / _CELLS
    nx = int(np.ceil((frame[2] - frame[0]) / spacing)) + 1
    ny = int(np.ceil((frame[3] - frame[1]) / spacing)) + 1
    x, y = frame[0] + spacing * np.arange(nx), frame[1] + spacing * np.arange(ny)
    return np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64), spacing


_GRIDS: OrderedDict[tuple[Any, ...], FloatArray] = OrderedDict()
_KEPT = 128  # grids of about 20,000 numbers: 20 MB


def _distance_grid(item: SceneObject, distance: str, frame: Bounds) -> FloatArray:
    """Signed distance to one object at every grid point, (ny, nx), pixels."""
    shape = item.outline
    key = (shape, item.center, distance, frame)
    grid = _GRIDS.get(key)
    if grid is None:
        x, y, _ = _axes(frame)
        points = np.stack(np.meshgrid(x, y), axis=-1)
        if distance == "center":
            grid = np.asarray(np.hypot(*(points - np.asarray(item.center)).transpose(2, 0, 1)))
        else:
            grid = np.asarray(shape.signed_distance(points.reshape(-1, 2))).reshape(len(y), len(x))
        _GRIDS[key] = grid
        while len(_GRIDS) > _KEPT:
            _GRIDS.popitem(last=False)
    return grid


def _margin_field(
    scene: Scene,
    distances: Mapping[str, float],
    measured: str,
    bounds: Bounds,
    start: tuple[float, float],
    goal: tuple[float, float],
) -> tuple[FloatArray, float]:
    """Smallest distance − threshold at every grid point, (ny, nx); and the grid's spacing."""
    frame = _frame(bounds, start, goal)
    x, y, spacing = _axes(frame)
    field = np.full((len(y), len(x)), _REACH * spacing)
    most = 4 * (len(x) + len(y)) * spacing  # further than anything is from anything here
    for item in scene.listed_objects():
        if item.symbol in distances:
            near = _distance_grid(item, measured, frame) - min(distances[item.symbol], most)
            np.minimum(field, near, out=field)
    return field, spacing


@lru_cache(maxsize=16)
def _places(
    bounds: Bounds, start: tuple[float, float], goal: tuple[float, float], size: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """For every point of every curve of a map: its cell in the grid and its share of it."""
    x, y, spacing = _axes(frame := _frame(bounds, start, goal))
    controls = np.stack(
        np.meshgrid(
            np.linspace(bounds[0], bounds[2], size), np.linspace(bounds[1], bounds[3], size)
        ),
        axis=-1,
    ).reshape(-1, 1, 2)
    ends = np.broadcast_to(np.asarray(start), (len(controls), 2))
    points = bezier_points(ends, np.asarray(goal), controls, _POINTS)
    at = (points - np.asarray(frame[:2])) / spacing
    cell = np.clip(np.floor(at).astype(np.int32), 0, np.array([len(x) - 2, len(y) - 2]))
    share = (at - cell).astype(np.float32)
    first = cell[..., 1] * len(x) + cell[..., 0]
    return first, share[..., 0], share[..., 1], len(x)


def _least_along(
    field: FloatArray,
    bounds: Bounds,
    start: tuple[float, float],
    goal: tuple[float, float],
    size: int,
) -> FloatArray:
    """Smallest interpolated margin along the curve through each control point, (size, size)."""
    first, sx, sy, width = _places(bounds, start, goal, size)
    flat = field.astype(np.float32).ravel()
    upper = flat[first] * (1 - sx) + flat[first + 1] * sx
    lower = flat[first + width] * (1 - sx) + flat[first + width + 1] * sx
    along = upper * (1 - sy) + lower * sy
    return np.asarray(along.min(axis=1), dtype=np.float64).reshape(size, size)
