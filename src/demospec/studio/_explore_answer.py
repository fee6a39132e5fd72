"""The Explore page's answers as JSON documents: look, repair, sample, put down."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from demospec.demonstrations import View
from demospec.frames import describe_length
from demospec.rules import RuleView
from demospec.scene import Capsule, Disc, Footprint, Polygon, Scene
from demospec.specification import (
    Explanation,
    RepairSettings,
    ValidityMap,
    explain,
    plane_bounds,
    repair,
    sample_valid,
)
from demospec.studio._explore_map import SMALL, boundary_path, explore_map
from demospec.studio._explore_state import Edits, Explorer, Question, path_of
from demospec.studio._scene_svg import _data_url

_SURE = float(np.log(9.0))
"""Logit of p = 0.9: outside ±`_SURE` a learned model is sure."""


def look(explorer: Explorer, question: Question) -> dict[str, Any]:
    """Everything that follows the hand: verdicts, reason, maps, the scene as it now stands.

    Returns:
        ``scene`` (objects with outlines, the picture where it changed), ``verdicts`` and
        ``small`` maps per type, ``why`` (`Explanation`), ``map`` of the chosen type, ``before``
        (the same without what was put down, or None) and ``milliseconds`` spent here.
    """
    began = time.perf_counter()
    with explorer.lock:
        view = explorer.view(question)
        path = path_of(view.scene, question.control)
        types = tuple(explorer.model(question.model).types)
        found = explore_map(view, question.type)
        small = {t: explore_map(view, t, SMALL) for t in types}
        reason = explain(
            view, path, question.type,
            units=explorer.units, metres_per_unit=explorer.metres_per_unit,
        )  # fmt: skip
        verdicts = _verdicts(view, path, types, small)
        before = None
        if question.edits.added:
            clean = explorer.view(question, question.edits.without_added())
            maps = {t: explore_map(clean, t, SMALL) for t in types}
            before = {
                "verdicts": _verdicts(clean, path, types, maps),
                "small": [_map_document(maps[t], sure=False) for t in types],
                "scene": scene_document(
                    explorer.scene(question.scene_id, question.edits.without_added()),
                    question.edits.without_added(),
                ),
            }
        now = explorer.scene(question.scene_id, question.edits)
        scene = scene_document(now, question.edits)
    return {
        "scene": scene,
        "verdicts": verdicts,
        "why": _reason(reason),
        "map": _map_document(found, sure=not isinstance(view, RuleView)),
        "small": [_map_document(small[t], sure=False) for t in types],
        "before": before,
        "certain": isinstance(view, RuleView),
        "milliseconds": round(1000 * (time.perf_counter() - began), 1),
    }


def mend(explorer: Explorer, question: Question) -> dict[str, Any]:
    """Repair of the path: the control points gone through, and the nearest that holds.

    ``true_valid`` is the verdict of the rule that made the labels, None where it is unknown.
    """
    with explorer.lock:
        view = explorer.view(question)
        found = repair(view, [question.control], question.type, settings=RepairSettings())
        control = (float(found.control[0, 0, 0]), float(found.control[0, 0, 1]))
        path = path_of(view.scene, control)
        change = float(np.hypot(*(path - path_of(view.scene, question.control)).T).max())
        length = describe_length(change, explorer.metres_per_unit, explorer.units)
        return {
            "steps": [[round(float(v), 3) for v in z[0]] for z in found.trace[0]],
            "control": list(control),
            "holds": bool(found.holds[0]),
            "moved": change,
            "control_moved": float(found.moved[0]),
            "words": length,
            "p_valid": float(found.p_valid[0]),
            "true_valid": _true_verdict(explorer, question, path),
        }


def solutions(explorer: Explorer, question: Question, n: int = 8) -> dict[str, Any]:
    """Varied valid solutions: some from every region of the map that the model accepts."""
    with explorer.lock:
        view = explorer.view(question)
        found = sample_valid(view, question.type, n, size=SMALL)
        scene = view.scene
        paths = [
            {
                "control": [float(v) for v in found.control[i, 0]],
                "mode": int(found.mode[i]),
                "p_valid": float(found.p_valid[i]),
                "true_valid": _true_verdict(
                    explorer, question, path_of(scene, tuple(found.control[i, 0]))
                ),
            }
            for i in range(len(found.control))
        ]
    return {"paths": paths, "modes": found.modes, "diversity": found.diversity}


def put_down(explorer: Explorer, question: Question, symbol: str) -> dict[str, Any]:
    """A free place for one more thing, as near to the path as there is one."""
    with explorer.lock:
        x, y = explorer.free_place(question, symbol)
    return {"symbol": symbol, "x": round(x, 2), "y": round(y, 2)}


def scene_document(scene: Scene, edits: Edits) -> dict[str, Any]:
    """Start, goal, bounds, objects with outlines as SVG paths, and the picture as PNG data."""
    objects = scene.objects or ()
    first_added = len(objects) - len(edits.added)
    return {
        "id": scene.scene_id,
        "start": [float(v) for v in scene.start[:2]],
        "goal": [float(v) for v in scene.goal[:2]],
        "bounds": list(plane_bounds(scene)),
        "size": list(scene.size_px) if scene.size_px is not None else None,
        "objects": [
            {
                "id": o.id,
                "symbol": o.symbol,
                "center": [float(v) for v in o.center[:2]],
                "outline": outline_path(o.outline),
                "added": i - first_added if i >= first_added else None,
            }
            for i, o in enumerate(objects)
        ],
        "picture": _data_url(scene) if scene.picture is not None else None,
    }


def outline_path(shape: Footprint) -> str:
    """A footprint as the ``d`` of a closed SVG path."""
    if isinstance(shape, Polygon):
        return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in shape.vertices) + "Z"
    if isinstance(shape, Disc):
        (x, y), r = shape.center, max(float(shape.radius), 0.6)
        half = f"a{r:.2f} {r:.2f} 0 1 0"
        return f"M{x - r:.2f} {y:.2f}{half} {2 * r:.2f} 0{half} {-2 * r:.2f} 0Z"
    assert isinstance(shape, Capsule)
    start, end = np.asarray(shape.start), np.asarray(shape.end)
    angle = float(np.arctan2(*(end - start)[::-1]))
    turns = np.linspace(-np.pi / 2, np.pi / 2, 13)
    caps = [end + shape.radius * np.stack([np.cos(angle + turns), np.sin(angle + turns)], 1)]
    caps.append(start - shape.radius * np.stack([np.cos(angle + turns), np.sin(angle + turns)], 1))
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in np.concatenate(caps)) + "Z"


def _verdicts(
    view: View, path: Any, types: tuple[str, ...], maps: dict[str, ValidityMap]
) -> list[dict[str, Any]]:
    return [
        {
            "type": name,
            "valid": bool(view.logits(path[None], name)[0] > 0),
            "p_valid": round(float(view.p_valid(path[None], name)[0]), 4),
            "mean_p": round(float(maps[name].p_valid.mean()), 4),
        }
        for name in types
    ]


def _map_document(found: ValidityMap, *, sure: bool) -> dict[str, Any]:
    """The boundary; with `sure` also the lines p = 0.1 and p = 0.9 of a model that doubts."""
    document: dict[str, Any] = {
        "type": found.type,
        "region": boundary_path(found),
        "share": round(found.valid_share, 4),
    }
    if sure:
        document["sure"] = [boundary_path(found, v, closed=False) for v in (-_SURE, _SURE)]
    return document


def _reason(found: Explanation) -> dict[str, Any]:
    document = found.to_json()
    way = found.counterfactual
    document["counterfactual"] = None if way is None else np.round(way[::4], 1).tolist()
    document["logit"] = round(found.logit, 4)
    return document


def _true_verdict(explorer: Explorer, question: Question, path: Any) -> bool | None:
    judge = explorer.true_view(question)
    return None if judge is None else bool(judge.logits(path[None], question.type)[0] > 0)
