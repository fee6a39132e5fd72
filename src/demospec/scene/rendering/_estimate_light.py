"""The light of a scene: known for simulated ones, estimated from a user's picture."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from demospec.scene._recipe import Light
from demospec.scene._scene import Scene

RING = (0.006, 0.045)
"""Where shadows are looked for: this far from an outline, in picture widths."""


def light_of(scene: Scene) -> Light:
    """The scene's own light; for a user's picture an estimate.

    Estimate: overlaid objects are as bright as the picture is, and their shadow falls to the
    side on which the table around the listed objects is darkest. Without listed objects the
    lamp stands at the upper left.
    """
    if scene.recipe is not None:
        return scene.recipe.light
    if scene.picture is None:
        return Light()
    grey = scene.pixels().mean(axis=2) / 255.0
    bright = float(np.percentile(grey, 75))
    light = Light(strength=float(np.clip(0.55 + 0.6 * bright, 0.6, 1.05)))
    azimuth = _azimuth(scene, grey)
    return light if azimuth is None else replace(light, azimuth=azimuth)


def _azimuth(scene: Scene, grey: np.ndarray) -> float | None:
    """Direction to the lamp, opposite to where the rings around objects are darker."""
    height, width = grey.shape
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    points = np.stack([x, y], axis=-1)
    things = [o for o in scene.objects or () if o.footprint is not None]
    if not things:
        return None
    distance = np.stack([o.outline.signed_distance(points) for o in things])
    free = distance.min(axis=0) > RING[0] * width
    pull = np.zeros(2)
    for thing, gap in zip(things, distance, strict=True):
        ring = free & (gap < RING[1] * width)
        if ring.sum() < 20:
            continue
        away = points[ring] - thing.center
        away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)
        dark = float(np.median(grey[ring])) - grey[ring]
        # A ring cut by the picture's edge must not pull: take the directions' mean out.
        pull += ((away - away.mean(axis=0)) * dark[:, None]).mean(axis=0)
    if float(np.hypot(*pull)) < 1e-4:
        return None
    return math.atan2(-float(pull[1]), -float(pull[0]))
