"""Options that name a detector of somebody else, shared by `detect`, `convert` and `fit`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import say

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet
    from demospec.progress import Progress

DetectorName = Annotated[
    str | None,
    typer.Option(
        "--detector",
        metavar="NAME[:ARGUMENT]",
        help="List the objects with another detector: json:RESULTS, onnx:MODEL.onnx, "
        "torchvision:NAME:WEIGHTS.pth, or one that a package registered.",
    ),
]
Symbols = Annotated[
    str | None,
    typer.Option(
        "--symbols",
        metavar="CLASS=SYMBOL,…",
        help="Classes of the detector → symbols of the set; others keep their word.",
    ),
]


def other_detector(name: str, symbols: str | None) -> dict[str, Any]:
    """The arguments ``detector`` and ``symbols`` of `detect_in_set`."""
    from demospec.perception.detectors import detector_of, symbol_map

    words = None if symbols is None else symbol_map(symbols)
    return {"detector": detector_of(name), "symbols": words}


def with_detections(
    data: DemonstrationSet, name: str, symbols: str | None, progress: Progress
) -> DemonstrationSet:
    """The set with the lists of the detector that --detector names."""
    from demospec.perception import detect_in_set

    seen, skipped = detect_in_set(data, progress=progress, **other_detector(name, symbols))
    say_skipped(data, skipped)
    return seen


def say_skipped(data: DemonstrationSet, skipped: tuple[str, ...]) -> None:
    """Which scenes keep their list, and why."""
    for name in skipped:
        why = "has no picture" if data.scene(name).picture is None else "is not in the detections"
        say(f"note: scene {name} {why}; its list is kept as it is")
