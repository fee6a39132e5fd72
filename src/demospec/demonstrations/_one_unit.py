"""Pictures of different scale, brought into one unit: metres."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations.editing._columns import with_columns
from demospec.errors import InputError
from demospec.scene import Scene


def in_one_unit(data: DemonstrationSet) -> DemonstrationSet:
    """The set with one unit for all of its scenes.

    Where the scenes with demonstrations have one scale, that is the set's, and nothing moves.
    Otherwise everything is in metres, axes as they came, and the scenes are without their
    pictures, whose pixels are none.

    Raises:
        InputError: Some scenes with demonstrations have a scale and others have none.
    """
    if all(scene.metres_per_unit is None for scene in data.scenes):
        return data
    used = set(data.demonstrations.scene_id)
    scales = {s.scene_id: data.scale_of(s) for s in data.scenes if s.scene_id in used}
    known = [scale for scale in scales.values() if scale is not None]
    if len(known) < len(scales):
        nameless = next(name for name, scale in scales.items() if scale is None)
        raise InputError(
            "a scale for every picture, as others of the set have one (`demospec edit rescale SET "
            f"--ruler X1 Y1 X2 Y2 LENGTH --scene {nameless}`)",
            "none",
            row=f"scene {nameless}",
            field="metres_per_unit",
        )
    if all(math.isclose(scale, known[0], rel_tol=1e-9) for scale in known):
        plain = tuple(replace(s, metres_per_unit=None) for s in data.scenes)
        return replace(data, scenes=plain, metres_per_unit=known[0])
    d = data.demonstrations
    factor = np.array([scales[name] for name in d.scene_id], dtype=np.float64)
    flat = d.flat.copy()
    lengths = [i for i, name in enumerate(data.columns) if name in ("x", "y", "z", "speed")]
    flat[:, lengths] *= np.repeat(factor, np.diff(d.offsets))[:, None]
    return replace(
        data,
        scenes=tuple(_in_metres(s, data.scale_of(s)) for s in data.scenes if s.scene_id in used),
        demonstrations=with_columns(d, flat=flat),
        units="m",
        metres_per_unit=1.0,
        frame=None,
    )


def _in_metres(scene: Scene, scale: float | None) -> Scene:
    assert scale is not None
    objects = scene.objects
    if objects is not None:
        objects = tuple(o.mapped(scale * np.eye(2)) for o in objects)
    return replace(
        scene,
        start=tuple(v * scale for v in scene.start),
        goal=tuple(v * scale for v in scene.goal),
        objects=objects,
        picture=None,
        recipe=None,
        metres_per_unit=None,
    )
