"""Label Studio's JSON export: vectors are demonstrations, every other region is an object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import RawScene, Recording, Source
from demospec.demonstrations.readers.annotations._agreement import agreed
from demospec.demonstrations.readers.annotations._drawn import picture_beside, unlisted_if_never
from demospec.demonstrations.readers.annotations._regions import (
    ANSWERS,
    Region,
    read_answer,
    read_path,
    read_shape,
    shape_kind,
)
from demospec.errors import InputError
from demospec.files import read_json
from demospec.progress import Progress

_PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".gif")


def read_label_studio(path: Path, mapping: Mapping, progress: Progress) -> Source:
    """Label Studio's JSON export (a list of tasks).

    Vector and polyline regions are demonstrations, each of them; rectangles, ellipses, polygons,
    brushes, masks and key points are objects. Turned rectangles turn about their corner, ellipses
    about their centre, as Label Studio shows them. Percentages become pixels with the region's
    ``original_width`` and ``original_height``. A region's label, the answers to its questions and
    to those about the picture, and the annotator are fields.

    Cancelled annotations are left out, and a task that was only skipped is no scene. Of several
    annotators every path counts; their objects are one list: what two of them outlined at one
    place is one object. Where one annotation is the ground truth, the objects are its.

    Raises:
        InputError: A region that cannot be read, annotators who disagree about what a thing is.
    """
    source = Source("label-studio", name=path.stem)
    document = read_json(path)
    if not isinstance(document, list):
        raise InputError("a list of tasks", type(document).__name__, file=path)
    left_out = skipped = 0
    for row, task in enumerate(document):
        if not isinstance(task, dict):
            raise InputError("a task", task, file=path, row=row)
        annotations = _annotations(task, path, row)
        kept = [a for a in annotations if a.get("was_cancelled") is not True]
        left_out += len(annotations) - len(kept)
        if kept or not annotations:
            _read_task(task, kept, row, path, source)
        else:
            skipped += 1
        progress("read", row + 1, len(document))
    unlisted_if_never(source)
    source.notes.append(f"read: {len(source.recordings)} drawn paths in {len(source.scenes)} tasks")
    if left_out:
        source.notes.append(f"left out: {left_out} cancelled annotations, {skipped} skipped tasks")
    return source


def _annotations(task: dict[str, Any], path: Path, row: int) -> list[dict[str, Any]]:
    found = task.get("annotations") or task.get("completions") or []
    if not isinstance(found, list) or not all(isinstance(a, dict) for a in found):
        raise InputError("a list of annotations", "something else", file=path, row=row,
                         field="annotations")  # fmt: skip
    return found


@dataclass
class _Annotation:
    """One annotator's work on one picture."""

    name: str
    annotator: str | None
    truth: bool
    paths: list[tuple[Region, Any]] = field(default_factory=list)
    objects: list[tuple[str, Any]] = field(default_factory=list)
    answers: dict[str, dict[str, Any]] = field(default_factory=dict)
    whole: dict[str, Any] = field(default_factory=dict)


def _read_task(
    task: dict[str, Any], annotations: list[dict[str, Any]], row: int, path: Path, source: Source
) -> None:
    image = _picture_name(task.get("data"))
    name = f"task-{task.get('id', row)}"
    if name in source.scenes:
        raise InputError("each task once", name, file=path, row=row, field="id")
    size: tuple[float, float] | None = None
    read: list[_Annotation] = []
    for number, annotation in enumerate(annotations):
        made = _Annotation(
            str(annotation.get("id", number)),
            _annotator(annotation.get("completed_by")),
            annotation.get("ground_truth") is True,
        )
        for region in _regions(annotation, path, row):
            if region.size is not None:
                if size not in (None, region.size):
                    raise region.complain(f"a picture of {size}, as before", region.size,
                                          "original_width")  # fmt: skip
                size = region.size
            _add_region(region, made)
        read.append(made)
    truths = [a for a in read if a.truth]
    objects = agreed(
        [[(key, item) for key, item in a.objects] for a in truths or read], size, path, row,
        source.notes,
    )  # fmt: skip
    _add_recordings(read, name, path, row, source)
    source.scenes[name] = RawScene(
        name,
        load=picture_beside(path.parent, image),
        objects=objects if annotations else None,
        file_name=image,
        size_px=size,
    )


def _picture_name(data: object) -> str | None:
    """The task's picture: what ends as pictures do, else the first text with a dot."""
    words = [v for v in data.values() if isinstance(v, str)] if isinstance(data, dict) else []
    pictures = [v for v in words if v.lower().endswith(_PICTURES)]
    return next(iter(pictures), next((v for v in words if "." in v), None))


def _annotator(value: object) -> str | None:
    if isinstance(value, dict):
        value = value.get("email") or value.get("id")
    return None if value is None or isinstance(value, (dict, list)) else str(value)


def _regions(annotation: dict[str, Any], path: Path, row: int) -> Iterator[Region]:
    """The regions of an annotation: entries of one id are one region."""
    entries = annotation.get("result") or []
    if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
        raise InputError("a list of regions", "something else", file=path, row=row, field="result")
    groups: dict[str, list[dict[str, Any]]] = {}
    for number, entry in enumerate(entries):
        if isinstance(entry.get("value"), dict):
            groups.setdefault(str(entry.get("id", f"region-{number}")), []).append(entry)
        elif entry.get("type") != "relation":  # which has none
            raise InputError("an object value", entry.get("value"), file=path,
                             row=f"task {row}, entry {number}", field="value")  # fmt: skip
    for key, group in groups.items():
        yield Region(key, group, path, row)


def _add_region(region: Region, made: _Annotation) -> None:
    drawn = [e for e in region.entries if str(e.get("type")) not in ANSWERS]
    answers: dict[str, Any] = {}
    for entry in region.entries:
        if entry not in drawn:
            answers.update(read_answer(entry))
    shapes = [e for e in drawn if shape_kind(e) is not None]
    if not shapes:
        for entry in drawn:
            region.refuse(entry)
        made.whole.update(answers)
        return
    made.answers[region.key] = answers
    kind = shape_kind(shapes[0])
    label = region.label()
    if kind == "vector":
        made.paths.append((region, read_path(region, shapes[0], label)))
    else:
        read = read_shape(region, shapes[0], str(kind), label)
        made.objects.append((region.key, read))


def _add_recordings(
    read: list[_Annotation], name: str, path: Path, row: int, source: Source
) -> None:
    taken: set[str] = set()
    for annotation in read:
        for region, points in annotation.paths:
            key = region.key
            if key in taken:  # two annotators began from one pre-annotation
                key = f"{annotation.name}-{key}"
            taken.add(key)
            label = region.label()
            fields = {**annotation.whole, **annotation.answers.get(region.key, {})}
            if label is not None:
                fields["label"] = label
            if annotation.annotator is not None:
                fields["annotator"] = annotation.annotator
            source.recordings.append(
                Recording(
                    f"{name}-{key}", points, ("x", "y"), fields=fields, scene=name, file=path,
                    row=f"task {row}, region {region.key}",
                )
            )  # fmt: skip
