"""Tiny sets with a known rule, in which z_θ alone says nothing: the picture is needed."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, bezier_points
from demospec.frames import FloatArray
from demospec.scene import Disc, Picture, Scene, SceneObject

START, GOAL = (10.0, 90.0), (90.0, 10.0)


def colour_set(
    scenes: int = 12, each: int = 10, *, seed: int = 0, size: int = 100, blank: bool = False
) -> DemonstrationSet:
    """Red scenes accept control points above the diagonal, blue ones below; colours alternate.

    Args:
        each: Demonstrations per scene of the type ``sided``; ``any`` gets two that are valid.
        blank: All pictures are the same grey.
    """
    rng = np.random.default_rng(seed)
    places, items = [], []
    for i in range(scenes):
        colour = np.array([200, 40, 40] if i % 2 == 0 else [40, 40, 200])
        pixels = np.clip(colour + rng.integers(-20, 20, (size, size, 3)), 0, 255)
        if blank:
            pixels = np.full((size, size, 3), 128)
        picture = Picture(array=pixels.astype(np.uint8))
        scale = size / 100
        start, goal = tuple(v * scale for v in START), tuple(v * scale for v in GOAL)
        places.append(Scene(f"s{i}", start, goal, None, picture))
        for k in range(each + 2):
            control = rng.uniform(0, size, 2)
            above = control[0] + control[1] < size
            valid = bool(above == (i % 2 == 0)) if k < each else True
            items.append(
                Demonstration(
                    f"s{i}-{k}",
                    f"s{i}",
                    bezier_points(start, goal, control, 60),
                    type="sided" if k < each else "any",
                    demonstrator="p",
                    valid=valid,
                )
            )
    return DemonstrationSet(
        tuple(places), Demonstrations.of(items), types=("sided", "any"), symbols=("glass",)
    )


def with_labels(data: DemonstrationSet, valid: np.ndarray) -> DemonstrationSet:
    """The same set with other labels (n,) of 1, 0, −1."""
    from dataclasses import replace

    demonstrations = data.demonstrations.rows(np.arange(len(data.demonstrations)))
    demonstrations.valid = valid.astype(np.int8)
    return replace(data, demonstrations=demonstrations)


def disc_scene(*discs: tuple[float, float, float], symbol: str = "glass") -> Scene:
    """A 100×100 scene with discs (x, y, radius)."""
    objects = tuple(
        SceneObject(f"{symbol}-{i}", symbol, (x, y), None, Disc((x, y), r))
        for i, (x, y, r) in enumerate(discs)
    )
    picture = Picture(array=np.zeros((100, 100, 3), np.uint8))
    return Scene("discs", START, GOAL, objects, picture)


class DiscView:
    """A formula: the margin of a path to discs; differentiable, no network, no rule room."""

    def __init__(self, scene: Scene, keep: float) -> None:
        self.scene = scene
        self.keep = keep

    def logits(self, paths: FloatArray, type: str) -> FloatArray:
        return self._nearest(np.asarray(paths), type)[0]

    def p_valid(self, paths: FloatArray, type: str) -> FloatArray:
        return (self.logits(paths, type) > 0).astype(np.float64)

    def _nearest(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        keep = self.keep if type == "careful" else -1e3
        discs = [o.footprint for o in self.scene.objects or ()]
        centres = np.array([d.center for d in discs])
        radii = np.array([d.radius for d in discs])
        away = paths[:, :, None] - centres
        distance = np.linalg.norm(away, axis=-1)
        margin = (distance - radii - keep).reshape(len(paths), -1)
        at = margin.argmin(axis=1)
        i, j = np.divmod(at, len(discs))
        rows = np.arange(len(paths))
        slope = np.zeros_like(paths)
        slope[rows, i] = away[rows, i, j] / np.maximum(distance[rows, i, j, None], 1e-9)
        return margin[rows, at], slope


class SlopedDiscView(DiscView):
    """The same with gradients."""

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        return self._nearest(paths, type)


class DiscModel:
    """``careful`` keeps clear of every disc, ``bold`` of nothing."""

    types = ("careful", "bold")

    def __init__(self, keep: float = 5.0) -> None:
        self.keep = keep

    def see(self, scene: Scene) -> SlopedDiscView:
        scene.listed_objects()
        return SlopedDiscView(scene, self.keep)
