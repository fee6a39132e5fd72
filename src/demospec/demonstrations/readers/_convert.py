"""Any source → a demonstration set: read, decide, write, and say what was decided."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._store import read_set, write_set
from demospec.demonstrations.readers._assemble import assemble
from demospec.demonstrations.readers._guess import FORMATS, guess_format
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._reading import Reading
from demospec.demonstrations.readers._recording import (
    ListedObjects,
    Pictures,
    RawScene,
    Source,
)
from demospec.demonstrations.readers._scene_parts import match_objects
from demospec.demonstrations.readers.annotations._objects import read_objects
from demospec.demonstrations.readers.tables._labels import add_labels, labels_file
from demospec.errors import InputError, OutputError
from demospec.progress import Progress, silent


@dataclass(frozen=True)
class Conversion:
    """What was read, and how.

    Args:
        data: The set. After a dry run its scenes have no pictures.
        format: The source's format.
        notes: Every decision, in words.
        provenance: What `convert` writes to ``provenance.json``.
        reading: Columns, units, frame, time, labels and objects; None for a set of this format.
    """

    data: DemonstrationSet
    format: str
    notes: tuple[str, ...]
    provenance: dict[str, Any]
    reading: Reading | None = None


def read_source(
    source: str | os.PathLike[str],
    *,
    format: str | None = None,
    mapping: Mapping | None = None,
    pictures: bool = True,
    picture_folder: Path | None = None,
    progress: Progress = silent,
) -> Conversion:
    """Reads a source without writing anything.

    Args:
        source: A file or folder in one of `FORMATS`.
        format: One of them; guessed from names and first bytes where None.
        mapping: How the source's names become ours.
        pictures: False decodes no picture.
        picture_folder: Where pictures taken out of videos and tables go; None keeps them in
            memory.
        progress: Told how far reading is.

    Raises:
        InputError: Naming the file, the recording and the field.
        MissingExtraError: The library that reads the format is not installed.
    """
    path = Path(source)
    try:
        return _read_source(path, format, mapping, pictures, picture_folder, progress)
    except OSError as error:  # vanished, no permission, a broken disk
        raise InputError("a readable source", error.strerror or str(error), file=path) from error


def _read_source(
    path: Path,
    format: str | None,
    mapping: Mapping | None,
    pictures: bool,
    picture_folder: Path | None,
    progress: Progress,
) -> Conversion:
    kind = format or guess_format(path)
    if kind not in FORMATS:
        raise InputError(f"one of {', '.join(FORMATS)}", kind, field="--from")
    if format is not None and not path.exists():
        raise InputError("a source to read", "no such file or folder", file=path)
    if path.exists() and not path.is_file() and not path.is_dir():
        raise InputError("a file or folder", "a device or pipe", file=path)
    how = mapping or Mapping()
    root = path if path.is_dir() else path.parent
    objects = None if how.objects is None else read_objects(root / how.objects)
    reading = None
    if kind == "demospec":
        data = _with_objects(read_set(path), objects, how)
        notes = [f"read: {len(data.demonstrations)} demonstrations, a set of this format"]
    else:
        labels = labels_file(root, path, how)
        left_out = _no_recordings(root, how, labels)
        found = _read(kind, path, how, progress, Pictures(picture_folder), left_out)
        if labels is not None:
            add_labels(found, labels, root)
        used = how
        if how.robot is not None:
            from demospec.demonstrations.readers.joints._forward import with_forward_kinematics

            used = with_forward_kinematics(found, how, root)
        data, reading = assemble(found, used, root=root, objects=objects, pictures=pictures)
        notes = found.notes
    provenance = _provenance(path, kind, how, notes)
    if reading is not None:
        provenance["read"] = reading.to_json()
    return Conversion(data, kind, tuple(notes), provenance, reading)


def _no_recordings(root: Path, mapping: Mapping, labels: Path | None) -> tuple[Path, ...]:
    """The files of a source that a mapping names for something else."""
    named = [n for n in (mapping.objects, mapping.picture) if n is not None]
    return (*(root / n for n in named), *([labels] if labels is not None else []))


def convert(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    format: str | None = None,
    mapping: Mapping | None = None,
    replace_existing: bool = False,
    listing: Callable[[DemonstrationSet], DemonstrationSet] | None = None,
    progress: Progress = silent,
) -> Conversion:
    """Reads a source and writes it as a new set, whole or not at all; the source is only read.

    Args:
        listing: Gives the set the lists of objects that it is to have, such as those of a
            detector that looks at its pictures; None leaves what was read.
        source, target, format, mapping, replace_existing, progress: See `read_source`.

    Raises:
        InputError, MissingExtraError: As `read_source`.
        OutputError: The target exists, or cannot be written.
    """
    _refuse_inside(Path(source), Path(target))
    with _room_for_pictures() as folder:
        result = read_source(
            source, format=format, mapping=mapping, picture_folder=folder, progress=progress
        )
        if listing is not None:
            result = replace(result, data=listing(result.data))
        write_set(
            result.data,
            target,
            replace_existing=replace_existing,
            documents={"provenance.json": result.provenance},
        )
    return result


@contextmanager
def _room_for_pictures() -> Iterator[Path]:
    try:
        folder = tempfile.TemporaryDirectory(prefix="demospec-", ignore_cleanup_errors=True)
    except OSError as error:
        place = tempfile.gettempdir() if tempfile.tempdir else "the temporary folder"
        raise OutputError(f"{place}: cannot write: {error.strerror or error}") from error
    with folder as name:
        yield Path(name)


def _refuse_inside(source: Path, target: Path) -> None:
    """A target that is the source, holds it, or lies in it would change the source."""
    try:
        a, b = source.resolve(), target.resolve()
    except (OSError, RuntimeError, ValueError):
        return  # reading will name what is wrong with the source
    if a == b or b in a.parents or (a in b.parents and a.is_dir()):
        raise InputError("a place outside the source", "a place in it", file=target)


def _read(
    kind: str,
    path: Path,
    mapping: Mapping,
    progress: Progress,
    pictures: Pictures,
    left_out: tuple[Path, ...],
) -> Source:
    # Each reader's libraries are loaded when it is needed.
    if kind == "tables":
        from demospec.demonstrations.readers.tables._files import read_tables

        return read_tables(path, mapping, progress, left_out)
    if kind == "json":
        from demospec.demonstrations.readers._json_file import read_json

        return read_json(path, mapping, progress, left_out)
    if kind == "lerobot":
        from demospec.demonstrations.readers.lerobot._reader import read_lerobot

        return read_lerobot(path, mapping, progress, pictures)
    if kind == "hdf5":
        from demospec.demonstrations.readers._hdf5 import read_hdf5

        return read_hdf5(path, mapping, progress, pictures)
    if kind == "ros":
        from demospec.demonstrations.readers.ros._reader import read_bags

        return read_bags(path, mapping, progress, pictures)
    if kind == "cvat":
        from demospec.demonstrations.readers.annotations._cvat import read_cvat

        return read_cvat(path / "annotations.xml" if path.is_dir() else path, mapping, progress)
    from demospec.demonstrations.readers.annotations._label_studio import read_label_studio

    return read_label_studio(path, mapping, progress)


def _with_objects(
    data: DemonstrationSet, objects: list[ListedObjects] | None, mapping: Mapping
) -> DemonstrationSet:
    """The set with the objects that a file lists for its pictures in place of its own."""
    if objects is None:
        return data
    raw = {}
    for scene in data.scenes:
        file = scene.picture.file if scene.picture is not None else None
        raw[scene.scene_id] = RawScene(
            scene.scene_id, objects=scene.objects, file_name=None if file is None else file.name
        )
    shown = {s.scene_id: s.picture for s in data.scenes}
    matched, _ = match_objects(raw, shown, objects, Path(str(mapping.objects)))
    scenes = tuple(
        s if matched[s.scene_id].objects is s.objects
        else replace(s, objects=matched[s.scene_id].objects, relations=())
        for s in data.scenes
    )  # fmt: skip
    symbols = {o.symbol for s in scenes for o in s.objects or ()}
    every = tuple(dict.fromkeys([*data.symbols, *sorted(symbols)]))
    return replace(data, scenes=scenes, symbols=every)


def _provenance(path: Path, kind: str, mapping: Mapping, notes: list[str]) -> dict[str, Any]:
    return {
        "operation": "convert",
        "demospec": version("demospec"),
        "source": {"name": path.name, "format": kind, "files": _file_list(path)},
        "mapping": mapping.model_dump(exclude_unset=True),
        "notes": notes,
    }


def _file_list(
    path: Path, limit: int = 10_000, hashed_bytes: int = 1 << 28
) -> list[dict[str, Any]]:
    """Name, size and, for files of up to 256 MiB, SHA-256 of every file of a source."""
    files = [path] if path.is_file() else []
    for base, folders, names in os.walk(path, followlinks=False):
        folders.sort()
        files += [Path(base) / name for name in sorted(names)]
        if len(files) > limit:
            return [{"count": f"more than {limit}"}]
    out = []
    for file in files:
        if not file.is_file():
            continue
        size = file.stat().st_size
        name = file.name if file == path else file.relative_to(path).as_posix()
        entry: dict[str, Any] = {"name": name, "bytes": size}
        if size <= hashed_bytes:
            with open(file, "rb") as stream:
                entry["sha256"] = hashlib.file_digest(stream, "sha256").hexdigest()
        out.append(entry)
    return out
