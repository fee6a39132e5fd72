"""Metres of the robot's frame to set units, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import DemonstrationSet
from demospec.frames import FloatArray, Frame, PixelFrame, metres_of_unit
from demospec.planning import map_bounds
from demospec.scene import Scene


@dataclass(frozen=True)
class RobotFrame:
    """The frame in which a robot reports positions: that of the set's exports.

    Args:
        pixels: Set units ↔ metres by scale.
        axes: The frame of the set; where it holds a homography, that maps set coordinates to
            metres.
    """

    pixels: PixelFrame
    axes: Frame

    @classmethod
    def of(cls, data: DemonstrationSet, scene: Scene) -> RobotFrame:
        """The frame of one scene of a set."""
        return cls.of_scene(scene, data.units, data.metres_per_unit, data.axes)

    @classmethod
    def of_scene(
        cls,
        scene: Scene,
        units: str,
        metres_per_unit: float | None = None,
        axes: Frame | None = None,
    ) -> RobotFrame:
        """The frame of a scene in these units; without `axes` the one that the unit implies."""
        scale = metres_of_unit(units, scene.metres_per_unit or metres_per_unit)
        where = Frame.of_units(units) if axes is None else axes
        return cls(PixelFrame(map_bounds(scene)[3], scale, where.y), where)

    @property
    def frame_id(self) -> str:
        return self.axes.name or "map"

    def to_units(self, metres: ArrayLike) -> FloatArray:
        """(…, 2) metres → set units.

        Raises:
            InputError: The set does not say how large a unit is.
        """
        if self.axes.homography is None:
            return self.pixels.to_pixels(metres)
        return _projected(np.linalg.inv(np.array(self.axes.homography)), metres)

    def to_metres(self, points: ArrayLike) -> FloatArray:
        """(…, 2) set units → metres; the inverse of `to_units`."""
        if self.axes.homography is None:
            return self.pixels.to_metres(points)
        return _projected(np.array(self.axes.homography), points)

    def turn_to_units(self, velocity: ArrayLike, at: ArrayLike) -> FloatArray:
        """(2,) velocity at a place, m/s → set units per second."""
        step = 1e-6
        here = np.asarray(at, dtype=np.float64)
        there = here + step * np.asarray(velocity, dtype=np.float64)
        return np.asarray((self.to_units(there) - self.to_units(here)) / step)

    def heading_to_units(self, angle_rad: float) -> float:
        """A direction in the robot's frame, rad from +x to +y, as degrees in the set's."""
        turned = -angle_rad if self.axes.y == "down" and self.axes.homography is None else angle_rad
        return float(np.degrees(turned))


def _projected(matrix: FloatArray, points: ArrayLike) -> FloatArray:
    flat = np.asarray(points, dtype=np.float64)
    whole = np.concatenate([flat[..., :2], np.ones((*flat.shape[:-1], 1))], axis=-1) @ matrix.T
    return np.asarray(whole[..., :2] / whole[..., 2:])
