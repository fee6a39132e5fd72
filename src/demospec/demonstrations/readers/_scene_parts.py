"""Scenes of a source: pictures, starts and goals, objects in the unit of the points or the set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import Demonstration
from demospec.demonstrations.readers._identity import checked_name
from demospec.demonstrations.readers._mapping import Mapping, SceneMapping
from demospec.demonstrations.readers._reading import ObjectsRead
from demospec.demonstrations.readers._recording import ListedObjects, RawScene, Source
from demospec.demonstrations.readers._units import Converter
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, MultiPolygon, Polygon, rims
from demospec.scene import Picture, Scene, SceneObject


def raw_scenes(
    source: Source, mapping: Mapping, names: list[str], root: Path
) -> dict[str, RawScene]:
    """The scenes that recordings use (and those that the mapping describes), in order of use."""
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
        if said.start is not None or said.goal is not None or said.objects is not None:
            scene = _as_said(scene, said)
        out[name] = replace(scene, split=said.split or scene.split)
    unknown = [name for name in mapping.scenes if name not in out]
    if unknown:
        known = ", ".join(list(out)[:8])
        raise InputError(f"a scene that there is ({known})", unknown[0], field="scenes")
    used = set(names)
    return {name: s for name, s in out.items() if name in used or name in mapping.scenes}


def _as_said(scene: RawScene, said: SceneMapping) -> RawScene:
    """What a mapping says of a scene, which is in the set's unit, over what the source says."""
    told = (said.start, said.goal, said.objects)
    own = (scene.start, scene.goal, scene.objects)
    mixed = any(t is None and o is not None for t, o in zip(told, own, strict=True))
    if scene.units == "source" and mixed:
        expected = "start, goal and objects all from the mapping, or all from the source"
        raise InputError(expected, "some of each", row=f"scene {scene.scene_id}", field="scenes")
    return replace(
        scene,
        start=scene.start if said.start is None else tuple(said.start),
        goal=scene.goal if said.goal is None else tuple(said.goal),
        objects=scene.objects
        if said.objects is None
        else tuple(o.to_object() for o in said.objects),
        units="set",
    )


def _loader(root: Path, name: str) -> Any:
    def load() -> Picture:
        picture = Picture(file=root / name)
        _ = picture.size_px
        return picture

    return load


def in_set_units(
    raw: dict[str, RawScene], shown: dict[str, Picture | None], converter: Converter
) -> dict[str, RawScene]:
    """The scenes with start, goal and objects in the set's unit and frame."""
    out = {}
    for name, scene in raw.items():
        out[name] = scene
        if scene.units == "source":
            out[name] = _converted(scene, shown.get(name), converter)
    return out


