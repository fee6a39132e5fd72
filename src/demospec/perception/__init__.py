"""Perception: the pretrained body, distance maps, slots, detection.

Result types load at once; whatever needs torch loads on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.perception._observation import Sight, Slot, read_map
from demospec.perception.synthetic._things import KINDS

if TYPE_CHECKING:
    from demospec.perception._detection import (
        DetectedObject,
        detect_in_set,
        detect_objects,
        fit_symbol_head,
    )
    from demospec.perception._overlay import overlay_picture
    from demospec.perception.heads._symbols import SymbolHead
    from demospec.perception.inference._observe import canonical_grid, look
    from demospec.perception.network._distance_net import Body, BodySize
    from demospec.perception.network._weights import SHIPPED, load_body, recipe_of
    from demospec.perception.scene_code._code import CodeLength, SceneCode, SlotCode
    from demospec.perception.scene_code._draw import draw_scene_code
    from demospec.perception.scene_code._read import read_scene_code
    from demospec.perception.scene_code._sample import SceneSampler
    from demospec.perception.synthetic._pictures import make_picture
    from demospec.perception.training._pretrain import PretrainSettings, pretrain

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
    "CodeLength": "scene_code._code",
    "SceneCode": "scene_code._code",
    "SceneSampler": "scene_code._sample",
    "SlotCode": "scene_code._code",
    "draw_scene_code": "scene_code._draw",
    "read_scene_code": "scene_code._read",
    "SHIPPED": "network._weights",
    "Body": "network._distance_net",
    "BodySize": "network._distance_net",
    "DetectedObject": "_detection",
    "PretrainSettings": "training._pretrain",
    "SymbolHead": "heads._symbols",
    "canonical_grid": "inference._observe",
    "detect_in_set": "_detection",
    "detect_objects": "_detection",
    "fit_symbol_head": "_detection",
    "load_body": "network._weights",
    "look": "inference._observe",
    "make_picture": "synthetic._pictures",
    "overlay_picture": "_overlay",
    "pretrain": "training._pretrain",
    "recipe_of": "network._weights",
}


__getattr__ = names_of(__name__, _HOME)
