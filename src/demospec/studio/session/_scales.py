"""Which scenes are learned from together: those whose lengths can be compared.

Scenes of known scale are compared through metres. Of a set that states no scale one unit is one
unit, as everywhere. A picture that somebody brought and did not measure stands alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from demospec.demonstrations import Demonstrations, DemonstrationSet
from demospec.errors import DemospecError, InputError
from demospec.frames import metres_of_unit
from demospec.rules import RuleSet, rules_in_unit
from demospec.scene import Picture, Scene, SceneObject

METRES, SET = "metres", "set"
"""Bases of scenes that are compared; of a picture that stands alone the basis is its id."""

COMMON_M = 0.001
"""Metres per unit of scenes that come from different scales: millimetres."""


class OtherScale(DemospecError):
    """Rules do not apply to a picture: a sentence that says why, and what to do."""


def basis_of(scene: Scene, scale: float | None, of_set: bool) -> str:
    """What a scene is compared with.

    Args:
        scale: Metres per unit, None where nobody has said.
        of_set: It came with the set.
    """
    if scale is not None:
        return METRES
    return SET if of_set else scene.scene_id


def comparable(
    data: DemonstrationSet, basis: str, bases: Mapping[str, str]
) -> DemonstrationSet | None:
    """The part of a set on one basis, all in one unit; None where it has no demonstration.

    Args:
        bases: Scene → its basis.
    """
    scenes = tuple(s for s in data.scenes if bases[s.scene_id] == basis)
    mine = np.array([bases[s] == basis for s in data.demonstrations.scene_id], dtype=bool)
    if not mine.any():
        return None
    scales = {data.scale_of(s) for s in scenes}
    demos = data.demonstrations.rows(mine)
    if len(scales) == 1:
        plain = tuple(replace(s, metres_per_unit=None) if s.metres_per_unit else s for s in scenes)
        return replace(data, scenes=plain, demonstrations=demos, metres_per_unit=next(iter(scales)))
    factor = {s.scene_id: (data.scale_of(s) or 1.0) / COMMON_M for s in scenes}
    lengths = [i for i, name in enumerate(data.columns) if name in ("x", "y", "z", "speed")]
    scaled = []
    for demo in demos:
        points = demo.points.copy()
        points[:, lengths] *= factor[demo.scene_id]
        scaled.append(replace(demo, points=points))
    return replace(
        data,
        scenes=tuple(_scaled(s, factor[s.scene_id]) for s in scenes),
        demonstrations=Demonstrations.of(scaled, len(data.columns)),
        units="px",
        metres_per_unit=COMMON_M,
        frame=None,
    )


@lru_cache(maxsize=1024)
def _scaled_objects(objects: tuple[SceneObject, ...], factor: float) -> tuple[SceneObject, ...]:
    # The same tuple for the same objects: what was measured about them is remembered by it.
    return tuple(o.mapped(np.eye(2) * factor) for o in objects)


def _scaled(scene: Scene, factor: float) -> Scene:
    """The scene with all lengths multiplied; of its picture only the size is kept."""
    picture = None
    if scene.size_px is not None:
        width, height = (max(1, round(side * factor)) for side in scene.size_px)
        picture = Picture.drawn((width, height), lambda: np.zeros((height, width, 3), np.uint8))
    objects = None if scene.objects is None else _scaled_objects(scene.objects, factor)
    return replace(
        scene,
        start=tuple(v * factor for v in scene.start),
        goal=tuple(v * factor for v in scene.goal),
        objects=objects,
        picture=picture,
        metres_per_unit=None,
        recipe=None,
    )


def rules_at(rules: RuleSet, units: str, scale: float | None, same: bool) -> RuleSet:
    """Rules in the units of a scene; never silently those of another scale.

    Args:
        units, scale: Of the scene.
        same: Rules and scene are on one basis without a scale: one unit is one unit.

    Raises:
        OtherScale: Nobody has said how the two compare.
    """
    if same:
        return rules_in_unit(replace(rules, metres_per_unit=None), units, None)
    mine = metres_of_unit(rules.units, rules.metres_per_unit)
    if scale is None:
        raise OtherScale(
            "How wide is this picture on the table? Measure it under Table: these rules were "
            "learned elsewhere."
        )
    if mine is None:
        raise OtherScale("These rules speak of pixels, and nobody has said how large those are.")
    try:
        return rules_in_unit(rules, units, scale)
    except InputError as error:
        raise OtherScale(str(error)) from error
