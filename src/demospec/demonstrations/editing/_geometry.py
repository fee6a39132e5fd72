"""Edits that move points: crop, rescale, trim."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._trajectory import (
    first_and_last_motion,
)
from demospec.demonstrations.editing._columns import with_columns
from demospec.errors import InputError
from demospec.frames import METRES, FloatArray, Frame
from demospec.scene import Picture, Scene, SceneObject


def crop(data: DemonstrationSet, box: tuple[int, int, int, int]) -> DemonstrationSet:
    """The pictures cut to a box; points and objects move with it.

    Objects whose outline lies wholly outside are left out. Demonstrations keep all their points.

    Args:
        box: x, y, width, height, whole pixels, inside every picture.

    Raises:
        InputError: A box that leaves a picture.
    """
    x, y, width, height = box
    if width < 1 or height < 1:
        raise InputError("a box of at least one pixel", box, field="box")

    def cut(scene: Scene) -> Scene:
        size = scene.size_px
        if size is not None and (x < 0 or y < 0 or x + width > size[0] or y + height > size[1]):
            raise InputError(f"a box inside the picture ({size[0]}x{size[1]})", box,
                             row=f"scene {scene.scene_id}", field="box")  # fmt: skip
        picture = scene.picture
        if picture is not None:
            part = scene.pixels()[y : y + height, x : x + width]
            picture = Picture(array=np.ascontiguousarray(part))
        objects = scene.objects
        if objects is not None:
            moved = (o.moved((-x, -y)) for o in objects)
            objects = tuple(o for o in moved if _reaches(o, width, height))
        return replace(
            scene,
            start=(scene.start[0] - x, scene.start[1] - y, *scene.start[2:]),
            goal=(scene.goal[0] - x, scene.goal[1] - y, *scene.goal[2:]),
            objects=objects,
            picture=picture,
            recipe=None,  # it describes the whole picture
        )

    flat = data.demonstrations.flat.copy()
    flat[:, :2] -= (x, y)
    return replace(
        data,
        frame=_frame_after(data, np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])),
        scenes=tuple(cut(s) for s in data.scenes),
        demonstrations=with_columns(data.demonstrations, flat=flat),
    )


def _reaches(item: SceneObject, width: int, height: int) -> bool:
    low_x, low_y, high_x, high_y = item.outline.bounds
    return high_x > 0 and high_y > 0 and low_x < width and low_y < height


def rescale(data: DemonstrationSet, factor: float, *, units: str | None = None) -> DemonstrationSet:
    """Every length times `factor`: points (x, y, z, speed), objects, pictures; the scale follows.

    Args:
        factor: > 0. Pictures are resampled to the nearest whole size.
        units: New name of the unit; by default the old one, or, of a set in metres, that of
            the length that the new one has (m, cm, mm), else px.
    """
    if not (np.isfinite(factor) and factor > 0):
        raise InputError("a number > 0", factor, field="factor")
    flat = data.demonstrations.flat.copy()
    lengths = [i for i, name in enumerate(data.columns) if name in ("x", "y", "z", "speed")]
    flat[:, lengths] *= factor
    scale = None if data.metres_per_unit is None else data.metres_per_unit / factor
    if units is None and scale is not None and data.units in METRES:
        units = next((u for u, m in METRES.items() if np.isclose(scale, m, rtol=1e-9)), "px")
    return replace(
        data,
        scenes=tuple(_scaled_scene(s, factor) for s in data.scenes),
        demonstrations=with_columns(data.demonstrations, flat=flat),
        metres_per_unit=scale,
        units=units or data.units,
        frame=_frame_after(data, np.diag([1 / factor, 1 / factor, 1.0])),
    )


def scaled_by(
    data: DemonstrationSet, metres_per_unit: float, scenes: Collection[str] = ()
) -> DemonstrationSet:
    """The set with another scale; points and pictures stay what they are.

    Args:
        metres_per_unit: As measured on a picture (`demospec.frames.ruler`).
        scenes: Only of these scenes; none: of all.

    Raises:
        InputError: A set that is in metres; an unknown scene.
    """
    if data.units in METRES:
        raise InputError("a set of pixels", f"one in {data.units}", field="units")
    if not scenes:
        plain = tuple(replace(s, metres_per_unit=None) for s in data.scenes)
        return replace(data, metres_per_unit=metres_per_unit, scenes=plain)
    chosen = {data.scene(name).scene_id for name in scenes}
    measured = tuple(
        replace(s, metres_per_unit=metres_per_unit) if s.scene_id in chosen else s
        for s in data.scenes
    )
    return replace(data, scenes=measured)


def _frame_after(data: DemonstrationSet, back: FloatArray) -> Frame | None:
    """The set's frame once its points are others; `back` (3, 3) leads to the old ones."""
    frame = data.frame
    if frame is None or (frame.homography is None and not back[:2, 2].any()):
        return frame
    if frame.homography is None and frame.y == "down":
        return frame  # pixels, measured from the corner of the picture that there is now
    if frame.homography is not None:
        matrix = np.array(frame.homography) @ back
    elif data.metres_per_unit is None:
        return None  # an origin elsewhere, of pixels of unknown size
    else:
        matrix = np.diag([data.metres_per_unit, data.metres_per_unit, 1.0]) @ back
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    return replace(frame, homography=((a, b, c), (d, e, f), (g, h, i)))


def _scaled_scene(scene: Scene, factor: float) -> Scene:
    picture = scene.picture
    if picture is not None and factor != 1:
        import PIL.Image

        width, height = (max(1, round(v * factor)) for v in picture.size_px)
        if width * height > 64_000_000:
            raise InputError("a picture of at most 64000000 pixels", f"{width}x{height}",
                             row=f"scene {scene.scene_id}", field="factor")  # fmt: skip
        image = PIL.Image.fromarray(scene.pixels())
        # A box filter moves edges where pixels do not divide evenly; this one does not.
        way = PIL.Image.Resampling.HAMMING if factor < 1 else PIL.Image.Resampling.BICUBIC
        picture = Picture(array=np.asarray(image.resize((width, height), way)))
    objects = scene.objects
    if objects is not None:
        objects = tuple(o.mapped(factor * np.eye(2)) for o in objects)
    return replace(
        scene,
        start=tuple(v * factor for v in scene.start),
        goal=tuple(v * factor for v in scene.goal),
        objects=objects,
        picture=picture,
        metres_per_unit=None if scene.metres_per_unit is None else scene.metres_per_unit / factor,
        recipe=scene.recipe if factor == 1 else None,  # it describes the picture as it was drawn
    )


def trim(data: DemonstrationSet) -> DemonstrationSet:
    """Every path without standing still at its ends (one point of each rest is kept)."""
    d = data.demonstrations
    keep = np.concatenate([first_and_last_motion(d.points(i)[:, :2]) for i in range(len(d))])
    counts = np.add.reduceat(keep.astype(np.int64), d.offsets[:-1])
    return replace(
        data,
        demonstrations=with_columns(
            d,
            flat=d.flat[keep],
            offsets=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            t=None if d.t is None else d.t[keep],
        ),
    )
