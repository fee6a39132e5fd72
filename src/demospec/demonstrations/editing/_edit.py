"""Editing is copying: every operation makes a new set; the given one is never changed.

All functions take and return `DemonstrationSet`s; `write_edited` writes one with a record of
where it came from.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.demonstrations._pairs import Pair, read_pair_table
from demospec.demonstrations._provenance import provenance, refuse_inside, write_edited
from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._trajectory import (
    BoolArray,
    Demonstrations,
    joined,
)
from demospec.demonstrations.editing._columns import with_columns
from demospec.demonstrations.editing._doubted import doubted, refuse_many
from demospec.demonstrations.editing._geometry import crop, rescale, scaled_by, trim
from demospec.errors import InputError
from demospec.scene import Scene

__all__ = [
    "crop", "doubted", "drop", "joined", "merge", "prefer", "provenance", "read_pair_table",
    "refuse_inside", "refuse_many", "relabel", "repeated", "rescale", "scaled_by", "split",
    "trim", "write_edited",
]  # fmt: skip


def merge(sets: Sequence[DemonstrationSet], names: Sequence[str] | None = None) -> DemonstrationSet:
    """All scenes and demonstrations of several sets.

    Scenes that are equal in every respect become one; ids that clash otherwise get their set's
    name in front.

    Args:
        sets: At least one; of one unit and frame and the same columns. Pictures of another
            scale than the first set's keep theirs, scene by scene.
        names: One for each set, for clashing ids; by default the sets' own names.

    Raises:
        InputError: Sets that do not fit together (rescale one first).
    """
    if not sets:
        raise InputError("at least one set", "none", field="sets")
    first = sets[0]
    for other in sets[1:]:
        for field in ("units", "metres_per_unit", "columns", "frame"):
            mine, theirs = getattr(first, field), getattr(other, field)
            if field == "metres_per_unit" and mine is not None and theirs is not None:
                continue
            if mine != theirs:
                raise InputError(f"{mine}, as in the first set", f"{theirs} in {other.name}",
                                 field=field)  # fmt: skip
    labels = _distinct(list(names) if names is not None else [s.name for s in sets])
    scenes: dict[str, Scene] = {}
    parts: list[Demonstrations] = []
    taken: set[str] = set()
    pairs: list[Pair] = []
    for data, label in zip(sets, labels, strict=True):
        renamed: dict[str, str] = {}
        for scene in data.scenes:
            if data.scale_of(scene) != first.metres_per_unit:
                scene = replace(scene, metres_per_unit=data.scale_of(scene))
            new = scene.scene_id
            if new in scenes and scenes[new] != scene:
                new = _free(f"{label}-{new}", set(scenes))
            renamed[scene.scene_id] = new
            scenes.setdefault(new, replace(scene, scene_id=new))
        d = data.demonstrations
        ids = []
        for name in d.demo_id:
            new = name if name not in taken else _free(f"{label}-{name}", taken)
            taken.add(new)
            ids.append(new)
        now = dict(zip(d.demo_id.tolist(), ids, strict=True))
        pairs += [replace(p, preferred=now[p.preferred], other=now[p.other]) for p in data.pairs]
        parts.append(with_columns(d, demo_id=ids, scene_id=[renamed[s] for s in d.scene_id]))
    return replace(
        first,
        scenes=tuple(scenes.values()),
        demonstrations=joined(parts),
        symbols=tuple(dict.fromkeys(w for s in sets for w in s.symbols)),
        types=tuple(dict.fromkeys(w for s in sets for w in s.types)),
        pairs=tuple(pairs),
    )


def split(
    data: DemonstrationSet, test_share: float | None = None, *, seed: int = 0
) -> dict[str, DemonstrationSet]:
    """The set in parts, by scene: no scene is in two parts.

    Args:
        test_share: Share of the scenes that become ``test``, in (0, 1), drawn at random; None
            keeps the splits that the scenes have.

    Returns:
        Name of the split → its scenes and their demonstrations, marked with that split.

    Raises:
        InputError: A part without scenes or demonstrations.
    """
    n = len(data.scenes)
    if test_share is None:
        marks = [s.split for s in data.scenes]
    else:
        if not 0 < test_share < 1:
            raise InputError("a share between 0 and 1", test_share, field="test_share")
        count = round(test_share * n)
        if not 0 < count < n:
            raise InputError(f"a share of {n} scenes that leaves both parts one", test_share,
                             field="test_share")  # fmt: skip
        drawn = set(np.random.default_rng(seed).permutation(n)[:count].tolist())
        marks = ["test" if i in drawn else "train" for i in range(n)]
    marked = replace(
        data, scenes=tuple(replace(s, split=m) for s, m in zip(data.scenes, marks, strict=True))
    )
    return {name: marked.of_split(name) for name in sorted(set(marks), reverse=True)}


def relabel(data: DemonstrationSet, changes: Mapping[str, Mapping[str, Any]]) -> DemonstrationSet:
    """The set with other labels.

    Args:
        changes: Demonstration → new values of ``valid`` (True, False, None or ``"flip"``),
            ``type`` and ``demonstrator``.

    Raises:
        InputError: An unknown demonstration or key.
    """
    d = data.demonstrations
    row_of = {str(name): i for i, name in enumerate(d.demo_id)}
    valid, type_, who = d.valid.copy(), d.type.copy(), d.demonstrator.copy()
    types = list(data.types)
    for name, values in changes.items():
        if name not in row_of:
            raise InputError("a demonstration of the set", name, field="demo_id")
        row = row_of[name]
        for key, value in values.items():
            if key == "valid":
                if value == "flip" and valid[row] < 0:
                    raise InputError("a label to flip", "none", row=name, field="valid")
                if value == "flip":
                    valid[row] = 1 - valid[row]
                else:
                    valid[row] = -1 if value is None else int(bool(value))
            elif key == "type":
                type_[row] = value
                if value is not None and value not in types:
                    types.append(value)
            elif key == "demonstrator":
                who[row] = value
            else:
                raise InputError("valid, type or demonstrator", key, row=name, field="changes")
    changed = with_columns(d, valid=valid, type=type_, demonstrator=who)
    return replace(data, demonstrations=changed, types=tuple(types))


def prefer(data: DemonstrationSet, pairs: Sequence[Pair]) -> DemonstrationSet:
    """The set with more pairs, one demonstration of each preferred to the other.

    Raises:
        InputError: An unknown demonstration or type; with the row.
    """
    known = set(data.demonstrations.demo_id.tolist())
    for row, pair in enumerate(pairs):
        for field, name in (("preferred", pair.preferred), ("other", pair.other)):
            if name not in known:
                raise InputError("a demonstration of the set", name, row=row, field=field)
    try:
        return replace(data, pairs=(*data.pairs, *pairs))
    except InputError as error:
        at = error.row - len(data.pairs) if isinstance(error.row, int) else None
        raise InputError(error.expected, error.found, row=at, field=error.field) from error


def drop(
    data: DemonstrationSet,
    *,
    demonstrations: Iterable[str] = (),
    scenes: Iterable[str] = (),
    types: Iterable[str] = (),
    unlabelled: bool = False,
    duplicates: bool = False,
) -> DemonstrationSet:
    """The set without some demonstrations (and without the scenes named).

    Args:
        duplicates: Of demonstrations with the same scene, type, label and points keep the first.

    Raises:
        InputError: An unknown name, or nothing left.
    """
    d = data.demonstrations
    gone = np.zeros(len(d), dtype=bool)
    for kind, wanted, column in (
        ("demonstration", set(demonstrations), d.demo_id),
        ("scene", set(scenes), d.scene_id),
        ("type", set(types), d.type),
    ):
        known = {str(v) for v in column}
        known |= {s.scene_id for s in data.scenes} if kind == "scene" else set()
        for name in sorted(wanted - known):
            raise InputError(f"a {kind} of the set", name, field=kind)
        gone |= np.array([v in wanted for v in column], dtype=bool)
    if unlabelled:
        gone |= d.valid < 0
    if duplicates:
        gone |= repeated(d)
    if gone.all():
        raise InputError("at least one demonstration that stays", "none", field="demonstrations")
    left_out = set(scenes)
    return replace(
        data,
        scenes=tuple(s for s in data.scenes if s.scene_id not in left_out),
        demonstrations=d.rows(~gone),
        pairs=tuple(p for p in data.pairs if p.type is None or p.type not in set(types)),
        types=tuple(t for t in data.types if t not in set(types)),
    )


def repeated(d: Demonstrations) -> BoolArray:
    """(n,) demonstrations whose scene, type, label and points an earlier one has."""
    seen: set[tuple[Any, ...]] = set()
    out = np.zeros(len(d), dtype=bool)
    for i in range(len(d)):
        key = (d.scene_id[i], d.type[i], int(d.valid[i]), d.points(i).tobytes())
        out[i] = key in seen
        seen.add(key)
    return out


def _distinct(names: list[str]) -> list[str]:
    """The names, numbered where they repeat."""
    return [n if names.count(n) == 1 else f"{n}{i + 1}" for i, n in enumerate(names)]


def _free(name: str, taken: set[str]) -> str:
    """The name, with a number behind it where it is taken."""
    if name not in taken:
        return name
    return next(f"{name}-{i}" for i in range(2, len(taken) + 3) if f"{name}-{i}" not in taken)
