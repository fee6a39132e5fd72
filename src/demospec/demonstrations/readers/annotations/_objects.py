"""Files of objects, by their content: COCO, LabelMe, VIA, YOLO, Supervisely, drawn exports."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import ListedObjects, Source
from demospec.demonstrations.readers.annotations._names import names_of
from demospec.errors import InputError
from demospec.files import read_json
from demospec.progress import silent

_KINDS = "COCO, LabelMe, VIA, Supervisely, YOLO, Label Studio or CVAT"


def read_objects(path: Path, *, results: bool = False) -> list[ListedObjects]:
    """The objects of pictures that a file, or a folder of files, lists.

    Args:
        path: A JSON file (COCO, LabelMe, VIA, Supervisely, Label Studio), an XML file (CVAT), or a
            folder: of YOLO's text files, or of the JSON files of LabelMe or Supervisely.
        results: It is what a detector wrote: also lists of detections (COCO's results,
            `supervision`'s JSON and CSV), and confidences at the end of YOLO's lines.

    Raises:
        InputError: Nothing that is known, or what the format's reader says.
    """
    if path.is_dir():
        return _of_folder(path, results)
    if path.suffix.lower() in (".yaml", ".yml", ".names"):
        from demospec.demonstrations.readers.annotations._yolo import read_yolo

        return read_yolo(path.parent, results=results)
    if path.suffix.lower() == ".xml":
        from demospec.demonstrations.readers.annotations._cvat import read_cvat

        return _of_source(read_cvat(path, Mapping(), silent), path)
    if results and path.suffix.lower() == ".csv":
        from demospec.demonstrations.readers.annotations._supervision import read_detections_csv

        return read_detections_csv(path)
    document = read_json(path)
    if results and isinstance(document, list) and all(isinstance(i, dict) for i in document):
        from demospec.demonstrations.readers.annotations import _coco, _supervision

        if not document or "x_min" in document[0]:
            return _supervision.read_detections(document, path)
        if "image_id" in document[0]:
            return _coco.coco_results(document, path)
    if isinstance(document, list):
        from demospec.demonstrations.readers.annotations._label_studio import read_label_studio

        return _of_source(read_label_studio(path, Mapping(), silent), path)
    return _of_json(document, path)


def _of_json(document: Any, path: Path) -> list[ListedObjects]:
    from demospec.demonstrations.readers.annotations import _json_objects as json

    if not isinstance(document, dict):
        raise InputError(_KINDS, type(document).__name__, file=path)
    if "shapes" in document and "imagePath" in document:
        return [json.read_labelme(document, path)]
    if isinstance(document.get("objects"), list) and isinstance(document.get("size"), dict):
        return [json.read_supervisely(document, path)]
    if "_via_img_metadata" in document or (
        document and all(isinstance(v, dict) and "regions" in v for v in document.values())
    ):
        return json.read_via(document, path)
    if "images" in document or "annotations" in document or "categories" in document:
        from demospec.demonstrations.readers.annotations._coco import read_coco

        return read_coco(document, path)
    raise InputError(_KINDS, ", ".join(map(str, list(document)[:6])) or "{}", file=path)


def _of_folder(path: Path, results: bool) -> list[ListedObjects]:
    files = sorted(f for f in path.rglob("*.json") if f.is_file() and f.name != "meta.json")
    if not files:
        from demospec.demonstrations.readers.annotations._yolo import read_yolo

        return read_yolo(path, results=results)
    out: list[ListedObjects] = []
    for file in files:
        out += _of_json(read_json(file), file)
    return out


def _of_source(source: Source, path: Path) -> list[ListedObjects]:
    """The objects of an export that may hold paths as well."""
    listed = [s for s in source.scenes.values() if s.objects is not None]
    if not listed:
        raise InputError("outlined objects", "none", file=path)
    out: dict[str, ListedObjects] = {}
    for row, scene in enumerate(listed):
        name = scene.file_name or scene.scene_id
        if name in out:
            raise InputError("each picture once", name, file=path, row=scene.scene_id)
        out[name] = ListedObjects(names_of(name), scene.objects or (), scene.size_px, row=row)
    return list(out.values())
