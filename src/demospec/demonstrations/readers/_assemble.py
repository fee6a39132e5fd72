"""Recordings and a mapping → a demonstration set, with notes about every choice made."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._trajectory import (
    MAX_COORDINATE,
    MAX_POINTS,
    Demonstration,
    Demonstrations,
)
from demospec.demonstrations.readers._mapping import Mapping, SceneMapping
from demospec.demonstrations.readers._projection import projection_of
from demospec.demonstrations.readers._recording import RawScene, Recording, Source
from demospec.demonstrations.readers._units import Converter
from demospec.demonstrations.readers._values import (
    automatic,
    refuse_unknown,
    text_of,
    validity_of,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Picture, Scene, SceneObject


@dataclass(frozen=True)
class _Chosen:
    """The sources that the words ``auto`` were resolved to."""

    scene: str
    type: str
    demonstrator: str
    valid: str


def assemble(
    source: Source,
    mapping: Mapping,
    *,
    root: Path,
    objects: dict[str, tuple[SceneObject, ...]] | None = None,
    pictures: bool = True,
) -> DemonstrationSet:
    """The set that a source holds. Appends to `source.notes` what was decided.

    Args:
        source: What a reader found.
        mapping: How to read it.
        root: The folder relative to which the mapping names pictures.
        objects: Objects by picture file name or scene id (from a COCO file), pixels.
        pictures: False decodes no picture (a dry run).

    Raises:
        InputError: With the file, the recording and the field.
    """
    if not source.recordings:
        raise InputError("at least one recording", "none", file=root)
    _refuse_repeats(source.recordings)
    recordings = source.recordings
    chosen = _choose(recordings, mapping, source.notes)
    names = _column_names(recordings, mapping, source.notes)
    projection = projection_of(mapping.projection)
    scenes_of = [_scene_name(r, chosen.scene) for r in recordings]
    raw = _raw_scenes(source, mapping, scenes_of, root)
    shown = {k: s.load() if pictures and s.load is not None else None for k, s in raw.items()}
    units = mapping.units or source.units
    converter = Converter.of(units, mapping, projection, raw, "z" in names, source.notes)
    items = []
    for recording, scene in zip(recordings, scenes_of, strict=True):
        points, t = _points(recording, names, mapping)
        points = converter.convert(recording, points, shown.get(scene))
        items.append(
            Demonstration(
                demo_id=recording.name,
                scene_id=scene,
                points=points,
                type=text_of(recording, chosen.type, "type"),
                demonstrator=text_of(recording, chosen.demonstrator, "demonstrator"),
                valid=validity_of(recording, chosen.valid, mapping.words),
                t=t,
            )
        )
    metres = converter.metres_per_unit(items)
    items = converter.heights_in_pixels(items, metres)
    columns = tuple(names)
    scenes = _scenes(raw, shown, items, objects, source.notes)
    symbols = sorted({o.symbol for s in scenes for o in s.objects or ()})
    types = list(dict.fromkeys(i.type for i in items if i.type is not None))
    return DemonstrationSet(
        scenes=scenes,
        demonstrations=Demonstrations.of(items, columns=len(columns)),
        name=mapping.name or source.name,
        units=converter.units,
        metres_per_unit=metres,
        symbols=tuple(symbols),
        types=tuple(types),
        columns=columns,
    )


def _refuse_repeats(recordings: list[Recording]) -> None:
    for name, n in Counter(r.name for r in recordings).items():
        if n > 1:
            twice = [r for r in recordings if r.name == name][1]
            raise twice.complain("each name once", f"{name} {n} times", "name")


def _choose(recordings: list[Recording], mapping: Mapping, notes: list[str]) -> _Chosen:
    found = {}
    for what in ("scene", "type", "demonstrator", "valid"):
        asked = getattr(mapping, what)
        where = automatic(what, recordings, mapping.words) if asked == "auto" else asked
        refuse_unknown(recordings, where, what)
        found[what] = where
        if where == "none":
            none = {
                "valid": "none recorded",
                "scene": "one for all",
                "type": "none (all are taken for one person; --type names them)",
            }.get(what, "none")
            stated = what == "scene" and any(r.scene is not None for r in recordings)
            notes.append(f"{what}: {'as the source states' if stated else none}")
        else:
            notes.append(f"{what}: from {where}{' (found)' if asked == 'auto' else ''}")
    return _Chosen(**found)


def _scene_name(recording: Recording, source: str) -> str:
    if source == "none":
        return recording.scene or "scene"
    return text_of(recording, source, "scene") or recording.scene or "scene"


def _column_names(
    recordings: list[Recording], mapping: Mapping, notes: list[str]
) -> dict[str, str]:
    """Ours → theirs, ``x`` and ``y`` first."""
    if mapping.columns is not None:
        for name in ("x", "y"):
            if name not in mapping.columns:
                raise InputError(f"a column for {name}", list(mapping.columns), field="columns")
        order = ["x", "y", *(["z"] if "z" in mapping.columns else [])]
        order += [name for name in mapping.columns if name not in order]
        return {name: str(mapping.columns[name]) for name in order}
    first = recordings[0]
    names: dict[str, str] = {}
    for axis in ("x", "y", "z"):
        matches = [c for c in first.columns if _is_axis(c, axis)]
        if len(matches) > 1:
            exact = [c for c in matches if c.lower() == axis]
            matches = exact or matches
        if len(matches) > 1:
            raise first.complain(
                f"one column for {axis}; say which: --column {axis}=NAME",
                ", ".join(matches[:8]), "columns",
            )  # fmt: skip
        if matches:
            names[axis] = matches[0]
    if "x" not in names or "y" not in names:
        plain = all(c.isdecimal() for c in first.columns) or len(first.columns) in (2, 3)
        if not (plain and len(first.columns) in (2, 3)):
            known = ", ".join(first.columns[:20])
            raise first.complain(
                "columns for x and y; say which: --column x=NAME --column y=NAME", known, "columns"
            )
        names = dict(zip(("x", "y", "z"), first.columns, strict=False))
    rest = [c for c in first.columns if c not in names.values()]
    notes.append(
        "path: " + ", ".join(f"{ours} from {theirs}" for ours, theirs in names.items())
        + (f"; not read: {', '.join(rest[:12])}" if rest else "")
    )  # fmt: skip
    return names


def _is_axis(column: str, axis: str) -> bool:
    """Whether a column's name is that of an axis: x, pos_x, pose.position.x, x_px, x[m]."""
    if "orient" in column.lower() or "quat" in column.lower():
        return False
    return axis in re.split(r"[^a-z0-9]+", column.lower())


