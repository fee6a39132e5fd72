"""Detectors of others: a protocol, the package's adapters, and lists made of what they find."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.detectors._listing import OVERLAP, listed, symbol_map
    from demospec.perception.detectors._onnx import OnnxDetector
    from demospec.perception.detectors._protocol import Detector, Finding
    from demospec.perception.detectors._registry import GROUP, detector_names, detector_of
    from demospec.perception.detectors._results import ListedDetections
    from demospec.perception.detectors._torchvision import TorchvisionDetector

__all__ = [
    "GROUP",
    "OVERLAP",
    "Detector",
    "Finding",
    "ListedDetections",
    "OnnxDetector",
    "TorchvisionDetector",
    "detector_names",
    "detector_of",
    "listed",
    "symbol_map",
]

_HOME = {
    "GROUP": "_registry",
    "OVERLAP": "_listing",
    "Detector": "_protocol",
    "Finding": "_protocol",
    "ListedDetections": "_results",
    "OnnxDetector": "_onnx",
    "TorchvisionDetector": "_torchvision",
    "detector_names": "_registry",
    "detector_of": "_registry",
    "listed": "_listing",
    "symbol_map": "_listing",
}


__getattr__ = names_of(__name__, _HOME)
