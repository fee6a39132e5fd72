"""Covariates of demonstrations: what people may judge by besides distance to listed classes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.frames import FloatArray
from demospec.rules._residuals import Covariate, groups
from demospec.rules.constraints._constraint import Constraint
from demospec.rules.constraints.features._registry import path_features

_OF_TABLE = ("edge",)  # of the path in its scene, not of the path as such: `place` speaks of it
_SIDES = ("+x", "-x", "+y", "-y")
_PLACES = ("mean x", "mean y", "least x", "least y", "greatest x", "greatest y")
_POINTS = 120  # a path is thinned to about so many points for the scan
_NEAR = (0.05, 0.1, 0.2)
_COUNTS = ("small (few things near)", "large (many things near)")
_CLASSES = 12  # classes beyond this have no covariates of sides and groups of their own


def covariates_of(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    symbols: Sequence[str],
    distance: FloatArray,
    extent: float,
) -> list[Covariate]:
    """Covariates of some demonstrations of a set.

    Args:
        rows: (n,) demonstrations, in the order in which they were labelled.
        symbols: K classes.
        distance: (n, K) nearest distances, set units.
        extent: Length of the table, set units; things within `_NEAR` of it count as near.
    """
    d, n = data.demonstrations, len(rows)
    out: list[Covariate] = []
    paths = [d.points(int(i)) for i in rows]
    motions = data.motions(rows).motions
    scenes = [data.scene(name) for name in d.scene_id[rows].tolist()]
    for feature in path_features():
        if feature.of != "nothing" or feature.name in _OF_TABLE:
            continue
        asked = Constraint(feature.name, sense=feature.senses[0])
        value = np.array(
            [feature.read(m, s, asked).value for m, s in zip(motions, scenes, strict=True)]
        )
        if np.isfinite(value).any():
            out.append(Covariate(feature.name, None, value, feature.low, feature.high))
    where = np.stack([_place(p) for p in paths])
    out += [Covariate("place", None, where[:, j], f"small ({w})", f"large ({w})")
            for j, w in enumerate(_PLACES)]  # fmt: skip
    radii = [share * extent for share in _NEAR]
    side, count = _by_side(data, rows, paths, symbols, radii)
    out += [Covariate("count", None, column, *_COUNTS) for column in count.T]
    few = list(enumerate(symbols))[:_CLASSES]
    for k, symbol in few:
        column = np.where(np.isfinite(distance[:, k]), distance[:, k], np.nan)
        out.append(Covariate("distance", symbol, column, "small", "large"))
        for s, word in enumerate(_SIDES):
            value = np.where(np.isfinite(side[:, k, s]), side[:, k, s], np.nan)
            out.append(Covariate("side", symbol, value, f"small on {word}",
                                 f"large on {word}"))  # fmt: skip
    order = np.arange(n, dtype=np.float64)
    out.append(Covariate("order", None, order, "early", "late"))
    halves = {"early": order < n / 2, "late": order >= n / 2}
    out += _within("order", halves, few, distance)
    people = groups(d.demonstrator[rows])
    for name, mine in people.items():
        out.append(Covariate("demonstrator", None, mine.astype(np.float64), "another", name))
    out += _within("demonstrator", people, few, distance)
    return out


def _place(points: FloatArray) -> FloatArray:
    """(6,) where a path lies: mean x and y, least and greatest x and y; set units."""
    xy = points[:, :2]
    return np.concatenate([xy.mean(axis=0), xy.min(axis=0), xy.max(axis=0)])


def _within(
    feature: str,
    parts: dict[str, NDArray[np.bool_]],
    classes: Sequence[tuple[int, str]],
    distance: FloatArray,
) -> list[Covariate]:
    """Distances to each class among one part of the demonstrations: parts that differ in rule."""
    return [
        Covariate(
            feature,
            symbol,
            np.where(mine & np.isfinite(distance[:, k]), distance[:, k], np.nan),
            f"{name} and near",
            f"{name} and far",
        )
        for name, mine in parts.items()
        for k, symbol in classes
    ]


def _by_side(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    paths: Sequence[FloatArray],
    symbols: Sequence[str],
    radii: Sequence[float],
) -> tuple[FloatArray, FloatArray]:
    """(n, K, 4) least distance on each side of the things of a class, +inf where no path point
    lies there; (n, radii) number of things that a path comes within each radius of."""
    side = np.full((len(rows), len(symbols), 4), np.inf)
    count = np.zeros((len(rows), len(radii)))
    column = {symbol: k for k, symbol in enumerate(symbols)}
    ids = data.demonstrations.scene_id[rows]
    for scene_id in dict.fromkeys(ids.tolist()):
        objects = data.scene(scene_id).objects or ()
        mine = np.flatnonzero(ids == scene_id)
        thinned = [_thinned(paths[i][:, :2]) for i in mine.tolist()]
        points = np.concatenate(thinned)
        starts = np.concatenate([[0], np.cumsum([len(p) for p in thinned])[:-1]])
        for item in objects:
            gap = item.outline.signed_distance(points)
            nearest = np.minimum.reduceat(gap, starts)
            count[mine] += nearest[:, None] < np.asarray(radii)
            k = column.get(item.symbol)
            if k is None:
                continue
            offset = points - np.asarray(item.center)
            halves = (offset[:, 0] > 0, offset[:, 0] < 0, offset[:, 1] > 0, offset[:, 1] < 0)
            for s, half in enumerate(halves):
                least = np.minimum.reduceat(np.where(half, gap, np.inf), starts)
                side[mine, k, s] = np.minimum(side[mine, k, s], least)
    return side, count


def _thinned(points: FloatArray) -> FloatArray:
    if len(points) >= _POINTS:
        return points[np.linspace(0, len(points) - 1, _POINTS).round().astype(np.int64)]
    pieces = max(1, _POINTS // max(len(points) - 1, 1))
    if pieces == 1 or len(points) < 2:
        return points
    share = np.arange(pieces) / pieces
    inner = points[:-1, None] + share[None, :, None] * np.diff(points, axis=0)[:, None]
    return np.concatenate([inner.reshape(-1, 2), points[-1:]])
