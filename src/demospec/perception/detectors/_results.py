"""``json:``: what any tool wrote down of its detections, by the readers of object files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from demospec.errors import InputError
from demospec.geometry import MultiPolygon, Polygon
from demospec.perception.detectors._protocol import Finding
from demospec.scene import Image, SceneObject

if TYPE_CHECKING:
    from demospec.demonstrations.readers import ListedObjects


class ListedDetections:
    """Detections of COCO, YOLO (text files), LabelMe, VIA, CVAT, Label Studio, supervision.

    A confidence that the file does not state is 1.

    Raises:
        InputError: Nothing there, or nothing that is known.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        from demospec.demonstrations.readers import read_objects

        self.path = Path(path)
        if not self.path.exists():
            raise InputError("a file or folder of detections", "nothing there", file=self.path)
        self.lists = read_objects(self.path, results=True)
        self._at: dict[str, int] = {}
        for i, entry in enumerate(self.lists):
            for name in entry.names:
                if self._at.setdefault(name, i) != i:
                    self._at[name] = -1  # of several pictures: no name of either

    @property
    def name(self) -> str:
        """``json:`` and the file's name."""
        return f"json:{self.path.name}"

    def detect(self, pixels: Image, names: Sequence[str] = ()) -> list[Finding] | None:
        """The picture's list, scaled to its size; None where the file has none for it."""
        entry = self._entry(names)
        if entry is None:
            return None
        height, width = pixels.shape[:2]
        matrix = np.eye(2)
        if entry.relative:
            matrix = np.diag([float(width), float(height)])
        elif entry.size_px is not None and entry.size_px != (width, height):
            factor = np.array([width, height]) / np.array(entry.size_px)
            if abs(factor[0] / factor[1] - 1) > 0.02:
                expected = f"detections on a picture shaped as {width}x{height}"
                found = f"{entry.size_px[0]:g}x{entry.size_px[1]:g}"
                raise InputError(expected, found, file=self.path, row=entry.row)
            matrix = np.diag(factor)
        scores = entry.scores or (None,) * len(entry.objects)
        out = []
        for item, score in zip(entry.objects, scores, strict=True):
            try:
                out += _findings(item, 1.0 if score is None else score, matrix)
            except InputError as error:
                raise error.at(file=self.path, row=item.id) from error
        return out

    def _entry(self, names: Sequence[str]) -> ListedObjects | None:
        numbers = [n.lstrip("0") or "0" for n in names if n.isdecimal()]  # COCO's ids of pictures
        found = next((self._at[n] for n in (*names, *numbers) if n in self._at), None)
        if found == -1:
            raise InputError("one picture of that name", "several", file=self.path, row=names[0])
        if found is None and len(self.lists) == 1 and not self.lists[0].names:
            found = 0
        return None if found is None else self.lists[found]


def _findings(item: SceneObject, sure: float, matrix: np.ndarray) -> list[Finding]:
    shape = item.footprint
    if shape is None:
        if item.bbox is None:
            raise InputError("a box or outline", "a point", field=item.symbol)
        x, y, w, h = item.bbox
        shape = Polygon([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
    if isinstance(shape, MultiPolygon):
        parts = [part.vertices @ matrix.T for part in shape.parts]
        return [Finding(item.symbol, sure, polygon=MultiPolygon(parts))]
    assert isinstance(shape, Polygon)
    rim = shape.vertices @ matrix.T
    low, high = rim.min(axis=0), rim.max(axis=0)
    square = len(rim) == 4 and all(((p == low) | (p == high)).all() for p in rim)
    if square:
        sides = (*low.tolist(), *(high - low).tolist())
        return [Finding(item.symbol, sure, bbox=sides)]
    return [Finding(item.symbol, sure, polygon=rim)]
