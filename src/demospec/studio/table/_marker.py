"""The scale of a picture from printed AprilTags of known size."""

from __future__ import annotations

import importlib.util

import numpy as np

from demospec.errors import DemospecError, MissingExtraError
from demospec.scene import Scene

FAMILY = "tag36h11"
SKEW = 1.15
"""Sides of one tag may differ by this factor; beyond it the picture is not from above."""


class NoMarker(DemospecError):
    """No printed marker gives the scale: a sentence for the person at the page."""


def can_find() -> bool:
    """Whether the detector is installed."""
    return importlib.util.find_spec("pupil_apriltags") is not None


def scale_by_marker(scene: Scene, size_m: float) -> float:
    """Metres per pixel from the AprilTags that lie on the table.

    Args:
        scene: With a picture.
        size_m: Side of the black square of every tag, metres.

    Raises:
        MissingExtraError: The detector is absent.
        NoMarker: None is seen, or the picture is not from above.
    """
    if not can_find():
        raise MissingExtraError("pupil-apriltags", "markers", "finding printed markers")
    from pupil_apriltags import Detector

    grey = np.ascontiguousarray(np.asarray(scene.pixels()).mean(axis=2).astype(np.uint8))
    found = [tag for tag in Detector(families=FAMILY).detect(grey) if tag.hamming == 0]
    if not found:
        raise NoMarker(f"No AprilTag ({FAMILY}) is seen in this picture: measure it by two clicks.")
    sides = []
    for tag in found:
        corners = np.asarray(tag.corners, dtype=np.float64)
        each = np.hypot(*(corners - np.roll(corners, 1, axis=0)).T)
        if each.max() > SKEW * each.min():
            raise NoMarker(
                "The marker is not square here: the picture must be taken from straight above."
            )
        sides.append(float(each.mean()))
    return size_m / float(np.median(sides))
