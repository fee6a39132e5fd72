"""The simulated demonstrators: what each type keeps clear of, and by how much."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from demospec.demonstrations._bezier import densify
from demospec.frames import FloatArray
from demospec.geometry import MultiPolygon, Polygon
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
    scene: Scene, paths: Sequence[FloatArray], clearance: Mapping[str, float], spacing: float
) -> FloatArray:
    """(n,) least (signed distance − clearance) along each path, pixels; capped at 1.

    Exact up to the spacing of the dense points. Points further from an object's enclosing
    circle than its clearance and one pixel cannot change the answer and are skipped.
    """
    out = np.ones(len(paths))
    things = [o for o in scene.objects or () if o.symbol in clearance]
    if not things:
        return out
    dense = [densify(path[:, :2], spacing) for path in paths]
    flat = np.concatenate(dense)
    first = np.concatenate([[0], np.cumsum([len(d) for d in dense])[:-1]])
    worst = np.ones(len(flat))
    for thing in things:
        keep = clearance[thing.symbol]
        shape = thing.outline
        near = np.arange(len(flat))
        if isinstance(shape, (Polygon, MultiPolygon)):
            reach = float(np.linalg.norm(shape.vertices - thing.center, axis=1).max())
            gap = np.hypot(flat[:, 0] - thing.center[0], flat[:, 1] - thing.center[1]) - reach
            near = np.flatnonzero(gap - keep < 1.0)
        if len(near):
            worst[near] = np.minimum(worst[near], shape.signed_distance(flat[near]) - keep)
    return np.asarray(np.minimum.reduceat(worst, first))
