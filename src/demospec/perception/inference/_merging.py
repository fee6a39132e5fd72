"""Joining fragments: a ladle whose handle is seen apart from its bowl is one thing.

Whether two parts beside each other are one cannot be read off their distance alone: a fork
lies beside a plate as a handle lies before its spoon. How they point at each other, what lies
between them and what each looks like tells it. A logistic regression learns this from parts of
generated pictures, where the truth is known; it is part of the body's weights.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._observation import CANONICAL_PX, Float32Array
from demospec.perception.heads._logistic import standard
from demospec.perception.synthetic._things import KINDS
from demospec.perception.training._synthetic_set import fitted, keep, lessons, shown_thing
from demospec.progress import Progress, silent

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import Body

HIGHEST = 2.0
"""Parts are never one thing if every way between them leads further than this from what is
seen (hundredths of the table)."""

PICTURES = 1000
"""Generated pictures whose parts teach the joiner."""

_LONG_RICH = (0.06, 0.12, 0.1, 0.5, 0.1, 0.06, 0.06)  # shares of `KINDS`
_LONG = KINDS.index("long")
_STEP = 0.1
PAIR_FEATURES = 19


@dataclass(frozen=True)
class Fragment:
    """A connected part of predicted distance below zero.

    Args:
        mask: (h, w).
        rim: (k, 2) the centres of its pixels (x, y).
        center: Centre of its pixels.
        axis: Unit vector along it.
        half: Half its extent along and across the axis, standard deviations × 2.
        depth: Largest inner distance.
        long: Mean probability of a long thing.
        colour: Mean colour.
    """

    mask: NDArray[np.bool_]
    rim: FloatArray
    center: FloatArray
    axis: FloatArray
    half: FloatArray
    depth: float
    long: float
    colour: FloatArray

    @classmethod
    def of(cls, mask: NDArray[np.bool_], answers: Float32Array, planes: Float32Array) -> Fragment:
        """Measures one part of the answers (12, h, w) to a picture (3, h, w)."""
        rows, columns = np.nonzero(mask)
        points = np.column_stack([columns, rows]).astype(np.float64) + 0.5
        center = points.mean(axis=0)
        spread = np.cov(points.T, bias=True) + np.eye(2) / 12
        value, vector = np.linalg.eigh(spread)
        return cls(
            mask, points, center, vector[:, 1], 2.0 * np.sqrt(value[::-1]),
            float(-answers[0][mask].min()), float(_word(answers[5:, mask]).mean()),
            planes[:, mask].mean(axis=1).astype(np.float64),
        )  # fmt: skip


def _word(scores: NDArray[np.floating]) -> FloatArray:
    """(7, …) scores of the words → probability of a long thing."""
    p = np.exp(scores - scores.max(axis=0))
    return np.asarray(p[_LONG] / p.sum(axis=0), np.float64)


def nearest_points(a: Fragment, b: Fragment) -> tuple[FloatArray, FloatArray]:
    """Of each the pixel centre that is nearest to the other."""
    from scipy.spatial import cKDTree

    gap, index = cKDTree(b.rim).query(a.rim)
    k = int(np.argmin(gap))
    return a.rim[k], b.rim[index[k]]


def saddles(
    fragments: Sequence[Fragment], answers: Float32Array, unit_px: float = 1.0
) -> FloatArray:
    """(n, n) the highest distance on the lowest way from one part to the other.

    In hundredths of the table, of which one takes `unit_px` map pixels; in steps of `_STEP` up to
    `HIGHEST`, above that (and on the diagonal) infinite.
    """
    from scipy.ndimage import label

    out = np.full((len(fragments), len(fragments)), np.inf)
    if len(fragments) < 2:
        return out
    y, x = (np.array([part.rim[0] for part in fragments]) - 0.5).astype(np.int64).T[::-1]
    for level in np.arange(HIGHEST, 0.0, -_STEP):
        at = label(answers[0] < level * unit_px, structure=np.ones((3, 3)))[0][y, x]
        out[at[:, None] == at] = level
    np.fill_diagonal(out, np.inf)
    return out


def pairs(
    fragments: Sequence[Fragment], answers: Float32Array, unit_px: float = 1.0
) -> Iterator[tuple[int, int, FloatArray]]:
    """Pairs that may be one thing, with their features (`PAIR_FEATURES`,)."""
    low = saddles(fragments, answers, unit_px)
    for i, j in combinations(range(len(fragments)), 2):
        if np.isfinite(low[i, j]):
            found = pair_features(fragments[i], fragments[j], answers, float(low[i, j]), unit_px)
            yield i, j, found


def pair_features(
    a: Fragment, b: Fragment, answers: Float32Array, saddle: float, unit_px: float = 1.0
) -> FloatArray:
    """(`PAIR_FEATURES`,) of two parts, in either order; `saddle` as `saddles` gives it.

    Lengths among them are in hundredths of the table.
    """
    stick, head = (a, b) if a.half[0] / a.half[1] >= b.half[0] / b.half[1] else (b, a)
    here, there = nearest_points(stick, head)
    step = there - here
    gap = float(np.hypot(*step)) / unit_px
    at = here + np.linspace(0.0, 1.0, 8)[:, None] * step
    column, row = np.minimum(at.astype(np.int64), np.array(answers.shape[:0:-1]) - 1).T
    between = answers[:, row, column]
    # The head as the stick sees it: how far off its axis, and at its tip or at its side.
    along = stick.axis
    to_head = head.center - stick.center
    off = abs(float(along[0] * to_head[1] - along[1] * to_head[0])) / unit_px
    tip = abs(float((here - stick.center) @ along)) / (stick.half[0] + 0.5 * unit_px)
    aim = abs(float(to_head @ along)) / (np.hypot(*to_head) + 1e-6)
    line = abs(float(head.axis @ along))
    slim = head.half[1] / head.half[0]
    size = np.sqrt(head.half.prod()) / unit_px
    highest = float(between[0].max()) / unit_px
    return np.array(
        [
            min(gap, 12.0), saddle, min(highest, 4.0),
            np.log(stick.half[0] / stick.half[1]), np.log(stick.half[1] / unit_px),
            np.log(head.half[0] / head.half[1]), np.log(size),
            min(stick.depth / unit_px, 3.0), min(head.depth / unit_px, 3.0),
            stick.long, head.long, stick.long * head.long, float(_word(between[5:]).min()),
            tip, aim, aim * tip, min(off, 10.0), line * (1 - slim),
            float(np.abs(stick.colour - head.colour).mean()),
        ]
    )  # fmt: skip


@dataclass(frozen=True)
class Joiner:
    """Features of a pair → probability that both parts are one thing.

    Args:
        center, scale: Standardisation, (`PAIR_FEATURES`,).
        weight: (`PAIR_FEATURES`,).
        bias: Log-odds of an average pair.
    """

    center: FloatArray
    scale: FloatArray
    weight: FloatArray
    bias: float

    @classmethod
    def of(cls, body: Body) -> Joiner:
        """The joiner among a body's weights."""
        state = dict(body.named_buffers())
        center, scale, weight, bias = (
            state[f"joiner_{name}"].numpy().astype(np.float64)
            for name in ("center", "scale", "weight", "bias")
        )
        return cls(center, scale, weight, float(bias[0]))

    def probability(self, features: FloatArray) -> float:
        """Of one pair."""
        z = standard(features[None], self.center, self.scale)[0]
        return float(1.0 / (1.0 + np.exp(-(z @ self.weight + self.bias))))


