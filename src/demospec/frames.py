"""Frames and units: the frame of a set, picture pixels, metres, and lengths in words.

Pixel frame: x right, y down, origin at the outer corner of the top-left pixel, so that
pixel (i, j) is centred at (i + 0.5, j + 0.5). Table frame of a picture: metres, x right, y away
from the viewer (up in the picture), origin at the picture's bottom-left outer corner. Sets in
metres keep the frame in which they came; nothing of theirs is turned over.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError

FloatArray = NDArray[np.float64]


Axis = Literal["up", "down"]


@dataclass(frozen=True)
class Frame:
    """The frame in which a set's coordinates came (``frame`` of dataset.json).

    Args:
        name: Such as ``map`` or ``base_link``; None where nobody said.
        y: Whether y grows away from the viewer (``up``, as in ROS) or towards (``down``, as in
            pictures).
        homography: Three rows of three: set coordinates → metres in the frame of this name, for
            metres that became pixels of a picture; None: the set's scale says all.
    """

    name: str | None = None
    y: Axis = "up"
    homography: tuple[tuple[float, float, float], ...] | None = None

    def to_json(self) -> dict[str, Any]:
        """The entry of ``dataset.json``."""
        document: dict[str, Any] = {"name": self.name, "y": self.y}
        if self.homography is not None:
            document["homography"] = [list(row) for row in self.homography]
        return document

    @classmethod
    def of_units(cls, units: str) -> Frame:
        """What holds where a set does not say: pixels run down, every other unit up."""
        return cls(None, "down" if units == "px" else "up")


PICTURE = Frame(None, "down")
"""The frame of pixels."""


@dataclass(frozen=True)
class PixelFrame:
    """Map between a set's coordinates and metres: scaled, and for pictures turned over.

    Args:
        height_px: Height of the picture, set units.
        metres_per_unit: Metres per unit; > 0. None where the set does not say: then every
            conversion to metres raises.
        y: ``down``: the metres' origin is the picture's bottom-left outer corner, y up. ``up``:
            the coordinates keep their axes and their origin.
    """

    height_px: float
    metres_per_unit: float | None
    y: Axis = "down"

    def _scale(self) -> float:
        if self.metres_per_unit is None:
            raise InputError(
                "a number of metres per unit (the set does not say how large a pixel is)",
                "null",
                field="metres_per_unit",
            )
        return self.metres_per_unit

    def to_metres(self, points_px: ArrayLike) -> FloatArray:
        """Set units → metres. Shape (..., 2) → (..., 2); further columns are scaled."""
        points = np.array(points_px, dtype=np.float64)
        if self.y == "down":
            points[..., 1] = self.height_px - points[..., 1]
        return points * self._scale()

    def to_pixels(self, points_m: ArrayLike) -> FloatArray:
        """Metres → set units; the inverse of `to_metres`."""
        points = np.asarray(points_m, dtype=np.float64) / self._scale()
        if self.y == "down":
            points[..., 1] = self.height_px - points[..., 1]
        return points

    def length_to_metres(self, length_px: float) -> float:
        """A length in pixels → metres."""
        return length_px * self._scale()


METRES: Mapping[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Units that are lengths by themselves."""


def metres_of_unit(units: str, metres_per_unit: float | None) -> float | None:
    """Metres that one unit of a set is long, or None where nobody said."""
    return METRES.get(units, metres_per_unit)


def metres_of_words(text: str) -> float:
    """``30 cm``, ``300mm`` or ``0.3 m`` → metres; InputError for anything else."""
    found = re.fullmatch(r"\s*([0-9]*\.?[0-9]+)\s*(mm|cm|m)\s*", text)
    if found is None or not float(found[1]) > 0:
        raise InputError("a length such as 30cm, 300mm or 0.3m", text, field="ruler")
    return float(found[1]) * METRES[found[2]]


def ruler(first: ArrayLike, second: ArrayLike, length_m: float) -> float:
    """Metres per unit, from two points of a picture and the length between them in metres."""
    ends = np.asarray([first, second], dtype=np.float64)
    apart = float(np.hypot(*(ends[1] - ends[0])))
    if not (np.isfinite(apart) and apart > 0):
        raise InputError("two different points", str(ends.tolist()), field="ruler")
    return length_m / apart


def describe_length(
    length: float,
    metres_per_unit: float | None,
    units: str = "px",
    *,
    interval: tuple[float, float] | None = None,
) -> str:
    """A length for people: ``4.1 cm``; with its interval ``4.1 cm (3.9 to 4.3)``.

    In mm, cm or m, whichever suits; in the set's own unit where the scale is unknown. Two
    significant digits, more where the rounded value would lie outside its interval, or the
    interval's ends would read alike.

    Args:
        length: In `units`.
        interval: Ends in `units`; an end that does not exist is infinite.
    """
    scale = metres_of_unit(units, metres_per_unit)
    factor, name = 1.0, units
    if scale is not None:
        size = abs(length) * scale
        name = "mm" if size < 0.00995 else "cm" if size < 0.995 else "m"
        factor = scale / METRES[name]
    value = length * factor
    if interval is None:
        return f"{_rounded(value, 2).removesuffix('.0')} {name}"
    low, high = (end * factor for end in interval)
    digits = next((d for d in range(2, 7) if low <= float(_rounded(value, d)) <= high), 7)
    text = f"{_rounded(value, digits)} {name}"
    if not np.isfinite(high):
        return text if not np.isfinite(low) else f"{text} ({_rounded(low, digits)} or more)"
    if not np.isfinite(low):
        return f"{text} ({_rounded(high, digits)} or less)"
    digits = next(
        (d for d in range(digits, 7) if _rounded(low, d) != _rounded(high, d) or low == high), 7
    )
    return f"{text} ({_rounded(low, digits)} to {_rounded(high, digits)})"


def _rounded(value: float, digits: int) -> str:
    """A number with so many significant digits, never in powers of ten."""
    if value == 0.0:
        return "0"
    # Of the rounded value: 9.96 is 10 to two digits, not 10.0.
    size = abs(float(f"{value:.{digits - 1}e}"))
    places = max(0, digits - 1 - int(np.floor(np.log10(size) + 1e-12)))
    text = f"{value:.{min(places, 12)}f}"
    if "." in text and float(text) == 0.0:
        return "0"
    return text
