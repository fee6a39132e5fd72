"""What is wrong and what is odd about a set on disk: everything, not only the first fault."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._check_paths import Oddity, PathOddities, SceneTable
from demospec.demonstrations._faults import table_faults
from demospec.demonstrations._migrate import (
    FORMAT_VERSION,
    migrate_header,
    migrate_scene,
    version_of,
)
from demospec.demonstrations._schema import Header, SceneLine, faults
from demospec.demonstrations._store import PARQUET, read_header, read_scene, set_folder
from demospec.demonstrations._stream import BATCH_ROWS, arrow_batches, count_rows
from demospec.demonstrations._table import from_arrow
from demospec.demonstrations._trajectory import BoolArray, Demonstrations, IntArray
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes, read_json
from demospec.progress import Progress, silent
from demospec.scene import Scene

LISTED_ERRORS = 1000
LISTED_WARNINGS = 20
"""Of each kind of warning so many rows are listed; all are counted."""


@dataclass(frozen=True)
class Problem:
    """One line of the report. `severity` is ``error`` (the set is unreadable) or ``warning``."""

    severity: str
    kind: str
    expected: str
    found: str
    file: str
    row: int | str | None = None
    field: str | None = None

    @property
    def message(self) -> str:
        """file, row, field: expected …, found …"""
        return str(InputError(self.expected, self.found, file=self.file, row=self.row,
                              field=self.field))  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """The entry of ``problems`` in the JSON document."""
        return {
            "severity": self.severity, "kind": self.kind, "file": self.file, "row": self.row,
            "field": self.field, "expected": self.expected, "found": self.found,
            "message": self.message,
        }  # fmt: skip


@dataclass
class CheckReport:
    """What `check_set` found.

    Args:
        folder: The set.
        problems: Errors first. At most 1000 errors and 20 warnings of a kind are listed.
        kinds: Kind → how many there are in all.
        counts: Scenes, demonstrations, points, and labels per type and per scene.
    """

    folder: str
    problems: list[Problem] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    errors: int = 0
    warnings: int = 0
    counts: dict[str, Any] = field(default_factory=dict)

    @property
    def readable(self) -> bool:
        """Whether the other commands can read the set."""
        return self.errors == 0

    def error(self, fault: InputError, kind: str = "unreadable") -> None:
        """Counts one error, and lists it while there is room."""
        self.errors += 1
        self.kinds[kind] += 1
        if self.errors <= LISTED_ERRORS:
            self.problems.append(_problem("error", kind, fault, self.folder))

    def warn(self, kind: str, fault: InputError) -> None:
        """Counts one warning, and lists it while there is room."""
        self.warnings += 1
        self.kinds[kind] += 1
        if self.kinds[kind] <= LISTED_WARNINGS:
            self.problems.append(_problem("warning", kind, fault, self.folder))

    def add(self, oddity: Oddity, file: Path) -> None:
        """Counts every row of an oddity and lists its examples."""
        self.warnings += oddity.count
        self.kinds[oddity.kind] += oddity.count
        for row, words in oddity.examples:
            fault = InputError(oddity.expected, words, file=file, row=row, field=oddity.field)
            self.problems.append(_problem("warning", oddity.kind, fault, self.folder))

    def to_json(self) -> dict[str, Any]:
        """The JSON document of ``demospec check``."""
        return {
            "readable": self.readable,
            "errors": self.errors,
            "warnings": self.warnings,
            "kinds": dict(self.kinds),
            "problems": [p.to_json() for p in self.problems],
            "counts": self.counts,
        }


def _problem(severity: str, kind: str, fault: InputError, folder: str) -> Problem:
    return Problem(
        severity, kind, fault.expected, fault.found, fault.file or folder, fault.row, fault.field
    )


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
    scenes, names = _check_scenes(root, report, header, version)
    _check_rows(root, report, header, version, scenes, names, rows, progress)
    report.problems.sort(key=lambda p: p.severity != "error")
    return report


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
    root: Path, report: CheckReport, header: Header | None, version: int
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
        except InputError as error:
            report.error(error)
            continue
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


def _check_rows(
    root: Path,
    report: CheckReport,
    header: Header | None,
    version: int,
    scenes: list[Scene],
    names: set[str],
    rows: int,
    progress: Progress,
) -> None:
    file = root / PARQUET
    place = {scene.scene_id: i for i, scene in enumerate(scenes)}
    table = SceneTable.of(scenes)
    oddities = PathOddities(table, LISTED_WARNINGS)
    tally = _Tally()
    seen: set[int] = set()
    first_row = 0
    try:
        total = count_rows(root)
        for batch in arrow_batches(root, version, rows=rows):
            width = _width(batch) if header is None else len(header.columns)
            found, good, whole = table_faults(batch, file=file, columns=width, first_row=first_row)
            for fault in found:
                report.error(fault)
            if not whole:
                return
            places = first_row + np.flatnonzero(good)
            part = from_arrow(batch.filter(good), file=file, columns=width, first_row=first_row)
            scene_of = np.array([place.get(name, -1) for name in part.scene_id], dtype=np.int64)
            _check_names(part, places, seen, names, header, file, report)
            _check_far(part, scene_of, table, places, file, report)
            if len(part):
                oddities.add(part, scene_of, places)
                tally.add(part)
            first_row += len(batch)
            progress("check", first_row, total)
    except InputError as error:
        report.error(error)
        return
    if first_row == 0:
        fault = InputError("at least one demonstration", "none", file=file, field="demonstrations")
        report.error(fault)
        return
    for oddity in oddities.finish():
        report.add(oddity, file)
    tally.finish(report, header, scenes, file)


def _width(table: Any) -> int:
    """Numbers of the first point: what the set holds where its header does not say."""
    try:
        return len(table["points"][0].as_py()[0])
    except (KeyError, TypeError, IndexError):
        return 2


def _check_names(
    part: Demonstrations,
    places: IntArray,
    seen: set[int],
    names: set[str],
    header: Header | None,
    file: Path,
    report: CheckReport,
) -> None:
    for row, name in zip(places.tolist(), part.demo_id, strict=True):
        key = hash(name)
        if key in seen:
            fault = InputError("each demonstration once", name, file=file, row=row, field="demo_id")
            report.error(fault, "repeated_demonstration")
        seen.add(key)
    for row, name in zip(places.tolist(), part.scene_id, strict=True):
        if name not in names:
            fault = InputError("a scene of the set", name, file=file, row=row, field="scene_id")
            report.error(fault, "unknown_scene")
    types = None if header is None else set(header.types)
    for row, word in zip(places.tolist(), part.type, strict=True):
        if word is not None and types is not None and word not in types:
            expected = f"one of the set's types ({', '.join(sorted(types)) or 'none'})"
            fault = InputError(expected, word, file=file, row=row, field="type")
            report.error(fault, "unknown_type")


def _check_far(
    part: Demonstrations,
    scene_of: IntArray,
    table: SceneTable,
    places: IntArray,
    file: Path,
    report: CheckReport,
) -> None:
    """Points further outside the picture than the picture is wide: an error, as in reading."""
    if not len(table.size) or not len(part):
        return
    counts = np.diff(part.offsets)
    size = np.where((scene_of >= 0)[:, None], table.size[scene_of], np.inf)
    size = np.repeat(size, counts, axis=0)
    slack = size[:, :1]
    far: BoolArray = np.asarray(
        ((part.flat[:, :2] < -slack) | (part.flat[:, :2] > size + slack)).any(axis=1)
    )
    for path in np.flatnonzero(np.add.reduceat(far.astype(np.int64), part.offsets[:-1])):
        at = int(np.flatnonzero(far[part.offsets[path] : part.offsets[path + 1]])[0])
        x, y = part.points(int(path))[at, :2]
        width, height = size[part.offsets[path]]
        expected = f"points within one picture width of the picture ({width:g}x{height:g})"
        fault = InputError(
            expected, f"[{x:g}, {y:g}] in point {at}", file=file, row=int(places[path]),
            field="points",
        )  # fmt: skip
        report.error(fault, "far_outside")


class _Tally:
    """Counts per scene, type and label."""

    def __init__(self) -> None:
        self.types: Counter[tuple[str | None, int]] = Counter()
        self.scenes: Counter[tuple[str, int]] = Counter()
        self.demonstrators: Counter[str | None] = Counter()
        self.points = 0

    def add(self, part: Demonstrations) -> None:
        labels = part.valid.tolist()
        self.types.update(zip(part.type, labels, strict=True))
        self.scenes.update(zip(part.scene_id, labels, strict=True))
        self.demonstrators.update(part.demonstrator)
        self.points += len(part.flat)

    def finish(
        self, report: CheckReport, header: Header | None, scenes: list[Scene], file: Path
    ) -> None:
        types = _by_name(self.types)
        by_scene = _by_name(self.scenes)
        report.counts = {
            "scenes": len(scenes),
            "demonstrations": sum(self.scenes.values()),
            "points": self.points,
            "demonstrators": len([d for d in self.demonstrators if d is not None]),
            "types": types,
            "by_scene": by_scene,
            "splits": dict(Counter(s.split for s in scenes)),
        }
        for name, labels in types.items():
            word = f"type {name}"
            if labels["valid"] + labels["invalid"] == 0:
                fault = InputError("labels", f"none for {word}", file=file, field="valid")
                report.warn("unlabelled_type", fault)
            elif labels["valid"] == 0 or labels["invalid"] == 0:
                only = "valid" if labels["valid"] else "not valid"
                fault = InputError("both labels", f"{word}: all {only}", file=file, field="valid")
                report.warn("one_class", fault)
        known = set(self.types)
        for name in header.types if header is not None else ():
            if not any(key[0] == name for key in known):
                fault = InputError("demonstrations of each type", f"none of {name}", file=file,
                                   field="type")  # fmt: skip
                report.warn("type_without_demonstrations", fault)
        for scene in scenes:
            if scene.scene_id not in by_scene:
                fault = InputError("demonstrations in each scene", f"none in {scene.scene_id}",
                                   file=file, field="scene_id")  # fmt: skip
                report.warn("scene_without_demonstrations", fault)


def _by_name(counter: Counter[Any]) -> dict[str, dict[str, int]]:
    out: dict[str, dict[str, int]] = {}
    for (name, label), n in sorted(counter.items(), key=lambda item: str(item[0])):
        entry = out.setdefault(str(name), {"valid": 0, "invalid": 0, "unlabelled": 0})
        entry[{1: "valid", 0: "invalid"}.get(label, "unlabelled")] += n
    return out