def _points(
    recording: Recording, names: dict[str, str], mapping: Mapping
) -> tuple[FloatArray, FloatArray | None]:
    """The chosen columns of a recording, thinned, with its time stamps."""
    places = []
    for ours, theirs in names.items():
        if theirs in recording.columns:
            places.append(recording.columns.index(theirs))
        elif theirs.isdecimal() and int(theirs) < len(recording.columns):
            places.append(int(theirs))
        else:
            known = ", ".join(recording.columns[:20])
            raise recording.complain(f"a column {theirs} for {ours}", known, "columns")
    points = np.asarray(recording.points, dtype=np.float64)[:, places]
    t = _times(recording, mapping)
    if mapping.drop_missing:
        kept = np.isfinite(points).all(axis=1)
        if not kept.any():
            raise recording.complain("a point that is not missing", "none", "points")
        points, t = points[kept], None if t is None else t[kept]
    wrong = ~(np.abs(points) <= MAX_COORDINATE)
    if wrong.any():
        i, j = np.argwhere(wrong)[0]
        expected = f"finite numbers of size at most {MAX_COORDINATE:.0e}"
        if np.isnan(points[i, j]):
            expected += " (--drop-missing leaves such points out)"
        raise recording.complain(expected, f"{points[i, j]} in point {i}", list(names)[j])
    if mapping.every > 1:
        take = np.arange(0, len(points), mapping.every)
        if take[-1] != len(points) - 1:
            take = np.append(take, len(points) - 1)
        points, t = points[take], None if t is None else t[take]
    if len(points) > MAX_POINTS:
        expected = f"at most {MAX_POINTS} points in one path (thin it out: --every N)"
        raise recording.complain(expected, f"{len(points)} points", "points")
    if t is not None and not np.isfinite(t).all():
        at = int(np.flatnonzero(~np.isfinite(t))[0])
        raise recording.complain("finite seconds", f"{t[at]} in point {at}", "t")
    return points, t


