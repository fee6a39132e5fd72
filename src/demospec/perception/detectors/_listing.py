"""Findings → the objects of a scene: symbols, least confidence, one object a thing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, MultiPolygon, Polygon, rectangle
from demospec.perception._detected import DetectedObject
from demospec.perception.detectors._protocol import Finding

OVERLAP = 0.7
"""Intersection over union of two boxes from which on they are one thing, whatever its class.

A cup on its saucer has half of it; two words of one detector for one cup have nine tenths."""


def symbol_map(text: str) -> dict[str, str]:
    """``cup=glass,wine glass=glass`` → {detector's class: symbol}.

    Raises:
        InputError: A part without ``=`` or with an empty side, or a class given twice.
    """
    out: dict[str, str] = {}
    for part in text.split(","):
        theirs, equals, ours = (word.strip() for word in part.partition("="))
        if not (theirs and equals and ours):
            raise InputError("CLASS=SYMBOL,CLASS=SYMBOL", part or text, field="--symbols")
        if out.setdefault(theirs, ours) != ours:
            raise InputError("each class once", theirs, field="--symbols")
    return out


def listed(
    findings: Sequence[Finding],
    size_px: tuple[int, int],
    *,
    symbols: Mapping[str, str] | None = None,
    least: float = 0.5,
    overlap: float = OVERLAP,
) -> list[DetectedObject]:
    """What a detector found as a list of objects, surest first.

    Args:
        findings: Of one picture.
        size_px: (width, height) of the picture; what lies outside is cut off or left out.
        symbols: The detector's class → the person's symbol; other classes keep their word.
        least: Less sure findings are left out.
        overlap: Of two boxes with a larger share of intersection in their union the less sure
            is left out, whatever the classes.

    Raises:
        InputError: A place that is no place in a picture.
    """
    rename = symbols or {}
    shown: list[tuple[Finding, Footprint]] = []
    for finding in findings:
        shape = _outline(finding, size_px) if finding.confidence >= least else None
        if shape is not None:
            shown.append((finding, shape))
    boxes = np.array([shape.bounds for _, shape in shown], dtype=np.float64).reshape(-1, 4)
    scores = np.array([finding.confidence for finding, _ in shown], dtype=np.float64)
    out: list[DetectedObject] = []
    count: dict[str, int] = {}
    for i in surest(boxes, scores, overlap):
        finding, shape = shown[i]
        symbol = rename.get(finding.symbol, finding.symbol)
        number = count.get(symbol, 0)
        count[symbol] = number + 1
        x, y, right, low = (round(float(v), 3) for v in boxes[i])
        sides = (x, y, round(right - x, 3), round(low - y, 3))
        middle = (round((x + right) / 2, 3), round((y + low) / 2, 3))
        boxed = finding.mask is None and finding.polygon is None
        out.append(
            DetectedObject(
                id=f"{symbol}-{number}", symbol=symbol, center=middle, bbox=sides,
                footprint=rectangle(*sides) if boxed else shape,
                confidence=float(finding.confidence),
                symbols=((symbol, float(finding.confidence)),),
            )
        )  # fmt: skip
    return out


def surest(boxes: FloatArray, scores: FloatArray, overlap: float = OVERLAP) -> list[int]:
    """Rows of the boxes (n, 4) of which none overlaps a surer one too much, surest first."""
    kept: list[int] = []
    left = np.argsort(-scores, kind="stable")
    areas = np.prod(np.maximum(boxes[:, 2:] - boxes[:, :2], 0.0), axis=1)
    while len(left):
        first, left = left[0], left[1:]
        kept.append(int(first))
        low = np.maximum(boxes[left, :2], boxes[first, :2])
        high = np.minimum(boxes[left, 2:], boxes[first, 2:])
        both = np.prod(np.maximum(high - low, 0.0), axis=1)
        union = np.maximum(areas[left] + areas[first] - both, 1e-12)
        left = left[both / union <= overlap]
    return kept


def _outline(finding: Finding, size_px: tuple[int, int]) -> Footprint | None:
    """The outline inside the picture; None where nothing of it is inside."""
    width, height = size_px
    if finding.mask is not None:
        from demospec.demonstrations.readers import mask_outline

        mask = np.asarray(finding.mask, dtype=bool)
        if mask.shape != (height, width):
            raise InputError(f"a mask of {width}x{height}", mask.shape, field="mask")
        return mask_outline(mask) if mask.any() else None
    if isinstance(finding.polygon, MultiPolygon):
        return finding.polygon
    if finding.polygon is not None:
        rim = np.asarray(finding.polygon, dtype=np.float64)
        if rim.ndim != 2 or rim.shape[1] != 2 or len(rim) < 3:
            raise InputError("corners (k, 2), at least three", rim.shape, field="polygon")
    else:
        assert finding.bbox is not None
        sides = np.asarray(finding.bbox, dtype=np.float64)
        if sides.shape != (4,):
            raise InputError("[x, y, width, height]", finding.bbox, field="bbox")
        x, y, w, h = sides
        rim = np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])
    if not np.isfinite(rim).all():
        raise InputError("finite numbers", "others", field=finding.symbol)
    rim = np.clip(rim, 0.0, [width, height])
    return None if (np.ptp(rim, axis=0) < 1e-6).any() else Polygon(rim)
