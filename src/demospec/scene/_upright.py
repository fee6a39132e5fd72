"""Orientation of photographs (EXIF): a camera writes beside the pixels which way is up."""

from __future__ import annotations

import warnings
from typing import Any

_TAG = 0x0112
"""EXIF's Orientation: 1 as stored, 2 to 8 mirrored or turned."""

_SWAPS = (5, 6, 7, 8)
"""Orientations that exchange width and height."""


def upright_size(picture: Any) -> tuple[int, int]:
    """(width, height) of an opened Pillow picture as it is shown, from its header alone."""
    width, height = (int(v) for v in picture.size)
    return (height, width) if _orientation(picture) in _SWAPS else (width, height)


def upright(picture: Any) -> Any:
    """An opened Pillow picture turned as its EXIF data say, as viewers and browsers do.

    Without it, objects marked on a phone's photograph would lie elsewhere than in the pixels.
    """
    from PIL.ImageOps import exif_transpose

    return picture if _orientation(picture) == 1 else exif_transpose(picture)


def _orientation(picture: Any) -> int:
    """1 to 8; 1 where nothing is said, or nothing that can be read."""
    from PIL.Image import Exif

    raw = picture.info.get("exif")
    if raw is None or picture.format == "TIFF":  # Pillow turns these by itself
        return 1
    found = Exif()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a damaged note is no reason to refuse the pixels
            found.load(raw)
            value = found.get(_TAG, 1)
    except Exception:  # Pillow's parser raises nearly anything on damaged notes
        return 1
    return value if isinstance(value, int) and 1 <= value <= 8 else 1
