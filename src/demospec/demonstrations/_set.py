"""A set of demonstrations over scenes: the thing that every command reads."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations._motion import Motion, Motions
from demospec.demonstrations._pairs import Pair, checked_pairs
from demospec.demonstrations._trajectory import LEAST_SCALE, MAX_SCALE, Demonstrations
from demospec.errors import InputError
from demospec.frames import METRES, Frame, metres_of_unit
from demospec.geometry import extent, path_bounds
from demospec.scene import Scene


@dataclass(frozen=True)
class DemonstrationSet:
    """Demonstrations over top-down scenes, validated on construction.

    Args:
        scenes: At least one, with unique ids.
        demonstrations: At least one, with unique ids, each in a scene of the set.
        name: Free text.
        units: Unit of the coordinates, ``px`` for picture pixels.
        metres_per_unit: > 0, or None where unknown; of a set in m, cm or mm what its unit says.
        symbols: Class words. Words that scenes use and this omits are refused.
        types: User types. Types that demonstrations use and this omits are refused.
        columns: What a point holds; ``x``, ``y`` first.
        extra: Further keys of ``dataset.json``, kept as they came.
        frame: The frame in which the coordinates came, or None where nobody said.
        pairs: Demonstrations preferred to others. A part of the set keeps the pairs of which it
            has both.

    Raises:
        InputError: With field and row; `demospec.demonstrations.read_set` adds the file.
    """

    scenes: tuple[Scene, ...]
    demonstrations: Demonstrations
    name: str = "unnamed"
    units: str = "px"
    metres_per_unit: float | None = None
    symbols: tuple[str, ...] = ()
    types: tuple[str, ...] = ()
    columns: tuple[str, ...] = ("x", "y")
    extra: tuple[tuple[str, Any], ...] = field(default=(), compare=False)
    frame: Frame | None = None
    pairs: tuple[Pair, ...] = ()

    @property
    def axes(self) -> Frame:
        """The frame of the coordinates; the one that the unit implies where the set is silent."""
        return Frame.of_units(self.units) if self.frame is None else self.frame

    @property
    def scale_m(self) -> float | None:
        """Metres per unit, also where the unit itself says so; None where nobody does."""
        return metres_of_unit(self.units, self.metres_per_unit)

    def __post_init__(self) -> None:
        if self.metres_per_unit is None and self.units in METRES:
            object.__setattr__(self, "metres_per_unit", METRES[self.units])
        _check_header(self)
        _check_scenes(self)
        _check_demonstrations(self)
        if self.pairs:
            d = self.demonstrations
            type_of = dict(zip(d.demo_id.tolist(), d.type.tolist(), strict=True))
            pairs = checked_pairs(self.pairs, type_of, self.types)
            object.__setattr__(self, "pairs", pairs)

    @cached_property
    def scene_index(self) -> dict[str, int]:
        """Scene id → position in `scenes`."""
        return {scene.scene_id: i for i, scene in enumerate(self.scenes)}

    @cached_property
    def length_scale(self) -> float:
        """The size of the set's scenes, set units: tolerances and priors are shares of it.

        Of each scene the longer side of the box around its objects, start, goal and paths; of
        several scenes the median. It does not depend on the unit, on the picture, or on how
        densely a path is sampled.
        """
        box = np.array([scene.bounds for scene in self.scenes])
        d = self.demonstrations
        own = path_bounds(d.flat, d.offsets)
        at = np.array([self.scene_index[name] for name in d.scene_id], dtype=np.int64)
        np.minimum.at(box[:, :2], at, own[:, :2])
        np.maximum.at(box[:, 2:], at, own[:, 2:])
        return float(np.median([extent((a, b, c, d)) for a, b, c, d in box.tolist()]))

    def scale_of(self, scene: Scene) -> float | None:
        """Metres that one unit of a scene is long: the scene's own scale, else the set's."""
        return self.metres_per_unit if scene.metres_per_unit is None else scene.metres_per_unit

    def scene(self, scene_id: str) -> Scene:
        """The scene of that id; InputError lists some of those there are."""
        if scene_id not in self.scene_index:
            known = ", ".join(list(self.scene_index)[:8])
            raise InputError(f"a scene of the set ({known}, …)", scene_id, field="scene_id")
        return self.scenes[self.scene_index[scene_id]]

    def select(self, chosen: ArrayLike) -> DemonstrationSet:
        """The same scenes with only the demonstrations of a mask or of rows."""
        return replace(self, demonstrations=self.demonstrations.rows(chosen))

    def motions(self, rows: Sequence[int] | np.ndarray | None = None) -> Motions:
        """The chosen demonstrations (all by default) as paths with times and columns."""
        d = self.demonstrations
        chosen = range(len(d)) if rows is None else rows
        return Motions(self._motion(int(i)) for i in chosen)

    def _motion(self, i: int) -> Motion:
        d = self.demonstrations
        t = None if d.t is None else d.t[d.offsets[i] : d.offsets[i + 1]]
        if t is not None and np.isnan(t).any():
            t = None
        return Motion(d.points(i), t, self.columns)

    def of_split(self, split: str) -> DemonstrationSet:
        """Only the scenes of one split and their demonstrations."""
        scenes = tuple(s for s in self.scenes if s.split == split)
        if not scenes:
            found = ", ".join(sorted({s.split for s in self.scenes}))
            raise InputError(f"scenes of split {split}", f"only {found}", field="split")
        keep = {s.scene_id for s in scenes}
        mask = np.array([s in keep for s in self.demonstrations.scene_id], dtype=bool)
        return replace(self, scenes=scenes, demonstrations=self.demonstrations.rows(mask))

    def rows_by_scene(self) -> dict[str, np.ndarray]:
        """Scene id → rows of its demonstrations, in order; scenes without any are absent."""
        index = np.array([self.scene_index[s] for s in self.demonstrations.scene_id])
        order = np.argsort(index, kind="stable")
        values, first = np.unique(index[order], return_index=True)
        parts = np.split(order, first[1:])
        return {self.scenes[v].scene_id: rows for v, rows in zip(values, parts, strict=True)}


def _check_header(s: DemonstrationSet) -> None:
    scale = s.metres_per_unit
    if scale is not None and not LEAST_SCALE <= scale <= MAX_SCALE:
        expected = f"a number from {LEAST_SCALE:g} to {MAX_SCALE:g}, or null"
        raise InputError(expected, scale, field="metres_per_unit")
    if scale is not None and s.units in METRES and not math.isclose(scale, METRES[s.units]):
        raise InputError(
            f"{METRES[s.units]} or null, as the unit is {s.units}", scale, field="metres_per_unit"
        )
    for name, words in (("types", s.types), ("symbols", s.symbols), ("columns", s.columns)):
        twice = [word for word, n in Counter(words).items() if n > 1]
        if twice:
            raise InputError("each name once", f"{twice[0]} twice", field=name)
        if any(not word for word in words):
            raise InputError("names that are not empty", "''", field=name)
    if s.columns[:2] != ("x", "y"):
        raise InputError("x, y first", list(s.columns), field="columns")


def _check_scenes(s: DemonstrationSet) -> None:
    if not s.scenes:
        raise InputError("at least one scene", "none", field="scenes")
    seen: set[str] = set()
    symbols = set(s.symbols)
    for row, scene in enumerate(s.scenes):
        if scene.scene_id in seen:
            raise InputError("each scene once", scene.scene_id, row=row, field="scene_id")
        seen.add(scene.scene_id)
        own = scene.metres_per_unit
        if own is not None and not (math.isfinite(own) and own > 0):
            raise InputError("a number > 0 or null", own, row=row, field="scenes.metres_per_unit")
        ids: set[str] = set()
        for item in scene.objects or ():
            if item.id in ids:
                raise InputError("each object once", item.id, row=row, field="objects.id")
            ids.add(item.id)
            if item.symbol not in symbols:
                expected = f"one of the set's symbols ({', '.join(s.symbols) or 'none'})"
                raise InputError(expected, item.symbol, row=row, field="objects.symbol")


def _check_demonstrations(s: DemonstrationSet) -> None:
    d = s.demonstrations
    if len(d) == 0:
        raise InputError("at least one demonstration", "none", field="demonstrations")
    if d.flat.shape[1] != len(s.columns):
        expected = f"{len(s.columns)} numbers a point ({', '.join(s.columns)})"
        raise InputError(expected, d.flat.shape[1], field="points")
    if len(set(d.demo_id)) != len(d):
        row, name = _first_repeat(d.demo_id)
        raise InputError("each demonstration once", name, row=row, field="demo_id")
    known = s.scene_index
    for row, scene_id in enumerate(d.scene_id):
        if scene_id not in known:
            raise InputError("a scene of the set", scene_id, row=row, field="scene_id")
    types = set(s.types)
    for row, word in enumerate(d.type):
        if word is not None and word not in types:
            expected = f"one of the set's types ({', '.join(s.types) or 'none'})"
            raise InputError(expected, word, row=row, field="type")
    _check_inside(s)


def _check_inside(s: DemonstrationSet) -> None:
    """Refuses points further outside the picture than the picture is wide."""
    if all(scene.picture is None for scene in s.scenes):
        return
    d = s.demonstrations
    sizes = np.array([scene.size_px or (np.inf, np.inf) for scene in s.scenes], dtype=np.float64)
    index = np.array([s.scene_index[name] for name in d.scene_id], dtype=np.int64)
    size = sizes[np.repeat(index, np.diff(d.offsets))]
    slack = size[:, :1]
    outside = ((d.flat[:, :2] < -slack) | (d.flat[:, :2] > size + slack)).any(axis=1)
    if outside.any():
        point = int(np.flatnonzero(outside)[0])
        row = int(np.searchsorted(d.offsets, point, side="right")) - 1
        width, height = size[point]
        expected = f"points within one picture width of the picture ({width:g}x{height:g})"
        x, y = d.flat[point, :2]
        found = f"[{x:g}, {y:g}] in point {point - int(d.offsets[row])}"
        raise InputError(expected, found, row=row, field="points")


def _first_repeat(names: np.ndarray) -> tuple[int, str]:
    seen: set[str] = set()
    for row, name in enumerate(names):
        if name in seen:
            return row, str(name)
        seen.add(name)
    raise AssertionError("no name repeats")
