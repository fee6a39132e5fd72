"""Perception: the pretrained distance network, observations of pictures, detections.

Result types load at once; whatever needs torch loads on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.geometry import read_map
from demospec.perception._canonical import (
    CANONICAL_PX,
    PERCENT_PX,
    canonical_grid,
    to_grid,
    turned_array,
    turned_back,
)
from demospec.perception._kinds import KINDS
from demospec.perception._observation import Detection, Observation

if TYPE_CHECKING:
    from demospec.perception import _level_sets as level_sets
    from demospec.perception._detected import DetectedObject
    from demospec.perception._detection import detect_in_set, detect_objects, detect_with
    from demospec.perception._observation import Detection as Slot
    from demospec.perception._observation import Observation as Sight
    from demospec.perception._overlay import overlay_picture
    from demospec.perception.heads._symbols import (
        SymbolHead,
        appearance_count,
        class_probabilities,
        match_detections,
    )
    from demospec.perception.inference._observe import observe
    from demospec.perception.inference._observe import observe as look
    from demospec.perception.network._backbone import NetworkSize
    from demospec.perception.network._backbone import NetworkSize as BodySize
    from demospec.perception.network._distance_net import DistanceNet
    from demospec.perception.network._distance_net import DistanceNet as Body
    from demospec.perception.network._weights import (
        SHIPPED,
        arrays_of,
        load_network,
        network_of,
        recipe_of,
    )
    from demospec.perception.network._weights import load_network as load_body
    from demospec.perception.scene_code._code import CodeLength, ObjectCode, SceneCode
    from demospec.perception.scene_code._code import ObjectCode as SlotCode
    from demospec.perception.scene_code._draw import draw_scene_code
    from demospec.perception.scene_code._read import read_scene_code
    from demospec.perception.scene_code._sample import SceneSampler
    from demospec.perception.synthetic._pictures import make_picture
    from demospec.perception.training._pretrain import PretrainSettings, pretrain
    from demospec.perception.training._symbol_head import fit_symbol_head
    from demospec.perception.training._tune import tuned_network

__all__ = [
    "CANONICAL_PX",
    "KINDS",
    "PERCENT_PX",
    "SHIPPED",
    "Body",
    "BodySize",
    "CodeLength",
    "DetectedObject",
    "Detection",
    "DistanceNet",
    "NetworkSize",
    "ObjectCode",
    "Observation",
    "PretrainSettings",
    "SceneCode",
    "SceneSampler",
    "Sight",
    "Slot",
    "SlotCode",
    "SymbolHead",
    "appearance_count",
    "arrays_of",
    "canonical_grid",
    "class_probabilities",
    "detect_in_set",
    "detect_objects",
    "detect_with",
    "draw_scene_code",
    "fit_symbol_head",
    "level_sets",
    "load_body",
    "load_network",
    "look",
    "make_picture",
    "match_detections",
    "network_of",
    "observe",
    "overlay_picture",
    "pretrain",
    "read_map",
    "read_scene_code",
    "recipe_of",
    "to_grid",
    "tuned_network",
    "turned_array",
    "turned_back",
]

_HOME = {
    "CodeLength": "scene_code._code",
    "DetectedObject": "_detected",
    "DistanceNet": "network._distance_net",
    "NetworkSize": "network._backbone",
    "ObjectCode": "scene_code._code",
    "PretrainSettings": "training._pretrain",
    "SHIPPED": "network._weights",
    "SceneCode": "scene_code._code",
    "SceneSampler": "scene_code._sample",
    "SymbolHead": "heads._symbols",
    "appearance_count": "heads._symbols",
    "arrays_of": "network._weights",
    "class_probabilities": "heads._symbols",
    "detect_in_set": "_detection",
    "detect_objects": "_detection",
    "detect_with": "_detection",
    "draw_scene_code": "scene_code._draw",
    "fit_symbol_head": "training._symbol_head",
    "level_sets": "_level_sets:",
    "load_network": "network._weights",
    "make_picture": "synthetic._pictures",
    "match_detections": "heads._symbols",
    "network_of": "network._weights",
    "observe": "inference._observe",
    "overlay_picture": "_overlay",
    "pretrain": "training._pretrain",
    "read_scene_code": "scene_code._read",
    "recipe_of": "network._weights",
    "tuned_network": "training._tune",
    # Former names.
    "Body": "network._distance_net:DistanceNet",
    "BodySize": "network._backbone:NetworkSize",
    "Sight": "_observation:Observation",
    "Slot": "_observation:Detection",
    "SlotCode": "scene_code._code:ObjectCode",
    "load_body": "network._weights:load_network",
    "look": "inference._observe:observe",
}


__getattr__ = names_of(__name__, _HOME)
