"""The drawing of a scene."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np

from demospec.demonstrations import Demonstration
from demospec.report import paths_svg, scene_svg
from demospec.scene import Disc, Scene, SceneObject


def test_names_from_files_cannot_inject_markup() -> None:
    evil = "<script>alert(1)</script>\"'"
    scene = Scene(
        evil, (0.0, 0.0), (9.0, 9.0), (SceneObject(evil, evil, (5.0, 5.0), None, Disc((5, 5), 2)),)
    )
    demo = Demonstration(evil, evil, np.zeros((2, 2)), demonstrator=evil)
    svg = scene_svg(scene, paths_svg([demo]))
    assert "<script" not in svg
    ElementTree.fromstring(svg)
