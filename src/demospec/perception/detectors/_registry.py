"""Detectors by name: those of the package, and those that other packages bring."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from demospec.errors import InputError
from demospec.perception.detectors._protocol import Detector

GROUP = "demospec.detectors"
"""Entry-point group: name → a function of the argument (or None) that gives a `Detector`."""


def _json(argument: str | None) -> Detector:
    from demospec.perception.detectors._results import ListedDetections

    return ListedDetections(_needed(argument, "json", "the file or folder of results"))


def _onnx(argument: str | None) -> Detector:
    from demospec.perception.detectors._onnx import OnnxDetector

    return OnnxDetector(_needed(argument, "onnx", "the model's file"))


def _torchvision(argument: str | None) -> Detector:
    from demospec.perception.detectors._torchvision import torchvision_detector

    return torchvision_detector(_needed(argument, "torchvision", "the model's name"))


_OWN: dict[str, Callable[[str | None], Detector]] = {
    "json": _json,
    "onnx": _onnx,
    "torchvision": _torchvision,
}


def _needed(argument: str | None, name: str, what: str) -> str:
    if not argument:
        raise InputError(f"{name}:ARGUMENT, {what}", name, field="--detector")
    return argument


def detector_names() -> tuple[str, ...]:
    """The names that `detector_of` knows here."""
    from importlib.metadata import entry_points

    return tuple(sorted({*_OWN, *(e.name for e in entry_points(group=GROUP))}))


def detector_of(text: str) -> Detector:
    """The detector that ``NAME`` or ``NAME:ARGUMENT`` names.

    Raises:
        InputError: A name that nobody registered, a package that fails to load, something that
            is no detector, or what the detector says of its argument.
        MissingExtraError: A library that it needs is not installed.
    """
    name, colon, argument = text.partition(":")
    given = argument if colon else None
    if name in _OWN:
        return _OWN[name](given)
    made = _entry(name)(given)
    if not isinstance(made, Detector):
        raise InputError("a detector (with .name and .detect)", type(made).__name__,
                         field=f"--detector {name}")  # fmt: skip
    return made


def _entry(name: str) -> Callable[[str | None], Any]:
    from importlib.metadata import entry_points

    found = list(entry_points(group=GROUP, name=name))
    if not found:
        known = ", ".join(detector_names())
        raise InputError(f"a detector ({known})", name or "nothing", field="--detector")
    try:
        loaded: Callable[[str | None], Any] = found[0].load()
    except Exception as error:  # another package's import may fail in any way
        raise InputError(f"{found[0].value} to load", f"{type(error).__name__}: {error}",
                         field=f"--detector {name}") from error  # fmt: skip
    return loaded
