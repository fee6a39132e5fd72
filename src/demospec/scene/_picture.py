"""Pictures: in memory, in a file, or drawn when they are first asked for."""

from __future__ import annotations

import os
import struct
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.scene._plain_png import plain_png_size
from demospec.scene._upright import upright, upright_size
from demospec.scene._whole import is_truncated

Image = NDArray[np.uint8]

MAX_PICTURE_PIXELS = 64_000_000
"""Largest picture that is decoded; a larger one is taken for a decompression bomb."""


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
