"""One region of Label Studio: its label, its answers, its shape or its path."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers.annotations._drawn import corners, number
from demospec.demonstrations.readers.annotations._masks import brush_mask, picture_mask
from demospec.demonstrations.readers.annotations._shapes import (
    box,
    ellipse,
    mask_outline,
    polygons,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint

ANSWERS = ("choices", "textarea", "rating", "number", "taxonomy", "datetime", "pairwise", "ranker")
"""Types of entries that answer a question."""

_KINDS = {
    "rectangle": "rectangle", "ellipse": "ellipse", "polygon": "polygon", "brush": "brush",
    "bitmask": "bitmask", "keypoint": "keypoint", "vector": "vector", "polyline": "vector",
}  # fmt: skip


@dataclass(frozen=True)
class Region:
    """The entries of one region of an annotation.

    Args:
        key: Its id, unique in the annotation.
        entries: Its shape, and perhaps its label and answers as entries of their own.
        path, row: The file, and the task in it.
    """

    key: str
    entries: list[dict[str, Any]]
    path: Path
    row: int

    @property
    def size(self) -> tuple[float, float] | None:
        """(width, height) of the picture as the annotator saw it, pixels; None without a shape."""
        for entry in self.entries:
            if shape_kind(entry) is not None:
                return self.scale(entry)
        return None

    def complain(self, expected: str, found: object, name: str) -> InputError:
        """An `InputError` about this region."""
        row = f"task {self.row}, region {self.key}"
        return InputError(expected, found, file=self.path, row=row, field=name)

    def scale(self, entry: dict[str, Any]) -> tuple[float, float]:
        """(original_width, original_height) of an entry, pixels."""
        row = f"task {self.row}, region {self.key}"
        names = ("original_width", "original_height")
        width, height = (number(entry.get(n), self.path, row, n) for n in names)
        if width <= 0 or height <= 0:
            raise self.complain("a size above 0", [width, height], "original_width")
        if entry.get("image_rotation") not in (None, 0):
            raise self.complain("a picture that was not turned", entry["image_rotation"],
                                "image_rotation")  # fmt: skip
        return width, height

    def label(self) -> str | None:
        """The region's label, or None; InputError where it has several."""
        found = [
            label
            for entry in self.entries
            for name, value in entry["value"].items()
            if name.endswith("labels") and isinstance(value, list)
            for label in value
        ]
        words = list(dict.fromkeys(str(label) for label in found))
        if len(words) > 1:
            raise self.complain("one label", ", ".join(words), "labels")
        return words[0] if words else None

    def refuse(self, entry: dict[str, Any]) -> None:
        """Refuses an entry of a type that is neither a shape nor an answer nor a label alone."""
        kind = str(entry.get("type"))
        value = entry["value"]
        if kind == "labels" and not any(k in value for k in ("x", "points", "vertices", "rle")):
            return
        raise self.complain(f"one of the shapes {', '.join(_KINDS)}", kind, "type")


def shape_kind(entry: dict[str, Any]) -> str | None:
    """The shape of an entry, or None where it has none that is read."""
    kind = str(entry.get("type", ""))
    for word in (kind, kind.removesuffix("labels")):
        if word in _KINDS:
            return _KINDS[word]
    return None


def read_answer(entry: dict[str, Any]) -> dict[str, Any]:
    """A question's name → its answer."""
    value, kind = entry["value"], str(entry.get("type"))
    answer = value.get(kind)
    if answer is None:
        answer = value.get("choices") or value.get("text")
    if isinstance(answer, list):
        plain = all(isinstance(a, (str, int, float)) for a in answer)
        if plain and len(answer) > 1:
            answer = ", ".join(map(str, answer))
        else:
            answer = answer[0] if plain and answer else None
    return {str(entry.get("from_name")): answer}


def read_path(region: Region, entry: dict[str, Any], label: str | None) -> FloatArray:
    """A drawn path, (n, 2) pixels."""
    value = entry["value"]
    row = f"task {region.row}, region {region.key}"
    vertices = value.get("vertices", value.get("points"))
    if value.get("closed") is True:
        raise region.complain("an open path (closed outlines are polygons)", label or "closed",
                              "closed")  # fmt: skip
    bent = ("controlPoint1", "controlPoint2")
    for vertex in vertices if isinstance(vertices, list) else ():
        if isinstance(vertex, dict) and any(vertex.get(k) is not None for k in bent):
            raise region.complain("straight lines between the vertices", "a curve", "vertices")
    points = corners(vertices, region.path, row, "vertices")
    return np.asarray(points * np.array(region.scale(entry)) / 100)


def read_shape(
    region: Region, entry: dict[str, Any], kind: str, label: str | None
) -> tuple[str, Footprint | tuple[float, float]]:
    """Symbol, and footprint (or the place of a point without size), pixels."""
    value = entry["value"]
    width, height = region.scale(entry)
    row = f"task {region.row}, region {region.key}"

    def share(name: str, whole: float) -> float:
        return number(value.get(name), region.path, row, name) * whole / 100

    turn = number(value.get("rotation") or 0, region.path, row, "rotation")
    shape: Footprint | tuple[float, float]
    try:
        if kind == "rectangle":
            sides = share("width", width), share("height", height)
            shape = box(share("x", width), share("y", height), *sides, turn, about="corner")
        elif kind == "ellipse":
            radii = share("radiusX", width), share("radiusY", height)
            shape = ellipse(share("x", width), share("y", height), *radii, turn)
        elif kind == "polygon":
            points = corners(value.get("points"), region.path, row, "points", least=3)
            shape = polygons([points * np.array([width, height]) / 100])
        elif kind == "keypoint":
            place = share("x", width), share("y", height)
            # Label Studio draws a disc whose radius is this share of the picture's width.
            radius = share("width", width) if value.get("width") is not None else 0.0
            shape = ellipse(*place, radius, radius) if radius > 0 else place
        elif kind == "brush":
            if value.get("format") != "rle" or not isinstance(value.get("rle"), list):
                raise InputError("run lengths", value.get("format"), field="format")
            shape = mask_outline(brush_mask(value["rle"], round(width), round(height)))
        else:
            shape = mask_outline(picture_mask(value.get("imageDataURL"), region.path))
    except InputError as error:
        raise error.at(file=region.path, row=row) from error
    return str(label or "object"), shape