def _times(recording: Recording, mapping: Mapping) -> FloatArray | None:
    if mapping.time is None:
        return recording.t
    name = str(mapping.time)
    if name == "none":
        return None
    if name in recording.columns:
        return np.asarray(recording.points[:, recording.columns.index(name)], dtype=np.float64)
    value = recording.fields.get(name)
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
        return value.astype(np.float64)
    known = ", ".join([*recording.columns, *recording.fields][:20])
    raise recording.complain(f"a column {name} of seconds (there are: {known})", "none", "time")


def _raw_scenes(
    source: Source, mapping: Mapping, names: list[str], root: Path
) -> dict[str, RawScene]:
    """The scenes that recordings use (and those that the format states), in order of use."""
    out: dict[str, RawScene] = {}
    for name in dict.fromkeys([*names, *source.scenes]):
        scene = source.scenes.get(name, RawScene(name))
        said = mapping.scenes.get(name, SceneMapping())
        picture = said.picture
        if picture is None and mapping.picture not in (None, "none") and scene.load is None:
            candidate = root / str(mapping.picture).replace("{scene}", name)
            if candidate.is_file():
                picture = str(mapping.picture).replace("{scene}", name)
            elif name in names:
                expected = "a file" + (
                    f" or one of the pictures {', '.join(source.cameras)}" if source.cameras else ""
                )
                raise InputError(expected, str(mapping.picture), file=root, field="picture")
        if picture is not None:
            scene = replace(scene, load=_loader(root, picture), file_name=picture)
        if mapping.picture == "none":
            scene = replace(scene, load=None)
        out[name] = replace(
            scene,
            start=scene.start if said.start is None else tuple(said.start),
            goal=scene.goal if said.goal is None else tuple(said.goal),
            split=said.split or scene.split,
            objects=scene.objects
            if said.objects is None
            else tuple(o.to_object() for o in said.objects),
        )
    unknown = [name for name in mapping.scenes if name not in out]
    if unknown:
        known = ", ".join(list(out)[:8])
        raise InputError(f"a scene that there is ({known})", unknown[0], field="scenes")
    used = set(names)
    return {name: s for name, s in out.items() if name in used or name in mapping.scenes}


def _loader(root: Path, name: str) -> Any:
    def load() -> Picture:
        picture = Picture(file=root / name)
        _ = picture.size_px
        return picture

    return load


def _scenes(
    raw: dict[str, RawScene],
    shown: dict[str, Picture | None],
    items: list[Demonstration],
    objects: dict[str, tuple[SceneObject, ...]] | None,
    notes: list[str],
) -> tuple[Scene, ...]:
    paths: dict[str, list[FloatArray]] = {}
    for item in items:
        paths.setdefault(item.scene_id, []).append(item.points)
    scenes = []
    guessed = 0
    for name, scene in raw.items():
        start, goal = scene.start, scene.goal
        if start is None or goal is None:
            guessed += 1
            here = paths.get(name)
            if not here:
                raise InputError("a start and a goal", "no demonstration", row=f"scene {name}",
                                 field="start")  # fmt: skip
            start = start or _middle(np.array([p[0, :2] for p in here]))
            goal = goal or _middle(np.array([p[-1, :2] for p in here]))
        listed = scene.objects
        if objects is not None:
            for key in (scene.file_name, name):
                if key is not None and listed is None:
                    listed = objects.get(key) or objects.get(Path(key).name)
        scenes.append(
            Scene(
                scene_id=name,
                start=start,
                goal=goal,
                objects=listed,
                relations=scene.relations,
                picture=shown[name],
                split=scene.split or "train",
            )
        )
    if guessed:
        notes.append(f"start and goal: median of the paths' ends in {guessed} scenes")
    listed_n = sum(s.objects is not None for s in scenes)
    notes.append(f"objects: listed in {listed_n} of {len(scenes)} scenes")
    return tuple(scenes)


def _middle(points: FloatArray) -> tuple[float, float]:
    x, y = np.median(points, axis=0)
    return float(x), float(y)
