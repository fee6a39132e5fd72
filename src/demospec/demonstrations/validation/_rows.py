"""`check` of the demonstrations: rows against the scenes, batch by batch."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._schema import Header
from demospec.demonstrations._store import PARQUET
from demospec.demonstrations._table import from_arrow
from demospec.demonstrations._trajectory import BoolArray, Demonstrations, IntArray
from demospec.demonstrations.large._partition import count_rows
from demospec.demonstrations.large._stream import arrow_batches
from demospec.demonstrations.validation._faults import table_faults
from demospec.demonstrations.validation._paths import PathOddities, SceneTable
from demospec.demonstrations.validation._report import LISTED_WARNINGS, CheckReport
from demospec.errors import InputError
from demospec.progress import Progress
from demospec.scene import Scene


def check_rows(
    root: Path,
    report: CheckReport,
    header: Header | None,
    version: int,
    scenes: list[Scene],
    names: set[str],
    rows: int,
    progress: Progress,
) -> None:
    """Adds to `report` what is wrong or odd about the demonstrations, batch by batch."""
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
