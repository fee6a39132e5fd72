"""``onnx:``: a detector exported to ONNX, run by onnxruntime."""

from __future__ import annotations

import ast
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.errors import InputError, MissingExtraError
from demospec.files import read_json
from demospec.frames import FloatArray
from demospec.perception.detectors._layouts import STRETCHED, Decoded, Layout, decode
from demospec.perception.detectors._listing import surest
from demospec.perception.detectors._protocol import Finding
from demospec.scene import Image

LEAST = 0.05
"""Detections below this are not looked at: an export lists thousands that are nothing."""

MOST = 300
"""Detections of one picture that are kept."""

_ANY_SIZE = 640
_BAR = 114  # grey of the bars beside a picture that is not square, as YOLO is trained


class OnnxDetector:
    """A model with one picture as input: (1, 3, h, w) or (3, h, w), RGB from 0 to 1 (or 0 to 255
    where the input is of bytes).

    Pictures keep their shape between grey bars (YOLO), or are stretched (RT-DETR); a model whose
    input may have any size (Mask R-CNN) gets the picture as it is. The names of the classes are
    the model's metadata ``names`` (as Ultralytics writes them), else the file beside it that is
    called as the model and ends in ``.names``, ``.txt`` (a class a line) or ``.json`` (a list, or
    number → name); else the classes are called by their numbers. A second input (1, 2) of whole
    numbers gets the size to which boxes are scaled (RT-DETR as its authors export it).

    Raises:
        MissingExtraError: onnxruntime is not installed.
        InputError: No file, no model, more inputs than a picture, names that are none.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        try:
            import onnxruntime as ort
        except ImportError as error:
            raise MissingExtraError("onnxruntime", "detect", "detectors in ONNX") from error
        self.path = Path(path)
        if not self.path.is_file():
            raise InputError("a model in ONNX", "nothing there", file=self.path)
        options = ort.SessionOptions()
        options.intra_op_num_threads = 1
        options.log_severity_level = 3
        try:
            self.session: Any = ort.InferenceSession(
                str(self.path), options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime's own exceptions share no base of its own
            raise InputError("a model in ONNX", str(error).splitlines()[0], file=self.path) from (
                error
            )
        inputs = self.session.get_inputs()
        shape = inputs[0].shape if inputs else []
        sized = len(inputs) == 2 and inputs[1].shape[-1:] == [2] and "int64" in inputs[1].type
        self._size_of = inputs[1].name if sized else None
        if not (len(inputs) == 1 or sized) or len(shape) not in (3, 4):
            found = ", ".join(f"{i.name} {i.shape}" for i in inputs)
            raise InputError(
                "one input, a picture (and its size)", found, file=self.path, field="inputs"
            )
        self._layout: Layout | None = None

    @property
    def name(self) -> str:
        """``onnx:`` and the file's name."""
        return f"onnx:{self.path.name}"

    @cached_property
    def classes(self) -> dict[int, str]:
        """Number → name; empty where nobody says."""
        given = self._said.get("names")
        if given is not None:
            try:
                return _numbered(ast.literal_eval(given))
            except (ValueError, SyntaxError, TypeError) as error:
                raise InputError("names of classes", given, file=self.path,
                                 field="metadata names") from error  # fmt: skip
        return names_beside(self.path)

    def detect(self, pixels: Image, names: Sequence[str] = ()) -> list[Finding]:
        """The things in a picture, doubtful ones too, one a place."""
        del names
        stretch = self._layout in STRETCHED or self._size_of is not None
        layout, decoded, fit = self._run(pixels, stretch)
        if layout in STRETCHED and self._layout is None:  # the first picture, between bars
            layout, decoded, fit = self._run(pixels, True)
        self._layout = layout
        height, width = pixels.shape[:2]
        out = []
        for i in surest(decoded.boxes, decoded.scores)[:MOST]:
            corners = fit.in_picture(decoded.boxes[i].reshape(2, 2))
            sides = (*corners[0].tolist(), *(corners[1] - corners[0]).tolist())
            number = int(decoded.classes[i])
            mask = None
            if decoded.masks is not None:
                mask = _whole(decoded.masks[i], corners, decoded.inside, (width, height), fit)
                mask = mask if mask.any() else None
            symbol = self.classes.get(number, str(number))
            out.append(Finding(symbol, float(decoded.scores[i]), bbox=sides, mask=mask))
        return out

    def _run(self, pixels: Image, stretch: bool) -> tuple[Layout, Decoded, _Fit]:
        given = self.session.get_inputs()[0]
        height, width = pixels.shape[:2]
        rows, columns = given.shape[-2:]
        size = (width, height)
        if isinstance(rows, int) and isinstance(columns, int):
            size = (columns, rows)
        elif "stride" in self._said:  # Ultralytics: whole strides, the side of its training
            size = (self._side(), self._side())
        fed, fit = _input(pixels, size, stretch)
        values: NDArray[Any] = fed
        if "uint8" not in given.type:
            kind = np.float16 if "float16" in given.type else np.float32
            values = (fed.astype(np.float32) / np.float32(255)).astype(kind)
        values = np.ascontiguousarray(values.transpose(2, 0, 1))
        if len(given.shape) == 4:
            values = values[None]
        try:
            fed_with: dict[str, NDArray[Any]] = {given.name: values}
            if self._size_of is not None:
                fed_with[self._size_of] = np.array([size], dtype=np.int64)
            outputs = self.session.run(None, fed_with)
        except Exception as error:  # as above
            line = str(error).splitlines()[0]
            raise InputError("a model that runs on a picture", line, file=self.path) from error
        named = {o.name: a for o, a in zip(self.session.get_outputs(), outputs, strict=True)}
        try:
            return *decode(named, size, len(self.classes) or None, LEAST), fit
        except InputError as error:
            raise error.at(file=self.path) from error

    @property
    def _said(self) -> dict[str, str]:
        """The model's metadata."""
        return dict(self.session.get_modelmeta().custom_metadata_map)

    def _side(self) -> int:
        try:
            return int(max(ast.literal_eval(self._said.get("imgsz", ""))))
        except (ValueError, SyntaxError, TypeError):
            return _ANY_SIZE


