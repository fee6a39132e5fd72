"""The simulated demonstrators: what each type keeps clear of, and by how much."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import Polylines, nearest_on_paths
from demospec.scene import STATISTICS, TASK_SYMBOLS, Scene

CLEARANCE_PX = 3.0
"""Clearance at a picture of 100 px (2.46 cm on the table)."""

Clearances = Mapping[str, Mapping[str, float]]
"""Type → symbol → clearance in pixels; symbols that do not matter are absent."""


def true_clearances(
    task: str, clearance_px: float, symbols: Sequence[str] | None = None
) -> Clearances:
    """``careful`` keeps clear of everything, ``normal`` of one symbol, ``aggressive`` of nothing.

    The symbol of ``normal`` is ``glass`` on the tabletop (paper) and ``drill`` on the workbench.
    `symbols` are those that the catalogue has; by default all of the task.
    """
    return {
        "careful": dict.fromkeys(symbols or TASK_SYMBOLS[task], clearance_px),
        "normal": {STATISTICS[task].watched: clearance_px},
        "aggressive": {},
    }


def truth_document(clearances: Clearances, metres_per_unit: float, **more: Any) -> dict[str, Any]:
    """The truth as a rule file (readable as a MODEL)."""
    sentences = {
        name: "keeps clear of " + (", ".join(value) if value else "nothing")
        for name, value in clearances.items()
    }
    return {
        "types": {
            name: {
                "clearance": {
                    "relevant": list(value),
                    "uninformed": [],
                    "interval": {symbol: [c, c] for symbol, c in value.items()},
                    "value": dict(value),
                    "distance": "footprint",
                },
                "influence": None,
                "sentence": sentences[name],
            }
            for name, value in clearances.items()
        },
        "units": "px",
        "metres_per_unit": metres_per_unit,
        **more,
    }


def margins(
    scene: Scene, paths: Sequence[FloatArray], clearance: Mapping[str, float]
) -> FloatArray:
    """(n,) least (signed distance − clearance) along each path, set units; +inf without any.

    Exact: that of the path's straight segments.
    """
    out = np.full(len(paths), np.inf)
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in paths])]).astype(np.int64)
    flat = Polylines(np.concatenate([p[:, :2] for p in paths]), offsets)
    for thing in scene.objects or ():
        if thing.symbol in clearance:
            gap, _, _ = nearest_on_paths(flat, thing.outline)
            out = np.minimum(out, gap - clearance[thing.symbol])
    return out
