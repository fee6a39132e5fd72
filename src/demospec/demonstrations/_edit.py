"""Editing is copying: every operation makes a new set; the given one is never changed.

All functions take and return `DemonstrationSet`s; `write_edited` writes one with a record of
where it came from.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._store import PARQUET, write_set
from demospec.demonstrations._trajectory import (
    BoolArray,
    Demonstrations,
    first_and_last_motion,
    joined,
)
from demospec.errors import InputError
from demospec.files import read_json
from demospec.scene import Capsule, Disc, Footprint, Picture, Polygon, Scene, SceneObject


def merge(sets: Sequence[DemonstrationSet], names: Sequence[str] | None = None) -> DemonstrationSet:
    """All scenes and demonstrations of several sets.

    Scenes that are equal in every respect become one; ids that clash otherwise get their set's
    name in front.

    Args:
        sets: At least one; of one unit, one scale and the same columns.
        names: One for each set, for clashing ids; by default the sets' own names.

    Raises:
        InputError: Sets that do not fit together (rescale one first).
    """
    if not sets:
        raise InputError("at least one set", "none", field="sets")
    first = sets[0]
    for other in sets[1:]:
        for field in ("units", "metres_per_unit", "columns"):
            mine, theirs = getattr(first, field), getattr(other, field)
            if mine != theirs:
                raise InputError(f"{mine}, as in the first set", f"{theirs} in {other.name}",
                                 field=field)  # fmt: skip
    labels = _distinct(list(names) if names is not None else [s.name for s in sets])
    scenes: dict[str, Scene] = {}
    parts: list[Demonstrations] = []
    taken: set[str] = set()
    for data, label in zip(sets, labels, strict=True):
        renamed: dict[str, str] = {}
        for scene in data.scenes:
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
        parts.append(_with(d, demo_id=ids, scene_id=[renamed[s] for s in d.scene_id]))
    return replace(
        first,
        scenes=tuple(scenes.values()),
        demonstrations=joined(parts),
        symbols=tuple(dict.fromkeys(w for s in sets for w in s.symbols)),
        types=tuple(dict.fromkeys(w for s in sets for w in s.types)),
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
    changed = _with(d, valid=valid, type=type_, demonstrator=who)
    return replace(data, demonstrations=changed, types=tuple(types))


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


def crop(data: DemonstrationSet, box: tuple[int, int, int, int]) -> DemonstrationSet:
    """The pictures cut to a box; points and objects move with it.

    Objects whose outline lies wholly outside are left out. Demonstrations keep all their points.

    Args:
        box: x, y, width, height, whole pixels, inside every picture.

    Raises:
        InputError: A box that leaves a picture.
    """
    x, y, width, height = box
    if width < 1 or height < 1:
        raise InputError("a box of at least one pixel", box, field="box")

    def cut(scene: Scene) -> Scene:
        size = scene.size_px
        if size is not None and (x < 0 or y < 0 or x + width > size[0] or y + height > size[1]):
            raise InputError(f"a box inside the picture ({size[0]}x{size[1]})", box,
                             row=f"scene {scene.scene_id}", field="box")  # fmt: skip
        picture = scene.picture
        if picture is not None:
            part = scene.pixels()[y : y + height, x : x + width]
            picture = Picture(array=np.ascontiguousarray(part))
        objects = scene.objects
        if objects is not None:
            moved = (o.moved((-x, -y)) for o in objects)
            objects = tuple(o for o in moved if _reaches(o, width, height)) or None
        return replace(
            scene,
            start=(scene.start[0] - x, scene.start[1] - y, *scene.start[2:]),
            goal=(scene.goal[0] - x, scene.goal[1] - y, *scene.goal[2:]),
            objects=objects,
            picture=picture,
        )

    flat = data.demonstrations.flat.copy()
    flat[:, :2] -= (x, y)
    return replace(
        data,
        scenes=tuple(cut(s) for s in data.scenes),
        demonstrations=_with(data.demonstrations, flat=flat),
    )


def _reaches(item: SceneObject, width: int, height: int) -> bool:
    low_x, low_y, high_x, high_y = item.outline.bounds
    return high_x > 0 and high_y > 0 and low_x < width and low_y < height


def rescale(data: DemonstrationSet, factor: float, *, units: str | None = None) -> DemonstrationSet:
    """Every length times `factor`: points (x, y, z), objects, pictures; the scale follows.

    Args:
        factor: > 0. Pictures are resampled to the nearest whole size.
        units: New name of the unit (``px`` for a set in metres that becomes one in pixels).
    """
    if not (np.isfinite(factor) and factor > 0):
        raise InputError("a number > 0", factor, field="factor")
    flat = data.demonstrations.flat.copy()
    lengths = [i for i, name in enumerate(data.columns) if name in ("x", "y", "z")]
    flat[:, lengths] *= factor
    scale = data.metres_per_unit
    return replace(
        data,
        scenes=tuple(_scaled_scene(s, factor) for s in data.scenes),
        demonstrations=_with(data.demonstrations, flat=flat),
        metres_per_unit=None if scale is None else scale / factor,
        units=units or data.units,
    )


def _scaled_scene(scene: Scene, factor: float) -> Scene:
    picture = scene.picture
    if picture is not None and factor != 1:
        import PIL.Image

        width, height = (max(1, round(v * factor)) for v in picture.size_px)
        if width * height > 64_000_000:
            raise InputError("a picture of at most 64000000 pixels", f"{width}x{height}",
                             row=f"scene {scene.scene_id}", field="factor")  # fmt: skip
        image = PIL.Image.fromarray(scene.pixels())
        way = PIL.Image.Resampling.BOX if factor < 1 else PIL.Image.Resampling.BICUBIC
        picture = Picture(array=np.asarray(image.resize((width, height), way)))
    objects = scene.objects
    if objects is not None:
        objects = tuple(_scaled_object(o, factor) for o in objects)
    return replace(
        scene,
        start=tuple(v * factor for v in scene.start),
        goal=tuple(v * factor for v in scene.goal),
        objects=objects,
        picture=picture,
    )


def _scaled_object(item: SceneObject, f: float) -> SceneObject:
    box = item.bbox and (item.bbox[0] * f, item.bbox[1] * f, item.bbox[2] * f, item.bbox[3] * f)
    return replace(
        item,
        center=(item.center[0] * f, item.center[1] * f),
        bbox=box,
        footprint=None if item.footprint is None else _scaled_footprint(item.footprint, f),
    )


def _scaled_footprint(shape: Footprint, f: float) -> Footprint:
    if isinstance(shape, Polygon):
        return Polygon(shape.vertices * f)
    if isinstance(shape, Disc):
        return Disc((shape.center[0] * f, shape.center[1] * f), shape.radius * f)
    assert isinstance(shape, Capsule)
    (ax, ay), (bx, by) = shape.start, shape.end
    return Capsule((ax * f, ay * f), (bx * f, by * f), shape.radius * f)


def trim(data: DemonstrationSet) -> DemonstrationSet:
    """Every path without standing still at its ends (one point of each rest is kept)."""
    d = data.demonstrations
    keep = np.concatenate([first_and_last_motion(d.points(i)[:, :2]) for i in range(len(d))])
    counts = np.add.reduceat(keep.astype(np.int64), d.offsets[:-1])
    return replace(
        data,
        demonstrations=_with(
            d,
            flat=d.flat[keep],
            offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            t=None if d.t is None else d.t[keep],
        ),
    )


def _with(d: Demonstrations, **changed: Any) -> Demonstrations:
    """The same demonstrations with some columns exchanged."""
    columns: dict[str, Any] = {
        "demo_id": d.demo_id, "scene_id": d.scene_id, "type": d.type,
        "demonstrator": d.demonstrator, "valid": d.valid, "flat": d.flat,
        "offsets": d.offsets, "t": d.t,
    }  # fmt: skip
    for name, value in changed.items():
        if isinstance(value, list):
            column = np.empty(len(value), dtype=object)
            column[:] = value
            value = column
        columns[name] = value
    return Demonstrations(**columns)


def _distinct(names: list[str]) -> list[str]:
    """The names, numbered where they repeat."""
    return [n if names.count(n) == 1 else f"{n}{i + 1}" for i, n in enumerate(names)]


def _free(name: str, taken: set[str]) -> str:
    """The name, with a number behind it where it is taken."""
    if name not in taken:
        return name
    return next(f"{name}-{i}" for i in range(2, len(taken) + 3) if f"{name}-{i}" not in taken)


def write_edited(
    data: DemonstrationSet,
    folder: str | os.PathLike[str],
    *,
    operation: str,
    arguments: Mapping[str, Any],
    inputs: Sequence[str | os.PathLike[str]],
    keep_truth: bool = False,
    replace_existing: bool = False,
) -> Path:
    """Writes an edited set with ``provenance.json``: the operation, its arguments, its inputs.

    Args:
        data: What to write.
        folder: A new folder, outside every input.
        inputs: The sets it was made from; their digests and their own provenance are recorded.
        keep_truth: Copy the first input's ``truth.json`` (a rule that the operation leaves true).

    Raises:
        InputError: `folder` is one of the inputs or lies in one.
        OutputError: It exists, or cannot be written.
    """
    refuse_inside(inputs, folder)
    documents = {"provenance.json": provenance(data, operation, arguments, inputs)}
    truth = Path(inputs[0]) / "truth.json"
    if keep_truth and truth.is_file():
        documents["truth.json"] = read_json(truth)
    return write_set(data, folder, replace_existing=replace_existing, documents=documents)


def provenance(
    data: DemonstrationSet,
    operation: str,
    arguments: Mapping[str, Any],
    inputs: Sequence[str | os.PathLike[str]],
) -> dict[str, Any]:
    """The record of an edit."""
    return {
        "operation": operation,
        "arguments": dict(arguments),
        "demospec": version("demospec"),
        "inputs": [_input(Path(i)) for i in inputs],
        "scenes": len(data.scenes),
        "demonstrations": len(data.demonstrations),
    }


def refuse_inside(inputs: Sequence[str | os.PathLike[str]], folder: str | os.PathLike[str]) -> None:
    """InputError where writing `folder` would change one of the inputs."""
    target = Path(os.path.realpath(folder))
    for path in inputs:
        source = Path(os.path.realpath(path))
        if target == source or source in target.parents or target in source.parents:
            raise InputError("a place outside the input", "a place in it", file=target)


def _input(root: Path) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": root.name, "sha256": {}}
    for name in ("dataset.json", "scenes/metadata.jsonl", PARQUET):
        with open(root / name, "rb") as stream:
            entry["sha256"][name] = hashlib.file_digest(stream, "sha256").hexdigest()
    if (root / "provenance.json").is_file():
        entry["provenance"] = read_json(root / "provenance.json")
    return entry
