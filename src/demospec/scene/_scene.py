"""What a scene is: a top-down picture, the objects in it, a start and a goal."""

from __future__ import annotations

import os
import struct
import warnings
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import CannotJudgeError, InputError
from demospec.geometry import Bounds, Disc, Footprint, Polygon, bounds_of, extent, rectangle
from demospec.scene._plain_png import plain_png_size
from demospec.scene._upright import upright, upright_size
from demospec.scene._whole import is_truncated

if TYPE_CHECKING:
    from demospec.scene._recipe import SceneRecipe

Image = NDArray[np.uint8]

MAX_PICTURE_PIXELS = 64_000_000
"""Largest picture that is decoded; a larger one is taken for a decompression bomb."""


@dataclass(frozen=True)
class SceneObject:
    """One object on the table.

    Args:
        id: Unique in its scene.
        symbol: Class word, such as ``glass``.
        center: Pixels.
        bbox: (x, y, width, height), pixels, or None.
        footprint: Outline on the table, or None where it is not known. Read from
            ``polygon``, else from ``radius``, else from ``bbox`` (as a rectangle).
    """

    id: str
    symbol: str
    center: tuple[float, float]
    bbox: tuple[float, float, float, float] | None = None
    footprint: Footprint | None = None

    @property
    def outline(self) -> Footprint:
        """The footprint where known, else the centre as a disc of radius 0."""
        return self.footprint if self.footprint is not None else Disc(self.center, 0.0)

    def moved(self, by: ArrayLike) -> SceneObject:
        """The same object translated by `by` (2,), pixels."""
        dx, dy = (float(v) for v in np.asarray(by, dtype=np.float64))
        box = self.bbox and (self.bbox[0] + dx, self.bbox[1] + dy, self.bbox[2], self.bbox[3])
        shape = self.footprint.moved((dx, dy)) if self.footprint is not None else None
        return replace(
            self, center=(self.center[0] + dx, self.center[1] + dy), bbox=box, footprint=shape
        )

    def to_json(self) -> dict[str, Any]:
        """The object as in ``scenes/metadata.jsonl``."""
        document: dict[str, Any] = {
            "id": self.id,
            "symbol": self.symbol,
            "center": list(self.center),
        }
        if self.bbox is not None:
            document["bbox"] = list(self.bbox)
        if isinstance(self.footprint, Polygon) and self.footprint != _box(self.bbox):
            document["polygon"] = self.footprint.vertices.tolist()
        elif isinstance(self.footprint, Disc):
            document["radius"] = self.footprint.radius
        return document


def _box(bbox: tuple[float, float, float, float] | None) -> Polygon | None:
    return None if bbox is None else rectangle(*bbox)


class Picture:
    """A picture in memory or in a file; a file is decoded each time the pixels are asked for.

    A photograph that notes which way is up (EXIF) is turned as viewers turn it: sizes, pixels
    and all coordinates are those of the picture that people see.
    """

    _draw: Callable[[], Image] | None = None

    def __init__(self, *, array: ArrayLike | None = None, file: Path | None = None) -> None:
        if (array is None) == (file is None):
            raise ValueError("give either an array or a file")
        self.file = file
        self._array: Image | None = None
        self._size: tuple[int, int] | None = None
        if array is not None:
            pixels = np.asarray(array)
            if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8:
                found = f"shape {pixels.shape}, {pixels.dtype}"
                raise InputError("an 8-bit RGB picture (height, width, 3)", found, field="image")
            self._array = pixels
            self._size = (pixels.shape[1], pixels.shape[0])

    @classmethod
    def drawn(cls, size_px: tuple[int, int], draw: Callable[[], Image]) -> Picture:
        """A picture that is drawn when its pixels are first asked for, and then kept.

        Most interventions are judged by something that never looks.

        Args:
            size_px: (width, height) of what `draw` returns.
            draw: Gives (height, width, 3) uint8, always the same.
        """
        made = cls.__new__(cls)
        made.file, made._array, made._size, made._draw = None, None, size_px, draw
        return made

    def __getstate__(self) -> dict[str, Any]:
        """Copies for other processes hold pixels, not what would draw them."""
        if self._draw is not None:
            _ = self.pixels
        return {"file": self.file, "_array": self._array, "_size": self._size}

    @property
    def size_px(self) -> tuple[int, int]:
        """(width, height), read from the file's header.

        Raises:
            InputError: As `pixels`, as far as header and end of the file tell.
        """
        if self._size is None:
            self._size = _plain_size(self.file)
        if self._size is None:
            with _opened(self.file) as picture:
                _refuse_truncated(self.file, str(picture.format))
                self._size = upright_size(picture)
        return self._size

    @property
    def pixels(self) -> Image:
        """(height, width, 3) uint8.

        Raises:
            InputError: Not a readable picture, truncated, or larger than
                `MAX_PICTURE_PIXELS`.
        """
        if self._array is None and self._draw is not None:
            self._array, self._draw = self._draw(), None
        if self._array is not None:
            return self._array
        with _opened(self.file) as picture:
            try:
                return np.asarray(upright(picture).convert("RGB"))
            except _BROKEN as error:
                raise InputError("a whole picture", str(error), file=self.file) from error

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Picture) and np.array_equal(self.pixels, other.pixels)

    __hash__ = None  # type: ignore[assignment]


