"""Reading a scene's code off its picture: observe, then explain every pixel through the drawer.

The detections give the objects' frames, outlines and heights; table, shadows and paint are
least squares through the same formulas that draw them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from demospec.errors import CannotJudgeError
from demospec.frames import FloatArray
from demospec.perception._canonical import Float32Array, to_grid
from demospec.perception._observation import Detection, Observation
from demospec.perception.inference._observe import observe
from demospec.perception.scene_code._code import CodeLength, ObjectCode, SceneCode
from demospec.perception.scene_code._draw import drawn_shadows, shadow_of, window_of
from demospec.perception.scene_code._patch_basis import OPPONENT, load_bases, solved
from demospec.perception.scene_code._patch_frame import frame_of
from demospec.perception.scene_code._table import drawn_table, read_table
from demospec.scene import Image, Scene

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

LEAST_CONFIDENCE = 0.5
"""Detections less sure than this are no objects."""

THROUGH = 0.7
"""Share of the table that shines through a thing that is surely see-through."""

_RIM_PX = 1.5  # around a thing no pixel counts as bare table
_NOISE = 0.01  # of a pixel, 1 = white
_HEIGHT_PX = 8.0  # unit of the network's answer


def read_scene_code(
    picture: Image | Scene | Observation,
    *,
    pixels: Image | None = None,
    network: DistanceNet | None = None,
    scale: float | None = None,
    length: CodeLength | None = None,
    names: Mapping[int, str] | None = None,
) -> SceneCode:
    """The code of a picture.

    Args:
        picture: (h, w, 3) uint8 of any size, a scene with a picture, or what `observe` gave.
        pixels: The picture, where `picture` is what `observe` gave.
        network: The shipped one by default.
        scale: See `observe`.
        length: How many numbers to spend.
        names: Index of a detection → its name; the generic word by default.

    Raises:
        CannotJudgeError: A scene without a picture.
    """
    if isinstance(picture, Scene):
        picture = picture.pixels()
    if not isinstance(picture, Observation):
        pixels = picture
        picture = observe(pixels, network=network, scale=scale)
    if pixels is None:
        raise CannotJudgeError("the picture that was observed", "none", field="pixels")
    length = length or CodeLength()
    image = to_grid(pixels, picture.grid).transpose(1, 2, 0).astype(np.float64)
    objects = []
    for i, detection in enumerate(picture.detections):
        if detection.confidence >= LEAST_CONFIDENCE:
            found = _outlined(detection, picture, length)
            if found is not None:
                name = (names or {}).get(i, detection.kind)
                objects.append(replace(found, symbol=name))
    return _explained(image, picture.size_px, tuple(objects), length)


def _outlined(
    detection: Detection, observation: Observation, length: CodeLength
) -> ObjectCode | None:
    """Frame, outline, height and clearness of an object; no paint yet."""
    distance: Float32Array = detection.distance / np.float32(observation.per_pixel)
    frame = frame_of(distance)
    if frame is None:
        return None
    height, width = distance.shape
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    places = frame.inward(np.stack([x, y], axis=-1))
    inside = (np.abs(places) <= 1.0).all(axis=-1)
    basis = load_bases().outline.cut(length.outline)
    mean, patches = basis.at(places[inside])
    own = distance[inside].astype(np.float64)
    # The rim is what is drawn; far from it the sign suffices.
    weight = np.exp(-((own / 1.5) ** 2)) + 0.05
    target = np.clip(own / frame.half[1], -1.0, 1.0) - mean
    noise = 0.05 / frame.half[1]  # a twentieth of a pixel
    outline = solved(patches, target, weight, basis.spread, noise)
    mask = distance < 0
    tall = float(np.median(observation.answers[4][mask])) * _HEIGHT_PX if mask.any() else 0.0
    return ObjectCode(
        frame.center, frame.angle_rad, frame.half, outline, np.zeros(length.luma),
        np.zeros((2, length.chroma)), float(THROUGH * detection.clear), max(tall, 0.0), 0.0,
        detection.kind, detection.confidence,
    )  # fmt: skip


def _explained(
    image: FloatArray, size_px: tuple[int, int], objects: tuple[ObjectCode, ...], length: CodeLength
) -> SceneCode:
    """Table, lamp, shades and paint of things whose outlines are known."""
    grid = (image.shape[1], image.shape[0])
    one = np.ones(2)
    bare = np.ones(image.shape[:2])
    for item in objects:
        window = window_of(item, grid, one)
        bare[window.rows, window.columns][window.distance < _RIM_PX] = 0.0
    # First without waves and off the shadows, then with the shadows taken out.
    away = bare.copy()
    for item in objects:
        window = window_of(replace(item, half=item.half + 5.0), grid, one)
        away[window.rows, window.columns] = 0.0
    table = read_table(image, away if away.mean() > 0.3 else bare, replace(length, waves=0))
    code = SceneCode(size_px, grid, table, np.zeros(2), objects)
    if objects:
        code = _shaded(image, bare, code)
    left = drawn_shadows(code, grid)
    table = read_table(image / np.maximum(left, 0.2)[..., None], bare, length)
    code = replace(code, table=table)
    under = drawn_table(table, grid, grid) * left[..., None]
    return code.with_objects(tuple(_painted(item, image, under) for item in code.objects))


def _shaded(image: FloatArray, bare: FloatArray, code: SceneCode) -> SceneCode:
    """The lamp and the shades that explain best how dark the bare table is near the things."""
    under = drawn_table(code.table, code.grid, code.grid).mean(axis=2)
    lost = np.clip(1.0 - image.mean(axis=2) / np.maximum(under, 0.02), -0.5, 1.0)
    best, best_gain = code, 0.0
    for reach in (0.0, 0.25, 0.45, 0.7):
        for angle in np.arange(16) * (np.pi / 8) if reach else (0.0,):
            lamp = reach * np.array([np.cos(angle), np.sin(angle)])
            objects, gain = [], 0.0
            for item in code.objects:
                rows, columns, dark = shadow_of(item, lamp, code.grid, np.ones(2))
                weight = bare[rows, columns] * (dark > 0.02)
                power = float((weight * dark * dark).sum())
                shade = float((weight * dark * lost[rows, columns]).sum()) / (power + 0.5)
                shade = float(np.clip(shade, 0.0, 0.8))
                gain += power * shade**2
                objects.append(replace(item, shade=shade))
            if gain > best_gain:
                best, best_gain = replace(code, lamp=lamp, objects=tuple(objects)), gain
    return best


def _painted(item: ObjectCode, image: FloatArray, under: FloatArray) -> ObjectCode:
    """The thing with the paint that explains its pixels over that table."""
    grid = (image.shape[1], image.shape[0])
    window = window_of(item, grid, np.ones(2))
    cover = window.cover
    on = cover > 0.02
    if not on.any():
        return item
    cover = cover[on]
    here = (window.rows, window.columns)
    through = (1.0 - cover * (1.0 - item.clear))[:, None] * under[here][on]
    target = (image[here][on] - through) @ OPPONENT.T
    bases = load_bases()
    places = window.places[on]
    basis = bases.luma.cut(len(item.luma))
    mean, patches = basis.at(places)
    ones = np.ones(len(cover))
    luma = solved(patches * cover[:, None], target[:, 0] - cover * mean, ones, basis.spread, _NOISE)
    basis = bases.chroma.cut(item.chroma.shape[1])
    mean, patches = basis.at(places)
    rest = target[:, 1:] - (cover * mean)[:, None]
    chroma = solved(patches * cover[:, None], rest, ones, basis.spread, _NOISE)
    return replace(item, luma=luma, chroma=chroma.T)
