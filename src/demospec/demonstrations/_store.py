"""The set format on disk: dataset.json, scenes/metadata.jsonl, demonstrations and pairs."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._migrate import (
    FORMAT_VERSION,
    migrate_header,
    migrate_scene,
    version_of,
)
from demospec.demonstrations._pairs import PAIRS, Pair, read_pairs, write_pairs
from demospec.demonstrations._schema import Header, SceneLine, parse
from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._table import read_table, write_table
from demospec.demonstrations._trajectory import Demonstrations
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes, read_json, to_json, writing_folder
from demospec.scene import Picture, Scene

PARQUET = "demonstrations.parquet"


def read_set(folder: str | os.PathLike[str]) -> DemonstrationSet:
    """Reads a demonstration set.

    Args:
        folder: Holds ``dataset.json``, ``scenes/``, ``demonstrations.parquet`` and, where pairs
            were compared, ``pairs.parquet``.

    Raises:
        InputError: Naming file, row, field, what was expected and what came.
    """
    root = set_folder(folder)
    header, version = read_header(root)
    scenes = read_scenes(root, version)
    demonstrations = read_table(root / PARQUET, columns=len(header.columns), version=version)
    pairs = read_pairs(root / PAIRS, set(demonstrations.demo_id.tolist()))
    return assemble(root, header, scenes, demonstrations, pairs)


def set_folder(folder: str | os.PathLike[str]) -> Path:
    """The path of a set; InputError where it is not a folder."""
    root = Path(folder)
    try:
        if root.is_dir():
            return root
        found = "a file" if root.exists() else "no such folder"
    except (OSError, ValueError) as error:  # no permission, a loop of links, a NUL byte
        raise InputError("a demonstration set (a folder)", str(error), file=repr(root)) from error
    raise InputError("a demonstration set (a folder)", found, file=root)


def assemble(
    root: Path,
    header: Header,
    scenes: tuple[Scene, ...],
    demonstrations: Demonstrations,
    pairs: tuple[Pair, ...] = (),
) -> DemonstrationSet:
    """The set (or one batch of it), validated; faults name the file they are in."""
    try:
        return DemonstrationSet(
            scenes=scenes,
            demonstrations=demonstrations,
            name=header.name,
            units=header.units,
            metres_per_unit=header.metres_per_unit,
            symbols=tuple(header.symbols),
            types=tuple(header.types),
            columns=tuple(header.columns),
            extra=tuple((header.model_extra or {}).items()),
            frame=None if header.frame is None else header.frame.to_frame(),
            pairs=pairs,
        )
    except InputError as error:
        raise error.at(file=_file_of(root, error)) from error


def _file_of(root: Path, error: InputError) -> Path:
    field = (error.field or "").split(".")[0]
    if field == "pairs":
        return root / PAIRS
    if field in ("metres_per_unit", "frame", "types", "symbols", "columns"):
        return root / "dataset.json"
    if field in ("objects", "scenes") or (
        field == "scene_id" and error.expected.startswith("each")
    ):
        return root / "scenes" / "metadata.jsonl"
    return root / PARQUET


def read_header(root: Path) -> tuple[Header, int]:
    """``dataset.json`` of a set as the current version has it, and the version it is stored in."""
    file = root / "dataset.json"
    document = read_json(file)
    header = parse(Header, migrate_header(document), file=file)
    if header.version > FORMAT_VERSION:
        expected = f"at most {FORMAT_VERSION} (a newer demospec wrote this set)"
        raise InputError(expected, header.version, file=file, field="version")
    return header, version_of(document)


def read_scenes(root: Path, version: int = FORMAT_VERSION) -> tuple[Scene, ...]:
    """``scenes/metadata.jsonl`` of a set, with its pictures still in their files."""
    file = root / "scenes" / "metadata.jsonl"
    scenes: list[Scene] = []
    for row, line in enumerate(read_bytes(file).splitlines()):
        if line.strip():
            scenes.append(read_scene(root, file, row, line, version))
    return tuple(scenes)


def read_scene(root: Path, file: Path, row: int, line: bytes, version: int) -> Scene:
    """One line of ``metadata.jsonl``; its picture's header is read, not its pixels."""
    document = migrate_scene(parse_json(line, file=file, row=row), version)
    item = parse(SceneLine, document, file=file, row=row)
    picture = None
    if item.file_name is not None:
        picture = Picture(file=inside(root / "scenes", item.file_name, file, row))
        _ = picture.size_px  # a missing or broken picture is named now, not in a later stage
    try:
        return item.to_scene(picture)
    except InputError as error:
        raise error.at(file=file, row=row) from error


