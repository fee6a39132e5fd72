"""Inference on one picture: observation, segments, merging of segments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.inference._merging import (
        HIGHEST,
        Bridge,
        Segment,
        merged,
        pairs,
        saddles,
    )
    from demospec.perception.inference._observe import observe, segments_of
    from demospec.perception.inference._segments import find_detections, segments_in

__all__ = [
    "HIGHEST",
    "Bridge",
    "Segment",
    "find_detections",
    "merged",
    "observe",
    "pairs",
    "saddles",
    "segments_in",
    "segments_of",
]

_HOME = {
    "HIGHEST": "_merging",
    "Bridge": "_merging",
    "Segment": "_merging",
    "find_detections": "_segments",
    "merged": "_merging",
    "observe": "_observe",
    "pairs": "_merging",
    "saddles": "_merging",
    "segments_in": "_segments",
    "segments_of": "_observe",
}


__getattr__ = names_of(__name__, _HOME)