@dataclass(frozen=True)
class _Fit:
    """How a picture lies in a model's input: `size` of the input, input pixels per picture pixel
    (2,), and the picture's corner in it (2,)."""

    size: tuple[int, int]
    factor: FloatArray
    corner: FloatArray

    def in_picture(self, points: FloatArray) -> FloatArray:
        return np.asarray((points - self.corner) / self.factor)

    def in_input(self, points: FloatArray) -> FloatArray:
        return np.asarray(points * self.factor + self.corner)


def names_beside(model: Path) -> dict[int, str]:
    """The names in the file beside a model; empty where there is none."""
    for ending in (".names", ".txt", ".json"):
        file = model.with_suffix(ending)
        if file.is_file():
            if ending == ".json":
                return _numbered(read_json(file), file)
            lines = file.read_text(encoding="utf-8-sig").splitlines()
            return {i: line.strip() for i, line in enumerate(lines) if line.strip()}
    return {}


def _numbered(given: Any, file: Path | None = None) -> dict[int, str]:
    if isinstance(given, list):
        given = dict(enumerate(given))
    try:
        return {int(k): str(v) for k, v in given.items() if str(v).strip()}
    except (AttributeError, ValueError) as error:
        raise InputError("names of classes", given, file=file) from error


def _input(pixels: Image, size: tuple[int, int], stretch: bool) -> tuple[Image, _Fit]:
    """The picture at the size of the model's input."""
    from PIL import Image as Pictures

    height, width = pixels.shape[:2]
    factor = np.array(size) / np.array([width, height])
    if size == (width, height):
        return pixels, _Fit(size, factor, np.zeros(2))
    if not stretch:
        factor = np.full(2, factor.min())
    w, h = (max(int(v), 1) for v in np.round(factor * [width, height]))
    small = Pictures.fromarray(pixels).resize((w, h), Pictures.Resampling.BILINEAR)
    x, y = (size[0] - w) // 2, (size[1] - h) // 2
    whole = np.full((size[1], size[0], 3), _BAR, dtype=np.uint8)
    whole[y : y + h, x : x + w] = np.asarray(small)
    return whole, _Fit(size, np.array([w / width, h / height]), np.array([float(x), float(y)]))


def _whole(
    mask: FloatArray, box: FloatArray, fills: bool, size_px: tuple[int, int], fit: _Fit
) -> NDArray[np.bool_]:
    """A mask (h, w) of the model's input, or one that fills a box (2, 2) of the picture, as one
    of the picture; outside of its box it says nothing."""
    from demospec.geometry import read_map

    u, v = np.meshgrid(np.arange(size_px[0]) + 0.5, np.arange(size_px[1]) + 0.5)
    points = np.stack([u, v], axis=-1)
    if fills:
        w, h = (max(float(side), 1e-9) for side in box[1] - box[0])
        on = read_map(mask, points - box[0], (w, h)) > 0.5
    else:
        on = read_map(mask, fit.in_input(points), fit.size) > 0.5
    inside = (points >= box[0]).all(axis=-1) & (points <= box[1]).all(axis=-1)
    return np.asarray(inside & on)
