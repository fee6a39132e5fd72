"""One demonstration, and many of them held in columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

MAX_COORDINATE = 1e9
"""Coordinates beyond this are refused: squares of them no longer fit the solver's integers."""

LEAST_SCALE, MAX_SCALE = 1e-12, 1e9
"""Metres per unit outside this are refused: lengths in metres would no longer be numbers."""

MAX_POINTS = 500_000
"""Paths of more points are refused: eight minutes at 1 kHz say no more than a thinned path."""


def checked_points(points: ArrayLike, columns: int | None = None) -> FloatArray:
    """Points of one path as a read-only float array (n, d), n ≥ 1, d ≥ 2.

    Raises:
        InputError: Not such an array, not finite, or beyond `MAX_COORDINATE`.
    """
    expected = f"a list of [{'x, y' if columns in (None, 2) else f'{columns} numbers'}] points"
    try:
        array = np.array(points, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(expected, "something else", field="points") from error
    if array.ndim != 2 or array.shape[0] < 1 or array.shape[1] < 2:
        raise InputError(expected, f"shape {array.shape}", field="points")
    if columns is not None and array.shape[1] != columns:
        raise InputError(expected, f"{array.shape[1]} numbers a point", field="points")
    wrong = ~(np.abs(array) <= MAX_COORDINATE)  # also true for NaN
    if wrong.any():
        i, j = np.argwhere(wrong)[0]
        expected = f"finite numbers of size at most {MAX_COORDINATE:.0e}"
        raise InputError(expected, f"{array[i, j]} in point {i}", field="points")
    array.setflags(write=False)
    return array


def first_and_last_motion(points: FloatArray) -> BoolArray:
    """(n,) points of one path (n, 2) to keep so that it does not stand still at its ends."""
    moves = np.flatnonzero((np.diff(points, axis=0) != 0).any(axis=1))
    keep = np.zeros(len(points), dtype=bool)
    if len(moves):
        keep[moves[0] : moves[-1] + 2] = True
    else:
        keep[0] = True
    return keep


@dataclass(frozen=True)
class Demonstration:
    """One path through one scene, as somebody demonstrated it.

    Args:
        demo_id: Unique in its set.
        scene_id: The scene it was shown in.
        points: (n, d), n ≥ 1; x, y first, pixels; further columns as the set names them.
        type: User type (``careful``, …), or None where nobody said.
        demonstrator: Who showed it, or None.
        valid: Accepted, rejected, or None where nobody said.
        t: Seconds, shape (n,), or None.
        score: How acceptable, from 0 to 1, or None. Without a verdict beside it, one half and
            more is accepted.
    """

    demo_id: str
    scene_id: str
    points: FloatArray
    type: str | None = None
    demonstrator: str | None = None
    valid: bool | None = None
    t: FloatArray | None = None
    score: float | None = None

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Demonstration):
            return NotImplemented
        same_t = (self.t is None) == (other.t is None) and (
            self.t is None or np.array_equal(self.t, np.asarray(other.t))
        )
        mine, theirs = (
            (d.demo_id, d.scene_id, d.type, d.demonstrator, d.valid, d.score) for d in (self, other)
        )
        return mine == theirs and same_t and np.array_equal(self.points, other.points)

    def __hash__(self) -> int:
        return hash(self.demo_id)

    @property
    def xy(self) -> FloatArray:
        """(n, 2), pixels."""
        return self.points[:, :2]


