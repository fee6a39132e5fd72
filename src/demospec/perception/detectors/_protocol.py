"""The protocol of a detector, and what it gives back: findings in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.geometry import MultiPolygon
from demospec.scene import Image


@dataclass(frozen=True)
class Finding:
    """One thing that a detector found, in pixels of the picture that it was given.

    Args:
        symbol: The detector's own word for it.
        confidence: In [0, 1].
        bbox: (x, y, width, height), or None where `polygon` or `mask` says where it is.
        polygon: (k, 2) outline, k ≥ 3, or one of several parts, or None.
        mask: (h, w) bool of the whole picture, or None; it comes before `polygon`, and that
            before `bbox`.

    Raises:
        InputError: No place, a confidence outside [0, 1], an empty word.
    """

    symbol: str
    confidence: float = 1.0
    bbox: tuple[float, float, float, float] | None = None
    polygon: ArrayLike | MultiPolygon | None = None
    mask: ArrayLike | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.symbol, str) or not self.symbol.strip():
            raise InputError("a class of object", repr(self.symbol), field="symbol")
        if not 0 <= self.confidence <= 1:
            raise InputError("a confidence from 0 to 1", self.confidence, field="confidence")
        if self.bbox is None and self.polygon is None and self.mask is None:
            raise InputError("bbox, polygon or mask", "none of them", field=self.symbol)


@runtime_checkable
class Detector(Protocol):
    """Anything that finds things in a picture."""

    @property
    def name(self) -> str:
        """What a set remembers of it, such as ``onnx:cups.onnx``."""
        ...

    def detect(self, pixels: Image, names: Sequence[str] = ()) -> Sequence[Finding] | None:
        """The things in a picture; None where it does not know this picture.

        Args:
            pixels: (h, w, 3) uint8 RGB.
            names: What the picture is called: its file's name, that without its ending, the id
                of its scene. A detector that looks at the pixels needs none of them.
        """
        ...
