"""Heads on the distance network's features: symbols, objectness, merging, uncertainty."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.heads._merging import PAIR_FEATURES, MergingHead
    from demospec.perception.heads._objectness import ObjectnessHead
    from demospec.perception.heads._symbols import (
        NOTHING,
        SymbolHead,
        appearance_count,
        class_probabilities,
        match_detections,
    )
    from demospec.perception.heads._uncertainty import uncertainty_map

__all__ = [
    "NOTHING",
    "PAIR_FEATURES",
    "MergingHead",
    "ObjectnessHead",
    "SymbolHead",
    "appearance_count",
    "class_probabilities",
    "match_detections",
    "uncertainty_map",
]

_HOME = {
    "NOTHING": "_symbols",
    "PAIR_FEATURES": "_merging",
    "MergingHead": "_merging",
    "ObjectnessHead": "_objectness",
    "SymbolHead": "_symbols",
    "appearance_count": "_symbols",
    "class_probabilities": "_symbols",
    "match_detections": "_symbols",
    "uncertainty_map": "_uncertainty",
}


__getattr__ = names_of(__name__, _HOME)
