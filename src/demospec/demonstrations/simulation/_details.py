"""What simulated scenes and paths hold beside places: headings, heights, relations, times, tilt."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.demonstrations._motion import Motion
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Relation, Scene

COLUMNS = ("z", "tilt", "speed")
"""Columns that a simulated path may hold after x, y."""


@dataclass(frozen=True)
class Details:
    """What is simulated beside outlines and places.

    Args:
        columns: Of `COLUMNS`. ``z`` is the height of the hand (0 to about a third of the
            table); ``tilt`` degrees from upright; ``speed`` pixels a second, of which the
            times follow (without it there are twenty points a second).
        headings: Every object faces some way.
        heights: Every object has a height, 0 to a fifth of the table.
        relations: Kinds; in most scenes some two objects are joined by each.
    """

    columns: tuple[str, ...] = ()
    headings: bool = False
    heights: bool = False
    relations: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in self.columns:
            if name not in COLUMNS:
                raise InputError(f"some of {', '.join(COLUMNS)}", name, field="columns")
        if len(set(self.columns)) < len(self.columns):
            raise InputError("each column once", ", ".join(self.columns), field="columns")

    @property
    def names(self) -> tuple[str, ...]:
        """All columns of a point."""
        return ("x", "y", *self.columns)

    def of_scene(self, scene: Scene, rng: np.random.Generator, size_px: float) -> Scene:
        """The scene with what is asked for."""
        objects = list(scene.objects or ())
        if self.headings:
            turns = rng.uniform(-180.0, 180.0, len(objects)).round(1)
            objects = [
                replace(o, heading_deg=float(v)) for o, v in zip(objects, turns, strict=True)
            ]
        if self.heights:
            tops = (size_px * rng.uniform(0.04, 0.2, len(objects))).round(2)
            objects = [
                replace(o, height=(0.0, float(v))) for o, v in zip(objects, tops, strict=True)
            ]
        relations = []
        for kind in self.relations:
            if len(objects) >= 2 and rng.random() < 0.9:
                one, other = rng.permutation(len(objects))[:2]
                relations.append(Relation(kind, (objects[one].id, objects[other].id)))
        return replace(scene, objects=tuple(objects), relations=tuple(relations))

    def of_path(
        self, path: FloatArray, rng: np.random.Generator, size_px: float, rate_hz: float
    ) -> Motion:
        """The path with its columns and times."""
        n = len(path)
        u = np.linspace(0.0, 1.0, n)
        t = np.round(np.arange(n) / rate_hz, 6)
        extra: dict[str, FloatArray] = {}
        if "z" in self.columns:
            low, rise = rng.uniform(0.02, 0.25) * size_px, rng.uniform(0.0, 0.12) * size_px
            dip = rng.uniform(0.2, 0.8)
            extra["z"] = low + rise * np.abs(u - dip) / max(dip, 1 - dip)
        if "tilt" in self.columns:
            off = (u - rng.uniform(0.2, 0.8)) / 0.2
            extra["tilt"] = rng.uniform(0.0, 40.0) * np.exp(-off * off)
        if "speed" in self.columns:
            level = rng.uniform(0.08, 0.4) * size_px
            wave = 1.0 + rng.uniform(-0.4, 0.4) * np.sin(2 * np.pi * (u + rng.uniform()))
            extra["speed"] = level * wave
            step = np.hypot(*np.diff(path, axis=0).T)
            mean = (extra["speed"][1:] + extra["speed"][:-1]) / 2
            t = np.round(np.concatenate([[0.0], np.cumsum(step / mean)]), 6)
        points = np.column_stack([path, *(extra[name] for name in self.columns)])
        return Motion(points, t, self.names)