def _converted(scene: RawScene, picture: Picture | None, converter: Converter) -> RawScene:
    where = f"scene {scene.scene_id}"

    def point(numbers: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if numbers is None:
            return None
        if len(numbers) < 3 and not converter.flat:
            raise InputError("three numbers a place (the plane is not x, y)", "two", row=where,
                             field="start, goal, objects")  # fmt: skip
        x, y = converter.place(np.array([numbers], dtype=np.float64), picture)[0, :2]
        return float(x), float(y)

    objects = scene.objects
    similarity = converter.similarity(picture)
    if objects is not None and similarity is not None:
        objects = tuple(o.mapped(*similarity) for o in objects)
    elif objects is not None:
        moved = []
        for item in objects:
            center = point(tuple(scene.centers.get(item.id, item.center)))
            assert center is not None
            if item.footprint is not None and not converter.flat:
                raise InputError("objects without outlines (the plane is not x, y)", item.id,
                                 row=where, field="objects")  # fmt: skip
            moved.append(_projected(item, (center[0], center[1]), converter, picture))
        objects = tuple(moved)
    return replace(
        scene, start=point(scene.start), goal=point(scene.goal), objects=objects, units="set"
    )


def _projected(
    item: SceneObject,
    center: tuple[float, float],
    converter: Converter,
    picture: Picture | None,
) -> SceneObject:
    """An object whose lengths change by place: its outline as corners, without box and heading."""
    shape: Footprint | None = None
    if item.footprint is not None:
        parts = [converter.place(rim, picture) for rim in rims(item.footprint)]
        shape = Polygon(parts[0]) if len(parts) == 1 else MultiPolygon(parts)
    return replace(item, center=center, bbox=None, footprint=shape, heading_deg=None, height=None)


def match_objects(
    raw: dict[str, RawScene],
    shown: dict[str, Picture | None],
    objects: list[ListedObjects] | None,
    file: Path | None,
) -> tuple[dict[str, RawScene], ObjectsRead]:
    """The scenes with the objects that a file lists for their pictures, and who matched whom.

    Raises:
        InputError: A file of which nothing matches; a picture listed twice; a list made on a
            picture of another shape.
    """
    out = dict(raw)
    used: set[int] = set()
    if objects is not None:
        places: dict[str, int] = {}
        for i, entry in enumerate(objects):
            for name in entry.names:
                if places.setdefault(name, i) != i:
                    places[name] = -1  # of several pictures: no name of either
        for name, scene in raw.items():
            at = _entry_of(name, scene, places)
            if at is not None:
                used.add(at)
                if objects[at].relative and scene.load is None and shown.get(name) is None:
                    expected = "a picture (the objects are in shares of its size)"
                    raise InputError(expected, "none", file=file, row=objects[at].row,
                                     field="objects")  # fmt: skip
                listed = _fitted(objects[at], shown.get(name), file)
                out[name] = replace(scene, objects=listed, units="set")
        if not used:
            some = ", ".join(e.names[0] for e in objects[:5]) or "none"
            wanted = ", ".join(s.file_name or n for n, s in list(raw.items())[:5])
            expected = f"objects of one of the scenes' pictures ({wanted})"
            raise InputError(expected, f"objects of {some}", file=file, field="objects")
    without = tuple(n for n, s in out.items() if s.objects is None)
    unused = tuple(e.names[0] for i, e in enumerate(objects or ()) if i not in used)
    count = sum(len(s.objects or ()) for s in out.values())
    shown_name = None if file is None or objects is None else file.name
    return out, ObjectsRead(shown_name, len(out) - len(without), count, without, unused)


def _entry_of(name: str, scene: RawScene, places: dict[str, int]) -> int | None:
    """The entry of a scene: by its picture's name, then by that without folders, then its id."""
    keys = [name]
    if scene.file_name is not None:
        file_name = scene.file_name.replace("\\", "/")
        keys = [
            scene.file_name,
            file_name,
            file_name.rsplit("/", 1)[-1],
            Path(file_name).stem,
            name,
        ]
    found = next((places[k] for k in keys if k in places), None)
    if found == -1:
        raise InputError(
            "one picture of that name", "several", row=f"scene {name}", field="objects"
        )
    return found


def _fitted(
    entry: ListedObjects, picture: Picture | None, file: Path | None
) -> tuple[SceneObject, ...]:
    """The objects of an entry, in pixels of the picture that is shown."""
    if picture is None:
        return entry.objects
    if entry.relative:
        return tuple(o.mapped(np.diag(picture.size_px)) for o in entry.objects)
    scale = _scale_to(picture, entry.size_px, file, entry.row)
    return entry.objects if scale == (1, 1) else _scaled(entry.objects, scale)


def _scaled(
    objects: tuple[SceneObject, ...], scale: tuple[float, float]
) -> tuple[SceneObject, ...]:
    return tuple(o.mapped(np.diag(scale)) for o in objects)


def _scale_to(
    picture: Picture, size_px: tuple[float, float] | None, file: Path | None, row: int | str | None
) -> tuple[float, float]:
    """From pixels of the picture that was annotated to those of the one that is shown, x and y.

    Raises:
        InputError: They have not the same shape.
    """
    if size_px is None:
        return (1.0, 1.0)
    sx, sy = (b / a for a, b in zip(size_px, picture.size_px, strict=True))
    # A picture that was made smaller has whole pixels: its sides agree to half of one.
    slack = 0.5 / min(picture.size_px) * max(sx, sy)
    if abs(sx - sy) > slack:
        shown = "x".join(str(v) for v in picture.size_px)
        said = "x".join(f"{v:g}" for v in size_px)
        expected = f"annotations of a picture of the shape {shown}"
        raise InputError(expected, said, file=file, row=row, field="objects")
    return sx, sy


def drawings_fitted(
    source: Source, shown: dict[str, Picture | None], raw: dict[str, RawScene]
) -> tuple[dict[str, RawScene], dict[str, tuple[float, float]]]:
    """Scenes whose objects were drawn over a picture of another size, in pixels of the one that
    is shown; and by how much the paths drawn there are longer in x and y.

    Raises:
        InputError: A picture of another shape.
    """
    out, scales = dict(raw), {}
    for name, scene in raw.items():
        picture = shown.get(name)
        if picture is None or scene.size_px is None:
            continue
        scale = _scale_to(picture, scene.size_px, None, f"{source.name}, scene {name}")
        if scale != (1, 1):
            scales[name] = scale
            objects = scene.objects and _scaled(scene.objects, scale)
            out[name] = replace(scene, objects=objects)
            source.notes.append(f"scene {name}: drawn over another size, times {scale[0]:.4g}")
    return out, scales


def finished_scenes(
    raw: dict[str, RawScene],
    shown: dict[str, Picture | None],
    items: list[Demonstration],
    notes: list[str],
) -> tuple[Scene, ...]:
    """The set's scenes; where the source states no start or goal, the median of the paths' ends."""
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
        for listed in scene.objects or ():
            row = f"scene {name}"
            checked_name(listed.id, what="objects.id", file=None, row=row)
            checked_name(listed.symbol, what="objects.symbol", file=None, row=row)
        scenes.append(
            Scene(
                scene_id=name,
                start=start,
                goal=goal,
                objects=scene.objects,
                relations=scene.relations,
                picture=shown[name],
                split=scene.split or "train",
            )
        )
    if guessed:
        notes.append(f"start and goal: median of the paths' ends in {guessed} scenes")
    return tuple(scenes)


def _middle(points: FloatArray) -> tuple[float, float]:
    x, y = np.median(points, axis=0)
    return float(x), float(y)
