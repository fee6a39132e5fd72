"""Bézier re-parameterization of paths: Bz (least squares, fixed end points) and Bz⁻¹.

Source: Angelov et al. 2020, "Bézier curve re-parameterization" (order 2, one control point
θ ∈ R²). Differs: any order ≥ 2, and the curve parameter of the data points is refined, so that
Bz recovers a Bézier curve exactly from its own samples.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations._trajectory import checked_points
from demospec.errors import InputError
from demospec.frames import FloatArray


@lru_cache(maxsize=256)
def _uniform_basis(order: int, n: int) -> FloatArray:
    basis = bernstein(order, np.linspace(0.0, 1.0, n))
    basis.setflags(write=False)
    return basis


def bernstein(order: int, u: ArrayLike) -> FloatArray:
    """Bernstein polynomials of `order` at u ∈ [0, 1]: shape (..., order + 1)."""
    t = np.asarray(u, dtype=np.float64)[..., None]
    k = np.arange(order + 1)
    binomial = np.array([comb(order, int(i)) for i in k], dtype=np.float64)
    return np.asarray(binomial * t**k * (1.0 - t) ** (order - k))


def bezier_basis(order: int, n: int) -> tuple[FloatArray, FloatArray]:
    """Linear map from control points to n samples at uniform parameter: Bz⁻¹ as matrices.

    Returns:
        (ends (n, 2), inner (n, order - 1)): points = ends @ [start, goal] + inner @ control.
        So ∂points/∂control is `inner`, which carries gradients from paths to z_θ.
    """
    if order < 2:
        raise InputError("a Bézier order of at least 2", order, field="order")
    basis = _uniform_basis(order, n)
    return basis[:, [0, -1]], basis[:, 1:-1]


def bezier_points(
    start: ArrayLike, goal: ArrayLike, control: ArrayLike, n: int = 100
) -> FloatArray:
    """Bz⁻¹: sample Bézier curves at n uniform parameters.

    Args:
        start, goal: (d,) or (..., d).
        control: Inner control points, (..., order - 1, d); (..., d) is taken as order 2.
        n: Points a curve, ≥ 2.

    Returns:
        (..., n, d).
    """
    c = np.asarray(control, dtype=np.float64)
    s, g = np.asarray(start, dtype=np.float64), np.asarray(goal, dtype=np.float64)
    if c.ndim == s.ndim:
        c = c[..., None, :]
    if c.shape[-2] < 1:
        raise InputError("a Bézier order of at least 2", c.shape[-2] + 1, field="order")
    lead = np.broadcast_shapes(s.shape[:-1], g.shape[:-1], c.shape[:-2])
    every = np.empty((*lead, c.shape[-2] + 2, s.shape[-1]))
    every[..., 0, :], every[..., 1:-1, :], every[..., -1, :] = s, c, g
    wide = _wide_basis(c.shape[-2] + 1, n, s.shape[-1])
    return np.asarray((every.reshape(-1, len(wide)) @ wide).reshape(*lead, n, s.shape[-1]))


def control_gradients(slopes: FloatArray, order: int) -> FloatArray:
    """∂/∂points (…, n, d) of Bézier curves → ∂/∂(inner control points) (…, order − 1, d)."""
    n, d = slopes.shape[-2:]
    lead = slopes.shape[:-2]
    inner = _wide_basis(order, n, d)[d:-d]
    return np.asarray((slopes.reshape(-1, n * d) @ inner.T).reshape(*lead, order - 1, d))


@lru_cache(maxsize=256)
def _wide_basis(order: int, n: int, d: int) -> FloatArray:
    """((order + 1)·d, n·d): all coordinates of all points by one matrix product a stack."""
    wide = np.asarray(np.kron(_uniform_basis(order, n).T, np.eye(d)), np.float64)
    wide.setflags(write=False)
    return wide


def fit_bezier(points: ArrayLike, order: int = 2, *, refine: int = 20) -> FloatArray:
    """Bz: inner control points of the least-squares Bézier curve with the path's own ends.

    Starts from uniform and from chord-length parameters and refines each by projecting the
    points onto the curve (Gauss-Newton on the parameter); the better fit wins.

    Args:
        points: (n, d), n ≥ 1. Paths of one or two points give the straight line.
        order: ≥ 2.
        refine: Rounds of refinement; 0 keeps the linear least squares.

    Returns:
        (order - 1, d).
    """
    p = checked_points(points)
    if order < 2:
        raise InputError("a Bézier order of at least 2", order, field="order")
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    chord = np.concatenate([[0.0], np.cumsum(steps)])
    line = p[0] + (p[-1] - p[0]) * (np.arange(1, order) / order)[:, None]
    if len(p) < 3 or chord[-1] == 0.0:
        return np.asarray(line)
    scale2 = float(np.abs(p).max()) ** 2
    best, best_error = np.asarray(line, dtype=np.float64), np.inf
    for start in (np.linspace(0.0, 1.0, len(p)), chord / chord[-1]):
        control, error = _refined(p, start, line, refine, 1e-22 * scale2)
        if error < best_error * (1 - 1e-9):
            best, best_error = control, error
        if error < 1e-22 * scale2:
            break
    return best


def _refined(
    p: FloatArray, u: FloatArray, line: FloatArray, rounds: int, enough: float
) -> tuple[FloatArray, float]:
    """Alternates least squares on the control points with projection of the parameters.

    A plain alternation creeps, because points may not slide along the curve while the control
    points move. So each later round discounts the residual along the curve's tangent by
    `slide` (Gauss-Newton with the parameters eliminated), less boldly where that failed.
    """
    control = _least_squares(p, u, line, None, 1.0)
    error = _error(p, u, control)
    slide = 0.1
    for _ in range(rounds):
        if error < enough or slide > 1.0:
            break
        tangent = bernstein(len(line), u) @ np.diff(_every(p, control), axis=0)
        trial = _least_squares(p, u, line, tangent, slide)
        trial_u = u
        for _ in range(3):
            trial_u = _project(p, trial_u, trial)
        trial_error = _error(p, trial_u, trial)
        if trial_error < error * (1 - 1e-9):
            control, u, error, slide = trial, trial_u, trial_error, max(slide / 3, 1e-4)
        else:
            slide *= 4
    return control, error


def _every(p: FloatArray, control: FloatArray) -> FloatArray:
    return np.asarray(np.concatenate([p[:1], control, p[-1:]]))


def _error(p: FloatArray, u: FloatArray, control: FloatArray) -> float:
    return float(((p - bernstein(len(control) + 1, u) @ _every(p, control)) ** 2).sum())


def _least_squares(
    p: FloatArray, u: FloatArray, line: FloatArray, tangent: FloatArray | None, slide: float
) -> FloatArray:
    """Control points that fit p at parameters u, tangential residuals weighted by `slide`."""
    basis = bernstein(len(line) + 1, u)
    inner = basis[:, 1:-1]
    # Few points on a high order leave the system short of rank: minimum norm about the line.
    rest = p - basis[:, :1] * p[0] - basis[:, -1:] * p[-1] - inner @ line
    if tangent is None:
        delta, *_ = np.linalg.lstsq(inner, rest, rcond=None)
        return np.asarray(line + delta)
    n, d = p.shape
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    unit = tangent / np.where(length > 0, length, 1.0)
    weight = np.eye(d) - (1.0 - slide) * unit[:, :, None] * unit[:, None, :]
    system = np.einsum("nij,nk->nikj", weight, inner).reshape(n * d, -1)
    right = np.einsum("nij,nj->ni", weight, rest).reshape(n * d)
    delta, *_ = np.linalg.lstsq(system, right, rcond=None)
    return np.asarray(line + delta.reshape(line.shape))


def _project(p: FloatArray, u: FloatArray, control: FloatArray) -> FloatArray:
    """One Gauss-Newton step of every parameter towards the nearest point of the curve."""
    every = _every(p, control)
    order = len(every) - 1
    at = bernstein(order, u) @ every
    slope = bernstein(order - 1, u) @ (np.diff(every, axis=0) * order)
    speed2 = (slope**2).sum(axis=1)
    step = ((p - at) * slope).sum(axis=1) / np.where(speed2 > 0, speed2, np.inf)
    moved = np.maximum.accumulate(np.clip(u + step, 0.0, 1.0))
    moved[0], moved[-1] = 0.0, 1.0
    return np.asarray(moved)


def resample(points: ArrayLike, n: int) -> FloatArray:
    """n points at equal arc length along a path (n_in, d), ends kept; all columns interpolated.

    A path without length repeats its point.
    """
    p = checked_points(points)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p[:, :2], axis=0), axis=1))])
    if len(p) == 1 or length[-1] == 0.0:
        return np.repeat(p[:1], n, axis=0)
    at = np.linspace(0.0, length[-1], n)
    return np.stack([np.interp(at, length, column) for column in p.T], axis=1)


def densify(points: ArrayLike, spacing: float | None = None) -> FloatArray:
    """The path's own points plus points between them, no two further apart than `spacing`.

    Args:
        spacing: Set units; by default a four hundredth of the path's longer side.
    """
    p = checked_points(points)
    side = float(np.ptp(p[:, :2], axis=0).max())
    if len(p) == 1 or side == 0:
        return p
    if spacing is None:
        spacing = side / 400
    steps = np.linalg.norm(np.diff(p[:, :2], axis=0), axis=1)
    pieces = np.clip(np.ceil(steps / spacing), 1, 1_000_000).astype(np.int64)
    segment = np.repeat(np.arange(len(pieces)), pieces)
    first = np.concatenate([[0], np.cumsum(pieces)[:-1]])
    fraction = (np.arange(len(segment)) - first[segment]) / pieces[segment]
    inner = p[segment] + fraction[:, None] * (p[segment + 1] - p[segment])
    return np.asarray(np.concatenate([inner, p[-1:]]))