def inside(folder: Path, name: str, file: Path, row: int | str) -> Path:
    """The picture's path; refuses names that leave the folder, by links too."""
    base = Path(os.path.realpath(folder))
    try:
        target = Path(os.path.realpath(folder / name))
        there = target.is_file()
    except (OSError, ValueError, RuntimeError) as error:  # too long, a NUL, a loop of links
        raise InputError(
            f"a file in the folder {folder.name}", name, file=file, row=row, field="file_name"
        ) from error
    if os.path.isabs(name) or not target.is_relative_to(base):
        raise InputError(
            f"a file in the folder {folder.name}", name, file=file, row=row, field="file_name"
        )
    if not there:
        raise InputError("a picture that exists", name, file=file, row=row, field="file_name")
    return target


def write_set(
    data: DemonstrationSet,
    folder: str | os.PathLike[str],
    *,
    replace_existing: bool = False,
    documents: dict[str, Any] | None = None,
) -> Path:
    """Writes a set as a new folder, whole or not at all.

    Args:
        data: What to write.
        folder: Must not exist (or be empty) unless `replace_existing`.
        documents: Further JSON files of the folder, such as ``truth.json``.
    """
    with writing_folder(folder, replace=replace_existing) as root:
        (root / "scenes").mkdir()
        header = {
            "format": "demospec",
            "version": FORMAT_VERSION,
            "name": data.name,
            "units": data.units,
            "metres_per_unit": data.metres_per_unit,
            **({} if data.frame is None else {"frame": data.frame.to_json()}),
            "symbols": list(data.symbols),
            "types": list(data.types),
            "columns": list(data.columns),
            **dict(data.extra),
        }
        (root / "dataset.json").write_text(to_json(header) + "\n", encoding="utf-8")
        names = _picture_names(data.scenes)
        lines = []
        for scene, name in zip(data.scenes, names, strict=True):
            if name is not None:
                _write_picture(scene, root / "scenes" / name)
            lines.append(SceneLine.of(scene, name).line())
        (root / "scenes" / "metadata.jsonl").write_text("".join(lines), encoding="utf-8")
        write_table(data.demonstrations, root / PARQUET)
        if data.pairs:
            write_pairs(data.pairs, root / PAIRS)
        for file_name, document in (documents or {}).items():
            (root / file_name).write_text(to_json(document) + "\n", encoding="utf-8")
    return Path(folder)


def _picture_names(scenes: tuple[Scene, ...]) -> list[str | None]:
    """A file name for every picture: the scene's id where that is a safe name."""
    names: list[str | None] = []
    for i, scene in enumerate(scenes):
        if scene.picture is None:
            names.append(None)
            continue
        safe = (
            scene.scene_id.isascii() and scene.scene_id.replace("-", "").replace("_", "").isalnum()
        )
        stem = scene.scene_id if safe and len(scene.scene_id) < 100 else f"scene-{i:06d}"
        names.append(f"{stem}.png")
    lower = [name.lower() for name in names if name is not None]
    if len(set(lower)) != len(lower):  # ids that differ in case only, or look like our own names
        names = [None if n is None else f"scene-{i:06d}.png" for i, n in enumerate(names)]
    return names


def _write_picture(scene: Scene, target: Path) -> None:
    import PIL.Image

    picture = scene.picture
    assert picture is not None
    pixels = picture.pixels  # decoded also where bytes are copied: a broken one goes no further
    if picture.file is not None and picture.file.suffix.lower() == ".png":
        target.write_bytes(read_bytes(picture.file))  # byte for byte: copying must not re-encode
    else:
        PIL.Image.fromarray(np.asarray(pixels)).save(target, format="PNG")


def pictures_in_memory(data: DemonstrationSet) -> DemonstrationSet:
    """The same set with every picture decoded (for many passes over few scenes)."""
    scenes = tuple(
        s if s.picture is None else replace(s, picture=Picture(array=s.picture.pixels))
        for s in data.scenes
    )
    return replace(data, scenes=scenes)
