"""`demospec doctor`."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from demospec.cli._common import Json, Out, print_json, save_json

SERVES: dict[str, tuple[tuple[str, ...], str]] = {
    "vision": (("torch",), "fit, detect, predict from pictures, repair, sample, scenes, pretrain"),
    "studio": (("nicegui",), "studio"),
    "cpsat": (("ortools",), "rules --engine direct, rules --engine step"),
    "planners": (("ompl",), "plan --planner rrtstar, bitstar, informed-rrtstar"),
    "robot": (("mujoco", "mink", "imageio", "example-robot-data"), "execute"),
    "ros": (("rosbags", "mcap", "mcap_protobuf"), "convert of bags, export to MCAP and rosbag2"),
    "ros2": (("rclpy",), "monitor --ros2"),
    "filter": (("qpsolvers", "daqp"), "the monitor's velocity filter"),
    "stl": (("rtamt",), "export to STL, checked"),
    "onnx": (("onnx",), "export of models to ONNX"),
    "detect": (("onnxruntime",), "detectors in ONNX"),
    "objects": (("pycocotools", "yaml"), "objects in COCO run-length masks and YOLO lists"),
    "markers": (("pupil_apriltags",), "studio: the scale of a picture from a printed AprilTag"),
    "hdf5": (("h5py",), "convert of HDF5 files"),
    "video": (("av",), "convert of LeRobot sets with video"),
    "distributed": (("dask", "distributed"), "--cluster"),
    "testing": (("hypothesis",), "demospec.testing.strategies"),
}
"""Extra → the packages that it brings, by import name (by its own name where it has no module),
and what needs them."""


def doctor(json: Json = False, out: Out = None) -> None:
    """List versions, extras that are present or absent, and what each of them serves."""
    document = examined()
    save_json(document, out)
    if json:
        print_json(document)
        return
    print(f"demospec {document['demospec']}, Python {document['python']}, {sys.platform}")
    for name, version in document["core"].items():
        print(f"core      {name:16} {version or 'absent: reinstall demospec'}")
    for name, extra in document["extras"].items():
        state = "present" if extra["present"] else f"absent (pip install 'demospec[{name}]')"
        versions = ", ".join(f"{k} {v}" for k, v in extra["versions"].items() if v)
        print(
            f"extra     {name:16} {state}: {extra['serves']}{'; ' + versions if versions else ''}"
        )
    for name, found in document["system"].items():
        print(f"system    {name:16} {found or 'not found'}")


def examined() -> dict[str, Any]:
    """The document of ``demospec doctor``. Imports none of the packages that it names."""
    present = set(metadata.metadata("demospec").get_all("Provides-Extra") or ())
    return {
        "demospec": metadata.version("demospec"),
        "python": ".".join(map(str, sys.version_info[:3])),
        "core": {name: _version(name) for name in _core()},
        "extras": {
            name: {
                "present": all(found.values()),
                "versions": found,
                "serves": serves,
            }
            for name, (packages, serves) in SERVES.items()
            if name in present
            for found in ({p: _version_of_import(p) for p in packages},)
        },
        "system": _system(),
    }


def _core() -> list[str]:
    required = metadata.requires("demospec") or []
    return [re.split(r"[ ;<>=!~\[]", line)[0] for line in required if "extra ==" not in line]


def _version(distribution: str) -> str | None:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


def _version_of_import(package: str) -> str | None:
    if "-" in package:
        return _version(package)
    if find_spec(package) is None:
        return None
    return _version(_distributions().get(package, [package])[0])


@cache
def _distributions() -> Mapping[str, list[str]]:
    return metadata.packages_distributions()


def _system() -> dict[str, str | None]:
    from ctypes.util import find_library

    browser = next(
        (p for n in ("chromium", "chromium-browser", "google-chrome") if (p := shutil.which(n))),
        None,
    )
    furniture = Path("/usr/share/sweethome3d/furniture")
    return {
        "chromium": browser,
        "EGL": find_library("EGL"),
        "ROS 2": shutil.which("ros2"),
        "sweethome3d": str(furniture) if furniture.is_dir() else None,
    }
