"""The paper's planner: search in z_θ, the control point of an order-2 Bézier curve.

Samples control points over the plane, repairs the best of them by gradient steps where none
keeps the rule (30 steps, as in the paper), then shortens the curve while the rule is kept. The
curve handed over is the polyline through its samples, checked like every other plan.

Differs from the paper: the gradient is that of the rule's exact margin, so no network is asked.
"""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import bezier_basis
from demospec.frames import FloatArray
from demospec.geometry import nearest
from demospec.planning._constraint import Constraint
from demospec.planning._cost_map import map_bounds
from demospec.planning._results import Zone

_SAMPLES = 81
"""Points of a curve."""

_GRID = 28
"""Control points along each side of the plane, which reaches 30 % beyond the table."""

REPAIR_STEPS = 30
_SHORTEN_ROUNDS = 30
_DIRECTIONS = np.stack(
    [np.cos(np.arange(12) * np.pi / 6), np.sin(np.arange(12) * np.pi / 6)], axis=1
)


def plan_in_latent_space(
    constraint: Constraint, start: FloatArray, goal: FloatArray, seed: int = 0
) -> FloatArray | None:
    """The shortest order-2 Bézier curve found that keeps the rule, (81, 2), or None.

    None is no proof: a way that needs two bends is no order-2 curve.
    """
    bounds = np.asarray(map_bounds(constraint.scene, constraint.zones))
    low, high = bounds[:2], bounds[2:]
    reach = high - low
    side = np.linspace(-0.3, 1.3, _GRID)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    grid = grid + np.random.default_rng(seed).uniform(-0.5, 0.5, grid.shape) * (side[1] - side[0])
    control = np.concatenate([(start + goal)[None] / 2, low + grid * reach])
    margin = _margins(constraint.zones, bounds, _curves(start, goal, control))
    if not (margin >= 0).any():
        best = np.argsort(-margin)[:40]
        control = _repaired(constraint.zones, bounds, start, goal, control[best])
        margin = _margins(constraint.zones, bounds, _curves(start, goal, control))
    kept = np.flatnonzero(margin >= 0)
    order = kept[np.argsort(_lengths(_curves(start, goal, control[kept])))]
    for candidate in control[order[:5]]:
        theta = _shortened(constraint.zones, bounds, start, goal, candidate, reach.max() / 20)
        for curve in _curves(start, goal, np.stack([theta, candidate])):
            if constraint.check(curve).obeys:
                return np.asarray(curve)
    return None


def _curves(start: FloatArray, goal: FloatArray, control: FloatArray) -> FloatArray:
    """Bz⁻¹ of every control point, (n, 81, 2)."""
    ends, inner = bezier_basis(2, _SAMPLES)
    return np.asarray((ends @ np.stack([start, goal]))[None] + inner[None] * control[:, None])


def _lengths(curves: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(*np.moveaxis(np.diff(curves, axis=1), 2, 0)).sum(axis=1))


def _margins(zones: tuple[Zone, ...], bounds: FloatArray, curves: FloatArray) -> FloatArray:
    """(n,) smallest margin of each curve to zones and to the table's edge.

    A curve between two samples comes nearer than they are by at most a little: half the
    sagitta of its bend, which a thousandth of the table's width outweighs.
    """
    edge = np.minimum(curves - bounds[:2], bounds[2:] - curves).min(axis=(1, 2))
    least = np.where(edge < 0, edge, np.inf)
    for zone in zones:
        gap = zone.shape.signed_distance(curves).min(axis=1) - zone.radius
        least = np.minimum(least, gap)
    slack = 1e-3 * float((bounds[2:] - bounds[:2]).max()) if zones else 0.0
    return np.asarray(np.where(np.isfinite(least) & (edge >= 0), least - slack, least))


def _repaired(
    zones: tuple[Zone, ...],
    bounds: FloatArray,
    start: FloatArray,
    goal: FloatArray,
    control: FloatArray,
) -> FloatArray:
    """Gradient steps on z_θ that raise the smallest margin of each curve."""
    _, inner = bezier_basis(2, _SAMPLES)
    control = control.copy()
    step = float((bounds[2:] - bounds[:2]).max()) / 50
    for _ in range(REPAIR_STEPS):
        curves = _curves(start, goal, control)
        gaps = np.stack([z.shape.signed_distance(curves) - z.radius for z in zones])
        row = np.arange(len(control))
        worst = gaps.min(axis=2).argmin(axis=0)
        at = gaps[worst, row].argmin(axis=1)
        for k, zone in enumerate(zones):
            mine = np.flatnonzero(worst == k)
            if len(mine):
                _, away = nearest(zone.shape, curves[mine, at[mine]])
                # ∂margin/∂θ = (∂point/∂θ)ᵀ ∂margin/∂point; only its direction is used.
                control[mine] += step * away * np.sign(inner[at[mine], 0])[:, None]
    return control


def _shortened(
    zones: tuple[Zone, ...],
    bounds: FloatArray,
    start: FloatArray,
    goal: FloatArray,
    control: FloatArray,
    step: float,
) -> FloatArray:
    """Pattern search on z_θ for a shorter curve with margin ≥ 0."""
    best = float(_lengths(_curves(start, goal, control[None]))[0])
    for _ in range(_SHORTEN_ROUNDS):
        trial = control + step * _DIRECTIONS
        curves = _curves(start, goal, trial)
        length = np.where(_margins(zones, bounds, curves) >= 0, _lengths(curves), np.inf)
        if length.min() < best * (1 - 1e-9):
            best, control = float(length.min()), trial[int(length.argmin())]
        else:
            step /= 2
    return control