_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "PPM", "TIFF")
"""What is decoded. Pillow knows more, some of it (EPS) by running other programs."""

_BROKEN = (
    OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError, OverflowError,
    MemoryError, struct.error, zlib.error,
)  # fmt: skip
"""What Pillow's decoders raise on broken files."""


def _plain_size(file: str | os.PathLike[str] | None) -> tuple[int, int] | None:
    """The size of a whole, plain PNG; None for what Pillow has to look at."""
    assert file is not None
    try:
        size = plain_png_size(file)
    except OSError:  # Pillow's words are those that users know
        return None
    if size is None or size[0] * size[1] > MAX_PICTURE_PIXELS:
        return None
    _refuse_truncated(file, "PNG")
    return size


def _opened(file: str | os.PathLike[str] | None) -> Any:
    import PIL.Image

    assert file is not None
    try:
        with warnings.catch_warnings():
            # Pillow warns of some large pictures; ours is a refusal, below.
            warnings.simplefilter("ignore", PIL.Image.DecompressionBombWarning)
            # Nor does a damaged note beside the pixels concern anyone.
            warnings.filterwarnings("ignore", "(Possibly c|C)orrupt EXIF data")
            picture = PIL.Image.open(file, formats=_FORMATS)
    except PIL.Image.DecompressionBombError as error:
        raise InputError(
            f"a picture of at most {MAX_PICTURE_PIXELS} pixels", str(error), file=file
        ) from error
    except _BROKEN as error:
        found = getattr(error, "strerror", None) or "something else"
        raise InputError("a PNG or JPEG picture", found, file=file) from error
    width, height = picture.size
    if width * height > MAX_PICTURE_PIXELS:
        picture.close()
        raise InputError(
            f"a picture of at most {MAX_PICTURE_PIXELS} pixels", f"{width}x{height}", file=file
        )
    return picture


def _refuse_truncated(file: str | os.PathLike[str] | None, kind: str) -> None:
    assert file is not None
    try:
        cut = is_truncated(file, kind)
    except OSError as error:
        raise InputError("a readable file", error.strerror or str(error), file=file) from error
    if cut:
        raise InputError("a whole picture", f"a {kind} that stops before its end", file=file)


@dataclass(frozen=True)
class Scene:
    """A top-down scene.

    Args:
        scene_id: Unique in its set.
        start: Where demonstrations begin, pixels, shape (2,).
        goal: Where they end, pixels, shape (2,).
        objects: None means *not listed*, which is not an empty table.
        picture: None where the set has object lists only.
        split: ``train`` or ``test``.
        extra: Further keys of the metadata line, kept as they came.
        recipe: What a rendered scene was drawn from; None for a photograph.
    """

    scene_id: str
    start: tuple[float, ...]
    goal: tuple[float, ...]
    objects: tuple[SceneObject, ...] | None = None
    picture: Picture | None = None
    split: str = "train"
    extra: tuple[tuple[str, Any], ...] = ()
    recipe: SceneRecipe | None = None

    def __hash__(self) -> int:
        return hash(self.scene_id)

    @property
    def size_px(self) -> tuple[int, int] | None:
        """(width, height) of the picture, or None without one."""
        return None if self.picture is None else self.picture.size_px

    @property
    def bounds(self) -> Bounds:
        """Box around the objects' footprints, start and goal, set units."""
        found = bounds_of([self.start[:2], self.goal[:2]], [o.outline for o in self.objects or ()])
        assert found is not None
        return found

    @property
    def length_scale(self) -> float:
        """The longer side of `bounds`, set units: the scene's size, whatever the unit."""
        return extent(self.bounds)

    def listed_objects(self) -> tuple[SceneObject, ...]:
        """The objects; CannotJudgeError where the scene does not list them."""
        if self.objects is None:
            raise CannotJudgeError(
                "a list of objects (a rule cannot see; `demospec detect` makes the list)",
                "objects not listed",
                row=f"scene {self.scene_id}",
                field="objects",
            )
        return self.objects

    def shown_picture(self) -> Picture:
        """The picture; CannotJudgeError where the scene has none."""
        if self.picture is None:
            raise CannotJudgeError(
                "a picture", "none", row=f"scene {self.scene_id}", field="file_name"
            )
        return self.picture

    def pixels(self) -> Image:
        """(height, width, 3) uint8; CannotJudgeError where the scene has no picture."""
        return self.shown_picture().pixels

    def seen(self) -> Scene:
        """The scene as a camera delivers it: without its list, and without what it was drawn from.

        A learner that is to find the objects by itself gets this one.
        """
        return replace(self, objects=None, recipe=None)

    def with_changes(
        self, *, objects: tuple[SceneObject, ...] | None, picture: Picture | None
    ) -> Scene:
        """The same scene with other objects and another picture (an intervention)."""
        return replace(self, objects=objects, picture=picture)
