"""Latent code of a scene: a table, a lamp and objects, drawn back to a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.scene_code._code import CodeLength, ObjectCode, SceneCode, TableCode
    from demospec.perception.scene_code._draw import draw_scene_code, outline_of
    from demospec.perception.scene_code._read import read_scene_code
    from demospec.perception.scene_code._sample import SceneSampler

__all__ = [
    "CodeLength",
    "ObjectCode",
    "SceneCode",
    "SceneSampler",
    "TableCode",
    "draw_scene_code",
    "outline_of",
    "read_scene_code",
]

_HOME = {
    "CodeLength": "_code",
    "ObjectCode": "_code",
    "SceneCode": "_code",
    "SceneSampler": "_sample",
    "TableCode": "_code",
    "draw_scene_code": "_draw",
    "outline_of": "_draw",
    "read_scene_code": "_read",
}


__getattr__ = names_of(__name__, _HOME)
