"""CVAT's XML: polylines over pictures and moving tracks of videos are demonstrations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import RawScene, Recording, Source
from demospec.demonstrations.readers.annotations._cvat_shapes import (
    attributes,
    footprint,
    pairs,
    size_of,
)
from demospec.demonstrations.readers.annotations._cvat_video import read_tracks
from demospec.demonstrations.readers.annotations._drawn import picture_beside, unlisted_if_never
from demospec.demonstrations.readers.annotations._shapes import ObjectList
from demospec.errors import InputError
from demospec.files import read_bytes
from demospec.progress import Progress

_NO_SHAPES = ("attribute", "tag")


def read_cvat(path: Path, mapping: Mapping, progress: Progress) -> Source:
    """ "CVAT for images 1.1" or "CVAT for video 1.1" XML.

    For images: polylines are demonstrations; boxes, ellipses, polygons, masks and single points
    are objects; turned boxes and ellipses turn about their centres. A point with an attribute
    ``radius`` is a disc. For videos: a track that moves is a demonstration, one point a frame; a
    track that stands still is an object. A polyline's ``label``, a track's ``class`` (its label)
    and their attributes are fields.

    Source: docs.cvat.ai, "XML annotation format".

    Raises:
        InputError: Broken XML, a picture twice, a shape that is not read.
    """
    source = Source("cvat", name=path.stem)
    root = _root(path)
    pictures, tracks = list(root.iter("image")), list(root.iter("track"))
    if pictures and tracks:
        raise InputError("pictures or tracks of a video", "both", file=path)
    for row, image in enumerate(pictures):
        _read_image(image, row, path, source)
    if tracks:
        read_tracks(root, tracks, path, source)
    unlisted_if_never(source)
    what = f"{len(tracks)} tracks" if tracks else f"{len(pictures)} pictures"
    source.notes.append(f"read: {len(source.recordings)} paths from {what}")
    return source


def _root(path: Path) -> Any:
    import xml.etree.ElementTree as ET

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
    return root


def _read_image(image: Any, row: int, path: Path, source: Source) -> None:
    file_name = image.get("name")
    name = Path(file_name.replace("\\", "/")).stem if file_name else f"image-{row}"
    if name in source.scenes and image.get("task_id") is not None:
        name = f"{name}-task-{image.get('task_id')}"  # a project's tasks have pictures of their own
    if name in source.scenes:
        raise InputError("each picture once", name, file=path, row=row, field="name")
    objects = ObjectList()
    number = 0
    for item in image:
        if item.tag in _NO_SHAPES:
            continue
        label = item.get("label")
        if not label:
            raise InputError("a label", "none", file=path, row=f"image {row}, {item.tag}",
                             field="label")  # fmt: skip
        fields = {"label": label, **attributes(item)}
        if item.tag == "polyline":
            where = f"image {row}, polyline {number}"
            points = pairs(item.get("points"), path, where)
            source.recordings.append(
                Recording(f"{name}-{number}", points, ("x", "y"), fields=fields, scene=name,
                          file=path, row=where)
            )  # fmt: skip
            number += 1
            continue
        where = f"image {row}, {item.tag} {label}"
        try:
            shape = footprint(item, path, where)
            if isinstance(shape, tuple):
                objects.add(label, None, center=shape)
            else:
                objects.add(label, shape)
        except InputError as error:
            raise error.at(file=path, row=where) from error
    source.scenes[name] = RawScene(
        name, load=picture_beside(path.parent, file_name), objects=tuple(objects.objects),
        file_name=file_name, split=(image.get("subset") or "train").lower(),
        size_px=size_of(image, path, row),
    )  # fmt: skip
