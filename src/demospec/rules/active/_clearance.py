"""What to ask next about clearances: paths that pass at a distance in doubt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import bezier_points
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._sentences import plural
from demospec.rules.clearance._fit import ClearanceFit
from demospec.rules.clearance._likelihood import Particles, log_sum
from demospec.rules.clearance._measure import Distance, nearest_approach
from demospec.rules.clearance._problem import ClearanceProblem, solve_clearance
from demospec.scene import Scene

if TYPE_CHECKING:
    from demospec.rules._fit import Mode
    from demospec.rules.active._result import Query

SETTLED_BITS = 0.05
"""Below this gain the clearances are as good as known."""

_BIN = 0.25  # hundredths of the table: clearances closer than this count as one rule
_POINTS = 60


def next_clearance_query(problem: ClearanceProblem, *, pool: int, seed: int) -> Query:
    """See `next_query`. Needs at least one trajectory: its ends are those of the probes."""
    fit = solve_clearance(problem)
    unit = problem.extent / 100
    shown: dict[int, tuple[FloatArray, FloatArray]] = {}
    for path, s in zip(problem.paths, problem.scene_of, strict=True):
        shown.setdefault(s, (path[0], path[-1]))
    first = next(iter(shown.values()))
    scenes = [(i, s, shown.get(i, first)) for i, s in enumerate(problem.scenes)]
    return best_clearance_path(fit, scenes, problem.distance, unit, pool=pool, seed=seed)


def best_clearance_path(
    fit: ClearanceFit,
    scenes: Sequence[tuple[int | str, Scene, tuple[FloatArray, FloatArray]]],
    distance: Distance,
    unit: float,
    *,
    pool: int = 300,
    seed: int = 0,
    type: str | None = None,
    mode: Mode = "full",
    measure: Callable[..., FloatArray] = nearest_approach,
) -> Query:
    """The order-2 Bézier path, over some scenes, whose label would tell most.

    Args:
        fit: The posterior.
        scenes: Name, scene and (start, goal) of each.
        unit: A hundredth of the table, set units.
        mode: How the posterior was found; stated in the answer.
        measure: Called as `nearest_approach` is.

    A path that leaves its scene's picture, where nobody could see it, is asked only if no path
    inside tells anything.
    """
    from demospec.rules.active._result import Query

    rng = np.random.default_rng(seed)
    usable = [item for item in scenes if item[1].objects]
    if not usable:
        raise InputError("at least one scene that lists objects", "none", field="scenes")
    chosen = [usable[i] for i in rng.permutation(len(usable))[:12]]
    each = max(8, pool // len(chosen))
    best: tuple[float, int | str, FloatArray, FloatArray] | None = None
    apart = [(pair, 0.0) for pair in _rivals(fit)]
    for round_ in range(2):
        for name, scene, (start, goal) in chosen if round_ == 0 else chosen[:1]:
            if round_ == 0:
                control = control_points(rng, scene, start, goal, each, unit)
            else:
                assert best is not None
                name, scene, (start, goal) = next(i for i in chosen if i[0] == best[1])
                control = best[3] + unit * rng.standard_normal((2 * each, 2)) * 3
            paths = bezier_points(start[:2], goal[:2], control[:, None, :], _POINTS)
            near = measure(scene, paths, fit.symbols, distance=distance)
            bits, _ = path_bits(fit.particles, near)
            apart = [(pair, max(told, _told_apart(fit, pair, near))) for pair, told in apart]
            # A label has one bit at most, so that a telling path in the picture comes first.
            worth = bits + 2.0 * (_in_picture(scene, paths) & (bits >= SETTLED_BITS))
            top = int(worth.argmax())
            if best is None or worth[top] > best[0]:
                best = (float(worth[top]), name, paths[top], control[top])
    assert best is not None
    gain = best[0] - 2.0 if best[0] >= 2.0 else best[0]
    now = distinguishable(fit.particles, unit)
    alone = next((pair for pair, told in apart if told < SETTLED_BITS), ())
    together = _together(alone)
    if gain < SETTLED_BITS:
        word = together or "no path of the pool tells the remaining clearances apart"
        return Query(
            "settled", bits=gain, total=now, exact=False, note=word, type=type,
            rule=fit.rule, mode=mode, alone=alone,
        )  # fmt: skip
    scene = next(s for n, s, _ in chosen if n == best[1])
    points = best[2]
    near = nearest_approach(scene, points[None], fit.symbols, distance=distance)
    bits, p = path_bits(fit.particles, near)
    accept = fit.particles.accepts(near)[:, 0]
    left = [_left(fit.particles, share, unit) for share in (accept, 1.0 - accept)]
    return Query(
        "ask", best[1], points, left[0], left[1], float(bits[0]), float(p[0]), now, False,
        together, type, rule=fit.rule, mode=mode, alone=alone,
    )  # fmt: skip


def _rivals(fit: ClearanceFit) -> list[tuple[str, ...]]:
    """Pairs of classes of which the labels do not say which one matters."""
    return [(named, other) for named, rivals in fit.confounded.items() for other in rivals]


def _told_apart(fit: ClearanceFit, pair: Sequence[str], near: FloatArray) -> float:
    """Most bits that the label of one of some paths (n, K) tells of which of two classes
    matters, given that just one does."""
    one, two = (
        np.isfinite(fit.particles.clearance[:, fit.symbols.index(symbol)]) for symbol in pair
    )
    weight = np.exp(fit.particles.log_weight) * (one ^ two)
    weight = weight / weight.sum()
    accept = fit.particles.accepts(near)
    whole = _entropy(weight @ accept)
    for group in (one, two):
        mine = np.where(group, weight, 0.0)
        share = float(mine.sum())
        if share > 0:
            whole = whole - share * _entropy(np.clip(mine @ accept / share, 0.0, 1.0))
    return float(whole.max())


def _together(pair: Sequence[str]) -> str:
    """What to ask for where no path tells two classes apart."""
    if not pair:
        return ""
    one, two = plural(pair[0]), plural(pair[1])
    return (
        f"{one} or {two}: they stand together, so that no path here says which of them matters; "
        f"put one of them alone and show a path near it"
    )


def _left(particles: Particles, share: FloatArray, unit: float) -> float:
    """Effective number of rules after an answer with these likelihoods; 0 if it cannot come."""
    with np.errstate(divide="ignore"):
        weight = particles.log_weight + np.log(share)
    total = log_sum(weight)
    if total == -np.inf:
        return 0.0
    return distinguishable(particles.weighed(weight - total), unit)


def control_points(
    rng: np.random.Generator,
    scene: Scene,
    start: FloatArray,
    goal: FloatArray,
    count: int,
    unit: float,
) -> FloatArray:
    """Control points of curves that pass by the objects of a scene on any side.

    The curve with control point c passes (start + goal) / 4 + c / 2 half way.
    """
    ends = (np.asarray(start[:2]) + np.asarray(goal[:2])) / 4
    items = scene.listed_objects()
    out = np.empty((count, 2))
    for i in range(count):
        shape = items[rng.integers(len(items))].outline
        x0, y0, x1, y1 = shape.bounds
        size = max(x1 - x0, y1 - y0, unit)
        place = np.array([(x0 + x1) / 2, (y0 + y1) / 2]) + size * rng.normal(0, 0.6, 2)
        out[i] = (place - ends) * 2
    return out


def _in_picture(scene: Scene, paths: FloatArray) -> NDArray[np.bool_]:
    """(n,) whether each path stays inside the scene's picture; all do where it has none."""
    if scene.size_px is None:
        return np.ones(len(paths), dtype=bool)
    return np.asarray(((paths >= 0) & (paths <= np.asarray(scene.size_px))).all(axis=(1, 2)))


def path_bits(particles: Particles, near: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, K) nearest approaches → (n,) expected bits of the label, (n,) probability of valid."""
    weight = np.exp(particles.log_weight)
    accept = particles.accepts(near)
    p = np.clip(weight @ accept, 0.0, 1.0)
    return np.maximum(_entropy(p) - weight @ _entropy(accept), 0.0), p


def _entropy(p: FloatArray) -> FloatArray:
    q = np.clip(p, 1e-12, 1 - 1e-12)
    return np.asarray(-(q * np.log2(q) + (1 - q) * np.log2(1 - q)))


def distinguishable(particles: Particles, unit: float) -> float:
    """Effective number of rules, clearances counted in quarters of `unit`."""
    c = particles.clearance
    cell = np.where(np.isfinite(c), np.floor(c / (_BIN * unit)), -1e9)
    _, group = np.unique(cell, axis=0, return_inverse=True)
    mass = np.bincount(group.ravel(), np.exp(particles.log_weight))
    mass = mass[mass > 0] / mass.sum()
    return float(np.exp(-(mass * np.log(mass)).sum()))