@dataclass(frozen=True)
class Bridge:
    """What was not seen between two fragments of one thing.

    Args:
        ends: (2, 2) pixel centres, one in each.
        radius: Half its width.
    """

    ends: FloatArray
    radius: float

    def distance(self, shape: tuple[int, ...]) -> FloatArray:
        """(h, w) signed distance to the capsule."""
        from demospec.perception.synthetic._shapes import capsule

        y, x = (np.mgrid[0 : shape[0], 0 : shape[1]] + 0.5).astype(np.float32)
        (x0, y0), (x1, y1) = self.ends.tolist()
        return capsule(x, y, x0, y0, x1, y1, self.radius, self.radius).astype(np.float64)


def joined(
    fragments: Sequence[Fragment], answers: Float32Array, joiner: Joiner, unit_px: float = 1.0
) -> list[tuple[list[int], list[Bridge]]]:
    """Which fragments are one thing: their numbers, and what lies between them.

    Likely pairs first; a pair within a group that others have joined adds no bridge.
    """
    likely = []
    for i, j, features in pairs(fragments, answers, unit_px):
        p = joiner.probability(features)
        if p > 0.5:
            likely.append((p, i, j))
    group = list(range(len(fragments)))
    bridges: dict[int, list[Bridge]] = {}
    for _, i, j in sorted(likely, reverse=True):
        low, high = sorted((group[i], group[j]))
        if low == high:
            continue
        a, b = fragments[i], fragments[j]
        radius = float(np.clip(min(a.depth, b.depth), 0.3 * unit_px, unit_px))
        new = Bridge(np.array(nearest_points(a, b)), radius)
        bridges[low] = [*bridges.get(low, []), *bridges.pop(high, []), new]
        group = [low if g == high else g for g in group]
    members: dict[int, list[int]] = {}
    for i, g in enumerate(group):
        members.setdefault(g, []).append(i)
    return [(numbers, bridges.get(g, [])) for g, numbers in members.items()]


def fit_joiner(
    body: Body,
    seed: int,
    *,
    pictures: int = PICTURES,
    rendered: float,
    size_px: int = CANONICAL_PX,
    progress: Progress = silent,
) -> None:
    """Fits the joiner to parts of generated pictures, rich in long things; changes `body`.

    Args:
        body: Ready for inference.
        seed: Of the pictures (apart from those of a training with the same seed).
        rendered: Share of rendered pictures.
    """
    from demospec.perception.inference._observe import fragments_seen, table_px

    unit = table_px(body) / 100.0
    found: list[FloatArray] = []
    same: list[bool] = []
    for picture, truth in lessons(
        3_000_000 + seed, pictures, size_px, rendered, shares=_LONG_RICH,
        what="learning to join fragments", progress=progress,
    ):  # fmt: skip
        fragments, answers = fragments_seen(picture, body)
        owner = [_owner(truth[6][part.mask]) for part in fragments]
        for i, j, features in pairs(fragments, answers, unit):
            if owner[i] >= 0 or owner[j] >= 0:
                found.append(features)
                same.append(owner[i] == owner[j])
    if len(set(same)) < 2:
        return  # too few pictures to see both: nothing is joined
    values = fitted(np.stack(found), np.array(same, np.int64), 2)
    # Of two classes only the difference counts.
    for name in ("weight", "bias"):
        values[name] = np.diff(values[name], axis=0)[0]
    keep(body, "joiner", values)


def _owner(number: NDArray[np.floating]) -> int:
    """The thing that most of a part shows; −1 where most of it is table."""
    share, thing = shown_thing(number)
    return thing if share >= 0.5 else -1
