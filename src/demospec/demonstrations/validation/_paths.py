"""What is odd about paths, though legal: resting ends, uneven sampling, duplicates, and so on."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations._trajectory import BoolArray, Demonstrations, IntArray
from demospec.frames import FloatArray
from demospec.scene import Scene

FAR_FROM_END = 0.1
"""A path begins (ends) elsewhere if it does so further than this share of |start − goal| away."""
UNEVEN = 10.0
"""A path is unevenly sampled if its longest step exceeds its median step this many times."""
RESTING = 0.1
"""A path rests if it spends more than this share of its points on its first (last) point."""


@dataclass
class Oddity:
    """One kind of oddity: how often, and the first few rows with a word about each."""

    kind: str
    field: str
    expected: str
    count: int = 0
    examples: list[tuple[int, str]] = dataclasses.field(default_factory=list)


@dataclass
class SceneTable:
    """What the checks need of the scenes, in arrays; n scenes.

    Args:
        start, goal: (n, 2), pixels.
        size: (n, 2) width and height of the picture, inf without one.
    """

    start: FloatArray
    goal: FloatArray
    size: FloatArray

    @classmethod
    def of(cls, scenes: list[Scene]) -> SceneTable:
        sizes = [s.size_px or (np.inf, np.inf) for s in scenes]
        return cls(
            np.array([s.start[:2] for s in scenes], dtype=np.float64).reshape(-1, 2),
            np.array([s.goal[:2] for s in scenes], dtype=np.float64).reshape(-1, 2),
            np.array(sizes, dtype=np.float64).reshape(-1, 2),
        )


class PathOddities:
    """Collects the oddities of paths, batch by batch."""

    def __init__(self, scenes: SceneTable, listed: int) -> None:
        self.scenes = scenes
        self.listed = listed
        self.found: dict[str, Oddity] = {}
        self._keys: list[IntArray] = []
        self._rows: list[IntArray] = []
        self._labels: list[NDArray[np.int8]] = []
        self._flipped = 0

    def add(self, part: Demonstrations, scene_of: IntArray, rows: IntArray) -> None:
        """Looks at some demonstrations.

        Args:
            part: n demonstrations.
            scene_of: (n,) place of each one's scene in the table, -1 where unknown.
            rows: (n,) row of each in the file.
        """
        self._steps(part, rows)
        known = scene_of >= 0
        self._ends(part, np.where(known, scene_of, 0), known, rows)
        self._outside(part, np.where(known, scene_of, 0), known, rows)
        self._times(part, rows)
        self._keys.append(_path_keys(part))
        self._rows.append(rows)
        self._labels.append(part.valid)

    def finish(self) -> list[Oddity]:
        """Everything found, after the last batch."""
        self._duplicates()
        return list(self.found.values())

    def note(
        self, kind: str, field: str, expected: str, rows: IntArray, words: list[str] | None = None
    ) -> None:
        if not len(rows):
            return
        oddity = self.found.setdefault(kind, Oddity(kind, field, expected))
        oddity.count += len(rows)
        for i in range(min(len(rows), self.listed - len(oddity.examples))):
            oddity.examples.append((int(rows[i]), words[i] if words else kind.replace("_", " ")))

    def _words(self, pattern: str, values: FloatArray) -> list[str]:
        return [pattern.format(v) for v in values[: self.listed]]

    def _steps(self, part: Demonstrations, rows: IntArray) -> None:
        counts = np.diff(part.offsets)
        path = np.repeat(np.arange(len(part)), counts)
        step = np.hypot(*np.diff(part.flat[:, :2], axis=0).T)
        inner = path[1:] == path[:-1] if len(path) else np.zeros(0, dtype=bool)
        step, owner = step[inner], path[1:][inner]
        n_steps = counts - 1
        total = np.bincount(owner, weights=step, minlength=len(part))
        still = total == 0
        self.note("no_motion", "points", "a path that moves", rows[still])
        first = np.concatenate([[0], np.cumsum(n_steps)[:-1]]).astype(np.int64)
        moving = ~still
        longest, median = np.zeros(len(part)), np.ones(len(part))
        if len(step):
            has = n_steps > 0
            longest[has] = np.maximum.reduceat(step, first[has])
            order = np.lexsort((step, owner))
            median[has] = step[order][first[has] + (n_steps[has] - 1) // 2]
        ratio = longest / np.where(median > 0, median, np.inf)
        uneven = moving & (ratio > UNEVEN)
        self.note(
            "uneven_sampling",
            "points",
            f"steps of about one length (longest ≤ {UNEVEN:g} × median)",
            rows[uneven],
            self._words("the longest step is {:.0f} times the median one", ratio[uneven]),
        )
        head, tail = _rest(part, owner, step, first, n_steps)
        resting = moving & (head + tail > np.maximum(2, RESTING * counts))
        self.note(
            "resting_ends",
            "points",
            "a path without standing still at its ends",
            rows[resting],
            self._words("{:.0f} points without motion", (head + tail)[resting].astype(float)),
        )

    def _ends(
        self, part: Demonstrations, scene: IntArray, known: BoolArray, rows: IntArray
    ) -> None:
        if not len(self.scenes.start):
            return
        start, goal = self.scenes.start[scene], self.scenes.goal[scene]
        height = self.scenes.size[scene][:, 1]
        tolerance = FAR_FROM_END * np.linalg.norm(goal - start, axis=1)
        first = part.flat[part.offsets[:-1], :2]
        last = part.flat[part.offsets[1:] - 1, :2]
        for kind, ends, at in (("start_mismatch", first, start), ("goal_mismatch", last, goal)):
            gap = np.linalg.norm(ends - at, axis=1)
            far = known & (gap > tolerance)
            self.note(
                kind,
                "points",
                f"a path that {'begins at the start' if ends is first else 'ends at the goal'} "
                f"(within {FAR_FROM_END:.0%} of the distance between them)",
                rows[far],
                self._words("{:.1f} away", gap[far]),
            )
        with np.errstate(invalid="ignore"):
            up = np.stack([first[:, 0], height - first[:, 1]], axis=1)
            mirrored = np.linalg.norm(up - start, axis=1) <= tolerance
        flipped = known & (np.linalg.norm(first - start, axis=1) > tolerance) & mirrored
        self.note(
            "y_points_up",
            "points",
            "y to point down (mirrored, the path would begin at the start)",
            rows[flipped],
        )

    def _outside(
        self, part: Demonstrations, scene: IntArray, known: BoolArray, rows: IntArray
    ) -> None:
        if not len(self.scenes.size):
            return
        counts = np.diff(part.offsets)
        size = self.scenes.size[np.repeat(scene, counts)]
        out = ((part.flat[:, :2] < 0) | (part.flat[:, :2] > size)) & np.isfinite(size)
        many = np.add.reduceat(out.any(axis=1).astype(np.int64), part.offsets[:-1])
        outside = known & (many > 0)
        self.note(
            "outside_picture",
            "points",
            "points inside the picture",
            rows[outside],
            self._words("{:.0f} points outside", many[outside].astype(float)),
        )

    def _times(self, part: Demonstrations, rows: IntArray) -> None:
        if part.t is None:
            return
        path = np.repeat(np.arange(len(part)), np.diff(part.offsets))
        with np.errstate(invalid="ignore"):
            back = (np.diff(part.t) <= 0) & (path[1:] == path[:-1])
        wrong = np.unique(path[1:][back])
        self.note("time_not_increasing", "t", "time stamps that increase", rows[wrong])

    def _duplicates(self) -> None:
        if not self._keys:
            return
        keys, rows = np.concatenate(self._keys), np.concatenate(self._rows)
        labels = np.concatenate(self._labels)
        order = np.argsort(keys, kind="stable")
        sorted_keys = keys[order]
        new = np.concatenate([[True], sorted_keys[1:] != sorted_keys[:-1]])
        original = order[np.flatnonzero(new)[np.cumsum(new) - 1]]
        again = order[~new]
        model = original[~new]
        place = np.argsort(again)
        again, model = again[place], model[place]
        opposed = (labels[again] >= 0) & (labels[model] >= 0) & (labels[again] != labels[model])
        for kind, mask, expected in (
            ("contradiction", opposed, "one label for one path (same scene, type and points)"),
            ("duplicate", ~opposed, "each path once (same scene, type and points)"),
        ):
            words = [f"the same path as row {r}" for r in rows[model[mask]][: self.listed]]
            self.note(kind, "points", expected, rows[again[mask]], words)


def _rest(
    part: Demonstrations, owner: IntArray, step: FloatArray, first: IntArray, n_steps: IntArray
) -> tuple[IntArray, IntArray]:
    """Points at each path's beginning and end that do not move; (n,), (n,)."""
    n = len(part)
    where = np.arange(len(step)) - first[owner]
    moves = step > 0
    head = np.full(n, 0, dtype=np.int64)
    tail = np.full(n, 0, dtype=np.int64)
    begin = np.full(n, np.iinfo(np.int64).max)
    end = np.full(n, -1, dtype=np.int64)
    np.minimum.at(begin, owner[moves], where[moves])
    np.maximum.at(end, owner[moves], where[moves])
    some = end >= 0
    head[some] = begin[some]
    tail[some] = n_steps[some] - 1 - end[some]
    return head, tail


def _path_keys(part: Demonstrations) -> IntArray:
    """(n,) 64-bit hashes of scene, type and points."""
    flat, offsets = np.ascontiguousarray(part.flat), part.offsets.tolist()
    names = zip(part.scene_id, part.type, strict=True)
    return np.array(
        [
            hash((scene, type_, flat[a:b].tobytes()))
            for (scene, type_), a, b in zip(names, offsets[:-1], offsets[1:], strict=True)
        ],
        dtype=np.int64,
    )
