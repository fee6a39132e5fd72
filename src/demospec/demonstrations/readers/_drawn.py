"""Paths drawn over pictures: Label Studio's JSON export and "CVAT for images" XML."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import RawScene, Recording, Source
from demospec.errors import InputError
from demospec.files import read_bytes, read_json
from demospec.frames import FloatArray
from demospec.progress import Progress
from demospec.scene import Picture, Polygon, SceneObject, rectangle


def read_label_studio(path: Path, mapping: Mapping, progress: Progress) -> Source:
    """Label Studio's JSON export (a list of tasks).

    Vector and polyline regions are demonstrations; polygon and rectangle regions are objects.
    Percentages become pixels with the region's ``original_width`` and ``original_height``.
    A region's label and the answers to its per-region questions are fields (``label``, and the
    question's name).
    """
    source = Source("label-studio", name=path.stem)
    document = read_json(path)
    if not isinstance(document, list):
        raise InputError("a list of tasks", type(document).__name__, file=path)
    for row, task in enumerate(document):
        if not isinstance(task, dict):
            raise InputError("a task", task, file=path, row=row)
        _read_task(task, row, path, source)
        progress("read", row + 1, len(document))
    source.notes.append(f"read: {len(source.recordings)} drawn paths in {len(document)} tasks")
    return source


def _read_task(task: dict[str, Any], row: int, path: Path, source: Source) -> None:
    data = task.get("data") if isinstance(task.get("data"), dict) else {}
    image = next((v for v in (data or {}).values() if isinstance(v, str) and "." in v), None)
    name = f"task-{task.get('id', row)}"
    objects: list[SceneObject] = []
    paths: dict[str, tuple[FloatArray, dict[str, Any]]] = {}
    answers: dict[str, dict[str, Any]] = {}
    annotations = task.get("annotations") or task.get("completions") or []
    for annotation in annotations if isinstance(annotations, list) else []:
        for region in annotation.get("result", []) if isinstance(annotation, dict) else []:
            if isinstance(region, dict):
                _read_region(region, path, row, objects, paths, answers)
    for key, (points, fields) in paths.items():
        source.recordings.append(
            Recording(
                f"{name}-{key}", points, ("x", "y"), fields={**fields, **answers.get(key, {})},
                scene=name, file=path, row=f"task {row}, region {key}",
            )
        )  # fmt: skip
    source.scenes[name] = RawScene(
        name, load=_picture(path.parent, image), objects=tuple(objects) or None, file_name=image
    )


def _read_region(
    region: dict[str, Any],
    path: Path,
    row: int,
    objects: list[SceneObject],
    paths: dict[str, tuple[FloatArray, dict[str, Any]]],
    answers: dict[str, dict[str, Any]],
) -> None:
    kind = str(region.get("type", ""))
    value = region.get("value")
    key = str(region.get("id", f"{len(paths) + len(objects)}"))
    if not isinstance(value, dict):
        return
    label = next(
        (v[0] for k, v in value.items() if k.endswith("labels") and isinstance(v, list) and v),
        None,
    )
    if kind in ("choices", "textarea", "rating", "number"):
        answer = value.get("choices") or value.get("text") or value.get(kind)
        first = answer[0] if isinstance(answer, list) and answer else answer
        answers.setdefault(key, {})[str(region.get("from_name"))] = first
        return
    corners = value.get("vertices", value.get("points"))
    if kind.startswith("rectangle"):
        scale = _scale(region, path, row)
        x, y, w, h = (_number(value.get(k), path, row, k) for k in ("x", "y", "width", "height"))
        box = (x * scale[0], y * scale[1], w * scale[0], h * scale[1])
        name = f"{label or 'object'}-{len(objects)}"
        centre = (box[0] + box[2] / 2, box[1] + box[3] / 2)
        objects.append(SceneObject(name, str(label or "object"), centre, box, rectangle(*box)))
    elif isinstance(corners, list) and corners:
        points = _percent(corners, path, row) * np.array(_scale(region, path, row))
        if kind.startswith("polygon"):
            name = f"{label or 'object'}-{len(objects)}"
            objects.append(_outlined(name, str(label or "object"), points))
        else:
            paths[key] = (points, {"label": label} if label is not None else {})


def _outlined(name: str, symbol: str, points: FloatArray) -> SceneObject:
    low, high = points.min(axis=0), points.max(axis=0)
    box = (float(low[0]), float(low[1]), float(high[0] - low[0]), float(high[1] - low[1]))
    centre = (box[0] + box[2] / 2, box[1] + box[3] / 2)
    return SceneObject(name, symbol, centre, box, Polygon(points))


def _number(value: Any, path: Path, row: int, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError("a number", value, file=path, row=row, field=name)
    return float(value)


def _scale(region: dict[str, Any], path: Path, row: int) -> tuple[float, float]:
    """Pixels per per cent, in x and y."""
    width = _number(region.get("original_width"), path, row, "original_width")
    height = _number(region.get("original_height"), path, row, "original_height")
    return width / 100, height / 100


def _percent(corners: list[Any], path: Path, row: int) -> FloatArray:
    pairs = [[c.get("x"), c.get("y")] if isinstance(c, dict) else c for c in corners]
    try:
        points = np.array(pairs, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("points [x, y]", "something else", file=path, row=row) from error
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError("points [x, y]", f"shape {points.shape}", file=path, row=row)
    return points


def _picture(folder: Path, name: str | None) -> Any:
    """A loader for the picture, where the file lies beside the export; else None."""
    if name is None:
        return None
    for candidate in (name, f"images/{Path(name).name}", Path(name).name):
        file = folder / candidate
        try:
            here = file.is_file() and file.resolve().is_relative_to(folder.resolve())
        except (OSError, ValueError, RuntimeError):
            here = False
        if here:
            return lambda: _opened(file)
    return None


def _opened(file: Path) -> Picture:
    picture = Picture(file=file)
    _ = picture.size_px
    return picture


def read_cvat(path: Path, mapping: Mapping, progress: Progress) -> Source:
    """ "CVAT for images 1.1" XML: polylines are demonstrations, boxes and polygons objects.

    A polyline's label and its attributes are fields. Source: docs.cvat.ai, "XML annotation
    format".
    """
    import xml.etree.ElementTree as ET

    source = Source("cvat", name=path.stem)
    data = read_bytes(path, limit_bytes=1 << 28)
    if b"\x00" in data:  # UTF-16 would hide what the next line looks for
        raise InputError("XML in UTF-8", "NUL bytes", file=path)
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise InputError("XML without a document type", "a document type", file=path)
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise InputError("an XML file", str(error), file=path) from error
    if root.tag != "annotations":
        raise InputError("an element annotations", root.tag[:40], file=path)
    for row, image in enumerate(root.iter("image")):
        _read_image(image, row, path, source)
    source.notes.append(f"read: {len(source.recordings)} polylines")
    return source


def _read_image(image: Any, row: int, path: Path, source: Source) -> None:
    file_name = image.get("name")
    name = Path(file_name).stem if file_name else f"image-{row}"
    if name in source.scenes:
        raise InputError("each picture once", name, file=path, row=row, field="name")
    objects: list[SceneObject] = []
    for item in image:
        label = item.get("label") or "object"
        if item.tag == "polyline":
            fields: dict[str, Any] = {"label": label}
            fields.update({a.get("name", "?"): a.text for a in item.iter("attribute")})
            number = sum(r.scene == name for r in source.recordings)
            source.recordings.append(
                Recording(
                    f"{name}-{number}", _pairs(item.get("points"), path, row), ("x", "y"),
                    fields=fields, scene=name, file=path, row=f"image {row}",
                )
            )  # fmt: skip
        elif item.tag == "polygon":
            points = _pairs(item.get("points"), path, row)
            if len(points) >= 3:
                objects.append(_outlined(f"{label}-{len(objects)}", label, points))
        elif item.tag == "box":
            corners = [item.get(k) for k in ("xtl", "ytl", "xbr", "ybr")]
            a, b = _pairs(f"{corners[0]},{corners[1]};{corners[2]},{corners[3]}", path, row)
            box = (float(a[0]), float(a[1]), float(b[0] - a[0]), float(b[1] - a[1]))
            centre = (box[0] + box[2] / 2, box[1] + box[3] / 2)
            shape = rectangle(*box)
            objects.append(SceneObject(f"{label}-{len(objects)}", label, centre, box, shape))
    source.scenes[name] = RawScene(
        name, load=_picture(path.parent, file_name), objects=tuple(objects) or None,
        file_name=file_name, split=(image.get("subset") or "train").lower(),
    )  # fmt: skip


def _pairs(text: str | None, path: Path, row: int) -> FloatArray:
    """``"x,y;x,y"`` → (n, 2)."""
    try:
        points = np.array(
            [[float(v) for v in pair.split(",")] for pair in (text or "").split(";")],
            dtype=np.float64,
        )
    except ValueError as error:
        raise InputError("x,y;x,y;…", text or "nothing", file=path, row=row,
                         field="points") from error  # fmt: skip
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise InputError("x,y;x,y;…", text or "nothing", file=path, row=row, field="points")
    return points
