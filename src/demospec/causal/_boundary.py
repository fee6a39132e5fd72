"""The boundary of validity in the z_θ plane: before and after an intervention, and by type.

Source: Angelov et al. 2020: the search for the boundary of validity in z_θ from which the
effect of an added object, and the difference of two types, are read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.causal._find import prepared
from demospec.causal._paths import control_region, paths_of, region_of, region_of_scene
from demospec.causal._results import Interval, Settings
from demospec.causal._statistics import mean_interval
from demospec.demonstrations import ValidityModel, View
from demospec.errors import CannotJudgeError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.scene import Editor, Scene

ROUNDS = 2
"""Halvings of a grid step over many scenes: an eighth of it is finer than the mean needs."""


@dataclass(frozen=True)
class Boundary:
    """Where p(valid) crosses ½ in the plane of control points.

    Args:
        lines: Each (n, 2) z_θ in pixels, closed or ending at the plane's edge.
        area: Share of the plane that is valid.
    """

    lines: tuple[FloatArray, ...]
    area: float


@dataclass(frozen=True)
class BoundaryShift:
    """The boundary before and after, on the same grid of control points.

    Args:
        lost, gained: Share of the plane that was valid and no longer is, and the reverse.
            gained − lost is the effect, over a grid instead of random draws.
        low, high: Corners of the plane of control points, set units.
        distance: How far the boundary moves, set units: the mean distance from points of either
            boundary to the other. None where one of them has none (everything, or nothing, is
            valid).
    """

    type: str
    before: Boundary
    after: Boundary
    lost: float
    gained: float
    low: tuple[float, float]
    high: tuple[float, float]
    distance: float | None = None


def boundary_shift(before: View, after: View, type: str, *, grid: int = 51) -> BoundaryShift:
    """Searches the boundary of validity in z_θ in a scene and in the changed scene.

    The model is asked on a grid; crossings of the logit between neighbours are interpolated
    and joined, then each is sharpened by bisection along its gradient, because rules jump.

    Args:
        before, after: The model's views of the scene as it is and as it was changed.
        grid: Control points along each axis.
    """
    first = _Sides(before, grid)
    return _shift(first, _Sides(after, grid, like=first), type, type)


def boundary_between(view: View, from_type: str, to_type: str, *, grid: int = 51) -> BoundaryShift:
    """The boundaries of two types in one scene: do(S := s) against do(S := s′).

    Returns:
        `before` is that of `from_type`; `lost` is what only it accepts, `gained` what only
        `to_type` accepts; `type` names both.
    """
    sides = _Sides(view, grid)
    return _shift(sides, sides, from_type, to_type)


class _Sides:
    """Boundaries of one view, each type's made once."""

    def __init__(self, view: View, grid: int, rounds: int = 6, like: _Sides | None = None) -> None:
        self.view, self.grid, self.rounds = view, grid, rounds
        # `like` gives the same plane, whatever was added at its rim, and the same array of paths:
        # rules keep the distances to what an intervention leaves alone.
        scene = (like.view if like else view).scene
        self.low, self.high = control_region(region_of_scene(scene, region_of([scene])))
        self.x, self.y = (np.linspace(self.low[k], self.high[k], grid) for k in (0, 1))
        controls = np.stack(np.meshgrid(self.x, self.y), axis=-1).reshape(-1, 2)
        self.paths: FloatArray = like.paths if like else paths_of(view.scene, controls)
        self._made: dict[str, tuple[NDArray[np.bool_], Boundary]] = {}

    def of(self, type_: str) -> tuple[NDArray[np.bool_], Boundary]:
        """(grid, grid) whether valid, and the boundary."""
        if type_ not in self._made:
            found = np.asarray(self.view.logits(self.paths, type_)).reshape(self.grid, self.grid)
            valid = found > 0
            lines = _lines(found, self.view, self.x, self.y, type_, self.rounds)
            self._made[type_] = valid, Boundary(lines, float(valid.mean()))
        return self._made[type_]


def _shift(before: _Sides, after: _Sides, type_before: str, type_after: str) -> BoundaryShift:
    was, first = before.of(type_before)
    now, second = after.of(type_after)
    low, high = before.low, before.high
    return BoundaryShift(
        type=type_before if type_before == type_after else f"{type_before} → {type_after}",
        before=first,
        after=second,
        lost=float((was & ~now).mean()),
        gained=float((~was & now).mean()),
        low=(float(low[0]), float(low[1])),
        high=(float(high[0]), float(high[1])),
        distance=_distance(first, second),
    )


def _distance(first: Boundary, second: Boundary) -> float | None:
    """Mean distance of the points of either boundary from the other."""
    from scipy.spatial import cKDTree

    if not first.lines or not second.lines:
        return None
    a, b = (np.concatenate(side.lines) for side in (first, second))
    there, back = cKDTree(b).query(a)[0], cKDTree(a).query(b)[0]
    return float(np.concatenate([there, back]).mean())


