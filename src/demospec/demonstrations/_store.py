"""The set format on disk: dataset.json, scenes/metadata.jsonl, demonstrations.parquet."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._schema import Header, SceneLine, parse
from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._table import read_table, write_table
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes, read_json, to_json, writing_folder
from demospec.scene import Picture, Scene

FORMAT_VERSION = 1


def read_set(folder: str | os.PathLike[str]) -> DemonstrationSet:
    """Reads a demonstration set.

    Args:
        folder: Holds ``dataset.json``, ``scenes/`` and ``demonstrations.parquet``.

    Raises:
        InputError: Naming file, row, field, what was expected and what came.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError(
            "a demonstration set (a folder)",
            "no such folder" if not root.exists() else "a file",
            file=root,
        )
    header = read_header(root)
    scenes = read_scenes(root)
    columns = tuple(header.columns)
    demonstrations = read_table(root / "demonstrations.parquet", columns=len(columns))
    known = {
        "format", "version", "name", "units", "metres_per_unit", "symbols", "types", "columns",
    }  # fmt: skip
    try:
        return DemonstrationSet(
            scenes=scenes,
            demonstrations=demonstrations,
            name=header.name,
            units=header.units,
            metres_per_unit=header.metres_per_unit,
            symbols=tuple(header.symbols),
            types=tuple(header.types),
            columns=columns,
            extra=tuple((k, v) for k, v in (header.model_extra or {}).items() if k not in known),
        )
    except InputError as error:
        raise error.at(file=_file_of(root, error)) from error


def _file_of(root: Path, error: InputError) -> Path:
    field = (error.field or "").split(".")[0]
    if field in ("metres_per_unit", "types", "symbols", "columns"):
        return root / "dataset.json"
    if field in ("objects", "scenes") or (
        field == "scene_id" and error.expected.startswith("each")
    ):
        return root / "scenes" / "metadata.jsonl"
    return root / "demonstrations.parquet"


def read_header(root: Path) -> Header:
    """``dataset.json`` of a set."""
    file = root / "dataset.json"
    header = parse(Header, read_json(file), file=file)
    if header.version > FORMAT_VERSION:
        expected = f"at most {FORMAT_VERSION} (a newer demospec wrote this set)"
        raise InputError(expected, header.version, file=file, field="version")
    return header


def read_scenes(root: Path) -> tuple[Scene, ...]:
    """``scenes/metadata.jsonl`` of a set, with its pictures still in their files."""
    file = root / "scenes" / "metadata.jsonl"
    scenes: list[Scene] = []
    for row, line in enumerate(read_bytes(file).splitlines()):
        if not line.strip():
            continue
        item = parse(SceneLine, parse_json(line, file=file, row=row), file=file, row=row)
        picture = None
        if item.file_name is not None:
            picture = Picture(file=_inside(root / "scenes", item.file_name, file, row))
            _ = picture.size_px  # a missing or broken picture is named now, not in a later stage
        scenes.append(item.to_scene(picture))
    return tuple(scenes)


def _inside(folder: Path, name: str, file: Path, row: int) -> Path:
    """The picture's path; refuses names that leave the folder, by links too."""
    base = Path(os.path.realpath(folder))
    try:
        target = Path(os.path.realpath(folder / name))
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(
            "a file in the scenes folder", name, file=file, row=row, field="file_name"
        ) from error
    if os.path.isabs(name) or not target.is_relative_to(base):
        raise InputError("a file in the scenes folder", name, file=file, row=row, field="file_name")
    if not target.is_file():
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
        write_table(data.demonstrations, root / "demonstrations.parquet")
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
    if picture.file is not None and picture.file.suffix.lower() == ".png":
        target.write_bytes(read_bytes(picture.file))  # byte for byte: copying must not re-encode
    else:
        PIL.Image.fromarray(np.asarray(picture.pixels)).save(target, format="PNG")


def pictures_in_memory(data: DemonstrationSet) -> DemonstrationSet:
    """The same set with every picture decoded (for many passes over few scenes)."""
    scenes = tuple(
        s if s.picture is None else replace(s, picture=Picture(array=s.picture.pixels))
        for s in data.scenes
    )
    return replace(data, scenes=scenes)
