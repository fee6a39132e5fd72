"""Perception: the pretrained body, distance maps, slots, detection.

Result types load at once; whatever needs torch loads on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from demospec.perception._results import Sight, Slot, read_map
from demospec.perception._things import KINDS

if TYPE_CHECKING:
    from demospec.perception._body import Body, BodySize
    from demospec.perception._detect import (
        DetectedObject,
        detect_in_set,
        detect_objects,
        fit_symbol_head,
    )
    from demospec.perception._looks import SymbolHead
    from demospec.perception._overlay import overlay_picture
    from demospec.perception._pictures import make_picture
    from demospec.perception._pretrain import PretrainSettings, pretrain
    from demospec.perception._scene_code import CodeLength, SceneCode, SlotCode
    from demospec.perception._scene_code_draw import draw_scene_code
    from demospec.perception._scene_code_read import read_scene_code
    from demospec.perception._scene_code_sample import SceneSampler
    from demospec.perception._sight import canonical_grid, look
    from demospec.perception._weights import SHIPPED, load_body, recipe_of

__all__ = [
    "KINDS",
    "SHIPPED",
    "Body",
    "BodySize",
    "CodeLength",
    "DetectedObject",
    "PretrainSettings",
    "SceneCode",
    "SceneSampler",
    "Sight",
    "Slot",
    "SlotCode",
    "SymbolHead",
    "canonical_grid",
    "detect_in_set",
    "detect_objects",
    "draw_scene_code",
    "fit_symbol_head",
    "load_body",
    "look",
    "make_picture",
    "overlay_picture",
    "pretrain",
    "read_map",
    "read_scene_code",
    "recipe_of",
]

_HOME = {
    "CodeLength": "_scene_code",
    "SceneCode": "_scene_code",
    "SceneSampler": "_scene_code_sample",
    "SlotCode": "_scene_code",
    "draw_scene_code": "_scene_code_draw",
    "read_scene_code": "_scene_code_read",
    "SHIPPED": "_weights",
    "Body": "_body",
    "BodySize": "_body",
    "DetectedObject": "_detect",
    "PretrainSettings": "_pretrain",
    "SymbolHead": "_looks",
    "canonical_grid": "_sight",
    "detect_in_set": "_detect",
    "detect_objects": "_detect",
    "fit_symbol_head": "_detect",
    "load_body": "_weights",
    "look": "_sight",
    "make_picture": "_pictures",
    "overlay_picture": "_overlay",
    "pretrain": "_pretrain",
    "recipe_of": "_weights",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
