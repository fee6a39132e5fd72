"""What is wrong and what is odd about a set on disk: everything, not only the first fault."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from demospec.demonstrations._migrate import (
    FORMAT_VERSION,
    migrate_header,
    migrate_scene,
    version_of,
)
from demospec.demonstrations._pairs import PAIRS, checked_pairs, read_pairs
from demospec.demonstrations._schema import Header, SceneLine, faults
from demospec.demonstrations._store import PARQUET, read_header, read_scene, set_folder
from demospec.demonstrations._table import opened_parquet, parquet_faults
from demospec.demonstrations.large._stream import BATCH_ROWS
from demospec.demonstrations.validation._report import CheckReport, Problem
from demospec.demonstrations.validation._rows import check_rows
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes, read_json
from demospec.progress import Progress, silent
from demospec.scene import Scene

__all__ = ["CheckReport", "Problem", "check_set"]


def check_set(
    folder: str | os.PathLike[str], *, rows: int = BATCH_ROWS, progress: Progress = silent
) -> CheckReport:
    """Reads a set batch by batch and reports everything that is wrong or odd about it.

    Args:
        folder: A demonstration set, of any size.
        rows: Demonstrations in memory at a time.
        progress: Told of each batch.

    Raises:
        InputError: `folder` is not a folder.
    """
    root = set_folder(folder)
    report = CheckReport(os.fspath(folder))
    header, version = _check_header(root, report)
    scenes, names = _check_scenes(root, report, header, version, progress)
    check_rows(root, report, header, version, scenes, names, rows, progress)
    _check_pairs(root, report, header)
    report.problems.sort(key=lambda p: p.severity != "error")
    return report


def _check_pairs(root: Path, report: CheckReport, header: Header | None) -> None:
    file = root / PAIRS
    if header is None or not file.exists() or any(p.severity == "error" for p in report.problems):
        return  # of demonstrations that cannot be read, ids say nothing
    with opened_parquet(root / PARQUET) as parquet, parquet_faults(root / PARQUET):
        present = [n for n in ("demo_id", "type") if n in parquet.schema_arrow.names]
        table = parquet.read(columns=present).to_pydict()
    types = table.get("type", [None] * len(table["demo_id"]))
    type_of = dict(zip(table["demo_id"], types, strict=True))
    try:
        checked_pairs(read_pairs(file, type_of), type_of, header.types)
    except InputError as error:
        report.error(error.at(file=file))


def _check_header(root: Path, report: CheckReport) -> tuple[Header | None, int]:
    file = root / "dataset.json"
    try:
        document = read_json(file)
    except InputError as error:
        report.error(error)
        return None, FORMAT_VERSION
    wrong = faults(Header, migrate_header(document), file=file)
    for fault in wrong:
        report.error(fault)
    if wrong:
        return None, version_of(document)
    try:
        header, version = read_header(root)
    except InputError as error:
        report.error(error)
        return None, version_of(document)
    for name in ("types", "symbols", "columns"):
        twice = [w for w, n in Counter(getattr(header, name)).items() if n > 1]
        for word in twice:
            report.error(InputError("each name once", f"{word} twice", file=file, field=name))
    if header.columns[:2] != ["x", "y"]:
        report.error(InputError("x, y first", header.columns, file=file, field="columns"))
    return header, version


def _check_scenes(
    root: Path, report: CheckReport, header: Header | None, version: int, progress: Progress
) -> tuple[list[Scene], set[str]]:
    """The readable scenes, and the names of all."""
    file = root / "scenes" / "metadata.jsonl"
    scenes: list[Scene] = []
    names: set[str] = set()
    try:
        lines = read_bytes(file).splitlines()
    except InputError as error:
        report.error(error)
        return scenes, names
    for row, line in enumerate(lines):
        if not line.strip():
            continue
        try:
            document = migrate_scene(parse_json(line, file=file, row=row), version)
        except InputError as error:
            report.error(error)
            continue
        if isinstance(document, dict) and isinstance(document.get("scene_id"), str):
            name = document["scene_id"]
            if name in names:
                fault = InputError("each scene once", name, file=file, row=row, field="scene_id")
                report.error(fault, "repeated_scene")
            names.add(name)
        wrong = faults(SceneLine, document, file=file, row=row)
        for fault in wrong:
            report.error(fault)
        if wrong:
            continue
        try:
            scene = read_scene(root, file, row, line, version)
            if scene.picture is not None:
                _ = scene.picture.pixels  # a truncated picture has a good header
        except InputError as error:
            report.error(error)
            continue
        progress("pictures", row + 1, len(lines))
        scenes.append(scene)
        _check_objects(scene, file, row, header, report)
    if not names and not scenes:
        report.error(InputError("at least one scene", "none", file=file, field="scenes"))
    return scenes, names


def _check_objects(
    scene: Scene, file: Path, row: int, header: Header | None, report: CheckReport
) -> None:
    if scene.objects is None:
        fault = InputError("a list of objects", "none", file=file, row=row, field="objects")
        report.warn("objects_not_listed", fault)
    size = scene.size_px
    ids: set[str] = set()
    for item in scene.objects or ():
        if item.id in ids:
            fault = InputError("each object once", item.id, file=file, row=row, field="objects.id")
            report.error(fault)
        ids.add(item.id)
        if header is not None and item.symbol not in header.symbols:
            expected = f"one of the set's symbols ({', '.join(header.symbols) or 'none'})"
            report.error(
                InputError(expected, item.symbol, file=file, row=row, field="objects.symbol")
            )
        x, y = item.center
        if size is not None and not (0 <= x <= size[0] and 0 <= y <= size[1]):
            found = f"{item.id} at [{x:g}, {y:g}]"
            fault = InputError("objects inside the picture", found, file=file, row=row,
                               field="objects.center")  # fmt: skip
            report.warn("object_outside", fault)
