"""The newest transforms between frames, as `/tf` tells them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from demospec.frames import FloatArray


class TransformTree:
    """Parent and pose of every frame; the newest message counts.

    A frame whose chain is not complete (yet) has no pose.
    """

    def __init__(self) -> None:
        self._links: dict[str, tuple[str, FloatArray, float]] = {}

    def add(self, transforms: Iterable[Any], *, static: bool = False) -> None:
        """Takes the ``transforms`` of one message; static ones hold at any time."""
        for one in transforms:
            stamp = one.header.stamp
            t = np.inf if static else stamp.sec + 1e-9 * stamp.nanosec
            parent = str(one.header.frame_id).strip("/")
            child = str(one.child_frame_id).strip("/")
            self._links[child] = (parent, _matrix(one.transform), t)

    def pose(self, parent: str, child: str) -> tuple[FloatArray, float] | None:
        """(x, y, z, qx, qy, qz, qw) of a frame in another, and the time of its oldest link, s.

        None where no chain of transforms leads from one to the other.
        """
        up, down = self._to_root(parent), self._to_root(child)
        if up is None or down is None or up[0] != down[0]:
            return None
        matrix = np.linalg.inv(up[1]) @ down[1]
        t = min(up[2], down[2])
        return np.concatenate([matrix[:3, 3], _quaternion(matrix)]), float(t)

    def _to_root(self, name: str) -> tuple[str, FloatArray, float] | None:
        """Topmost frame above `name`, the pose in it, and the time; None in a circle."""
        pose, t, seen = np.eye(4), np.inf, {name}
        while name in self._links:
            name, link, when = self._links[name]
            if name in seen:
                return None
            seen.add(name)
            pose, t = link @ pose, min(t, when)
        return name, pose, t


def _matrix(transform: Any) -> FloatArray:
    x, y, z = (float(getattr(transform.translation, axis)) for axis in "xyz")
    a, b, c, w = (float(getattr(transform.rotation, axis)) for axis in "xyzw")
    n = np.sqrt(a * a + b * b + c * c + w * w)
    a, b, c, w = (v / n if n > 0 else v for v in (a, b, c, w))
    return np.array(
        [
            [1 - 2 * (b * b + c * c), 2 * (a * b - c * w), 2 * (a * c + b * w), x],
            [2 * (a * b + c * w), 1 - 2 * (a * a + c * c), 2 * (b * c - a * w), y],
            [2 * (a * c - b * w), 2 * (b * c + a * w), 1 - 2 * (a * a + b * b), z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def _quaternion(matrix: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(matrix[:3, :3]).as_quat())