class Demonstrations(Sequence[Demonstration]):
    """Demonstrations in columns: one flat array of points and an offset per path.

    Args:
        demo_id, scene_id: String arrays, shape (n,).
        type, demonstrator: Object arrays of str or None, shape (n,).
        valid: int8, shape (n,): 1 accepted, 0 rejected, -1 not said.
        flat: (N, d) float64, the points of all paths in a row.
        offsets: (n + 1,) int64; path i is ``flat[offsets[i]:offsets[i + 1]]``.
        t: (N,) float64 with NaN where a path has no time stamps, or None where none has.
        score: (n,) how acceptable, in [0, 1]; NaN where there is a verdict only. None where no
            path has one.
    """

    def __init__(
        self,
        *,
        demo_id: NDArray[np.object_],
        scene_id: NDArray[np.object_],
        type: NDArray[np.object_],
        demonstrator: NDArray[np.object_],
        valid: NDArray[np.int8],
        flat: FloatArray,
        offsets: IntArray,
        t: FloatArray | None = None,
        score: FloatArray | None = None,
    ) -> None:
        self.demo_id = demo_id
        self.scene_id = scene_id
        self.type = type
        self.demonstrator = demonstrator
        self.valid = valid
        self.flat = flat
        self.offsets = offsets
        self.t = t
        self.score = score

    @classmethod
    def of(cls, items: Sequence[Demonstration], columns: int = 2) -> Demonstrations:
        """The same demonstrations, in columns. All have `columns` numbers a point."""
        counts = [len(item.points) for item in items]
        has_t = any(item.t is not None for item in items)
        t = None
        if has_t:
            parts = [
                np.full(n, np.nan) if item.t is None else item.t
                for item, n in zip(items, counts, strict=True)
            ]
            t = np.concatenate(parts)
        for item in items:
            if item.points.shape[1] != columns:
                found = f"{item.points.shape[1]} in demonstration {item.demo_id}"
                raise InputError(f"{columns} numbers a point", found, field="points")
        return cls(
            demo_id=_objects([i.demo_id for i in items]),
            scene_id=_objects([i.scene_id for i in items]),
            type=_objects([i.type for i in items]),
            demonstrator=_objects([i.demonstrator for i in items]),
            valid=np.array([_verdict(i) for i in items], np.int8),
            flat=np.concatenate([i.points for i in items]) if items else np.empty((0, columns)),
            offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            t=t,
            score=None
            if all(i.score is None for i in items)
            else np.array([np.nan if i.score is None else i.score for i in items]),
        )

    def __len__(self) -> int:
        return len(self.demo_id)

    def points(self, i: int) -> FloatArray:
        """(n_i, d) view of path `i`."""
        return self.flat[self.offsets[i] : self.offsets[i + 1]]

    def paths_xy(self, rows: Sequence[int] | IntArray | None = None) -> list[FloatArray]:
        """The x, y of the chosen paths (all by default), as views (n_i, 2)."""
        chosen = range(len(self)) if rows is None else rows
        return [self.points(int(i))[:, :2] for i in chosen]

    @overload
    def __getitem__(self, index: int) -> Demonstration: ...
    @overload
    def __getitem__(self, index: slice) -> Demonstrations: ...
    def __getitem__(self, index: int | slice) -> Demonstration | Demonstrations:
        if isinstance(index, slice):
            return self.rows(np.arange(len(self))[index])
        i = range(len(self))[index]
        t = None
        if self.t is not None:
            stamps = self.t[self.offsets[i] : self.offsets[i + 1]]
            t = None if np.isnan(stamps).any() else stamps
        return Demonstration(
            demo_id=self.demo_id[i],
            scene_id=self.scene_id[i],
            points=self.points(i),
            type=self.type[i],
            demonstrator=self.demonstrator[i],
            valid=None if self.valid[i] < 0 else bool(self.valid[i]),
            t=t,
            score=None if self.score is None or np.isnan(self.score[i]) else float(self.score[i]),
        )

    def __iter__(self) -> Iterator[Demonstration]:
        return (self[i] for i in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Demonstrations):
            return NotImplemented
        return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def rows(self, chosen: ArrayLike) -> Demonstrations:
        """The demonstrations of a boolean mask (n,) or of integer rows, in that order."""
        index = np.asarray(chosen)
        if index.dtype == np.bool_:
            index = np.flatnonzero(index)
        index = index.astype(np.int64)
        counts = (self.offsets[1:] - self.offsets[:-1])[index]
        offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        # Position of every kept point in `flat`, without a loop over paths.
        take = np.repeat(self.offsets[index] - offsets[:-1], counts) + np.arange(offsets[-1])
        return Demonstrations(
            demo_id=self.demo_id[index],
            scene_id=self.scene_id[index],
            type=self.type[index],
            demonstrator=self.demonstrator[index],
            valid=self.valid[index],
            flat=self.flat[take],
            offsets=offsets,
            t=None if self.t is None else self.t[take],
            score=None if self.score is None else self.score[index],
        )


def joined(parts: Sequence[Demonstrations]) -> Demonstrations:
    """All demonstrations in a row."""
    shift = np.cumsum([0, *(len(p.flat) for p in parts)])
    offsets = [p.offsets[1:] + s for p, s in zip(parts, shift, strict=False)]
    t: FloatArray | None = None
    if any(p.t is not None for p in parts):
        t = np.concatenate([np.full(len(p.flat), np.nan) if p.t is None else p.t for p in parts])
    score: FloatArray | None = None
    if any(p.score is not None for p in parts):
        score = np.concatenate(
            [np.full(len(p), np.nan) if p.score is None else p.score for p in parts]
        )
    return Demonstrations(
        demo_id=np.concatenate([p.demo_id for p in parts]),
        scene_id=np.concatenate([p.scene_id for p in parts]),
        type=np.concatenate([p.type for p in parts]),
        demonstrator=np.concatenate([p.demonstrator for p in parts]),
        valid=np.concatenate([p.valid for p in parts]),
        flat=np.concatenate([p.flat for p in parts]),
        offsets=np.concatenate([[0], *offsets]).astype(np.int64),
        t=t,
        score=score,
    )


def _verdict(item: Demonstration) -> int:
    """1 accepted, 0 rejected, -1 not said."""
    if item.valid is None:
        return -1 if item.score is None else int(item.score >= 0.5)
    return int(item.valid)


def _objects(values: Sequence[str | None]) -> NDArray[np.object_]:
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column