@dataclass(frozen=True)
class BoundaryEffect:
    """How one intervention moves the boundary of one type, over scenes.

    Args:
        type: s; `to_type` is s′ where two types are compared, else None.
        symbol: What was added; None where two types are compared.
        lost, gained: Mean shares of the plane, each with a 95 % interval over scenes (None for
            fewer than two).
        distance: Mean over the scenes in which both boundaries exist, set units; None for none.
        n_scenes: Scenes in which the intervention was possible.
        n_distance: Scenes in which both boundaries exist.
    """

    type: str
    to_type: str | None
    symbol: str | None
    lost: float
    lost_interval: Interval | None
    gained: float
    gained_interval: Interval | None
    distance: float | None
    n_scenes: int
    n_distance: int

    def to_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {
            "type": self.type,
            **({"to": self.to_type} if self.symbol is None else {"symbol": self.symbol}),
            "lost": self.lost,
            "lost_interval": None if self.lost_interval is None else list(self.lost_interval),
            "gained": self.gained,
            "gained_interval": None if self.gained_interval is None else list(self.gained_interval),
            "distance": self.distance,
            "n_scenes": self.n_scenes,
            "n_distance": self.n_distance,
        }


def boundary_effects(
    model: ValidityModel,
    scenes: Sequence[Scene],
    symbols: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    *,
    seed: int = 0,
    grid: int = 21,
    hide_lists: bool = False,
    editor: Editor | None = None,
    progress: Progress = silent,
) -> tuple[BoundaryEffect, ...]:
    """How far the boundary moves: by each symbol for each type, then between every two types.

    Each symbol is added once in a scene, at one of the places that `find_causes` with these
    settings would try. Scenes that the model cannot judge are left out.

    Args:
        grid: Control points along each axis.
        hide_lists: The model gets the changed pictures without the object lists.

    Raises:
        CannotJudgeError: The model can judge none of the scenes.
    """
    settings = Settings(placements=1, seed=seed, hide_lists=hide_lists)
    run, _ = prepared(model, scenes, symbols, types, settings=settings, editor=editor,
                      skip_absent=symbols is None)  # fmt: skip
    found: dict[tuple[str, str | None, str | None], list[BoundaryShift]] = {}
    refused: CannotJudgeError | None = None
    judged = 0
    for done, scene in enumerate(scenes):
        progress("boundaries", done, len(scenes))
        try:
            before = _Sides(run.view(scene), grid, ROUNDS)
            for a, b in combinations(run.types, 2):
                found.setdefault((a, b, None), []).append(_shift(before, before, a, b))
            for symbol, after in run.with_one_added(scene):
                changed = _Sides(run.view(after), grid, ROUNDS, before)
                for t in run.types:
                    key = (t, None, symbol)
                    found.setdefault(key, []).append(_shift(before, changed, t, t))
            judged += 1
        except CannotJudgeError as error:
            refused = error
    progress("boundaries", len(scenes), len(scenes))
    if refused is not None and not judged:
        raise refused
    added = [(t, None, s) for s in run.symbols for t in run.types]
    between = [(a, b, None) for a, b in combinations(run.types, 2)]
    keys: list[tuple[str, str | None, str | None]] = [*added, *between]
    return tuple(_over_scenes(key, found[key], seed) for key in keys if key in found)


def _over_scenes(
    key: tuple[str, str | None, str | None], shifts: list[BoundaryShift], seed: int
) -> BoundaryEffect:
    lost, gained = ([getattr(s, name) for s in shifts] for name in ("lost", "gained"))
    distances = [s.distance for s in shifts if s.distance is not None]
    return BoundaryEffect(
        type=key[0],
        to_type=key[1],
        symbol=key[2],
        lost=float(np.mean(lost)),
        lost_interval=mean_interval(lost, seed=seed, bounds=(0.0, 1.0)),
        gained=float(np.mean(gained)),
        gained_interval=mean_interval(gained, seed=seed, bounds=(0.0, 1.0)),
        distance=float(np.mean(distances)) if distances else None,
        n_scenes=len(shifts),
        n_distance=len(distances),
    )


def _lines(
    logits: FloatArray, view: View, x: FloatArray, y: FloatArray, type_: str, rounds: int
) -> tuple[FloatArray, ...]:
    from skimage.measure import find_contours

    # The sign decides where the boundary runs; the size would pull it where logits saturate.
    signs = np.where(logits > 0, 1.0, -1.0)
    step = np.array([x[1] - x[0], y[1] - y[0]])
    out = []
    for line in find_contours(signs, 0.0):  # type: ignore[no-untyped-call]
        points = np.stack([x[0] + line[:, 1] * step[0], y[0] + line[:, 0] * step[1]], axis=1)
        out.append(_sharpened(points, line, signs, view, step, type_, rounds))
    return tuple(out)


def _sharpened(
    points: FloatArray,
    line: FloatArray,
    signs: FloatArray,
    view: View,
    step: FloatArray,
    type_: str,
    rounds: int,
) -> FloatArray:
    """Bisects along the grid edge that each crossing lies on: error ≤ step / 2^(rounds + 1)."""
    row, column = line[:, 0], line[:, 1]
    down = row != np.floor(row)  # the crossing lies on an edge between two rows
    r0, c0 = np.floor(row).astype(int), np.floor(column).astype(int)
    first_valid = signs[r0, c0] > 0
    along = np.where(down[:, None], [0.0, step[1]], [step[0], 0.0])
    low, high = points - along / 2, points + along / 2
    for _ in range(rounds):
        middle = (low + high) / 2
        valid = np.asarray(view.logits(paths_of(view.scene, middle), type_)) > 0
        ahead = (valid == first_valid)[:, None]
        low, high = np.where(ahead, middle, low), np.where(ahead, high, middle)
    return np.asarray((low + high) / 2)
