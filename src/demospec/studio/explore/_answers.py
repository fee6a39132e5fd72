"""The Explore page's answers as JSON documents: look, repair, sample, put down."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.demonstrations import JudgingView, Verdict, View
from demospec.frames import describe_length
from demospec.geometry import Disc, Footprint, rims
from demospec.report import data_url, ring_words_svg, rings_svg
from demospec.rules import ClearanceRule, RuleView, nearest_approach
from demospec.scene import Scene, SceneObject
from demospec.specification import (
    Explanation,
    RepairSettings,
    explain,
    plane_bounds,
    repair,
    sample_valid,
)
from demospec.studio.explore._map import SMALL, BendMap, boundary_path, explore_map, thresholds
from demospec.studio.explore._state import Edits, Explorer, Question, path_of

_SURE = float(np.log(9.0))
"""Logit of p = 0.9: outside ±`_SURE` a learned model is sure."""


def look(
    explorer: Explorer, question: Question, *, has: object = None, moving: bool = False
) -> dict[str, Any]:
    """Everything that follows the hand: verdicts, reason, maps, the scene as it now stands.

    Args:
        has: ``key`` of an answer that the page still shows. Where scene, model and edits are
            those, only what hangs on the path is answered: a control point is dragged a long
            way over one map.
        moving: The hand has not come to rest. The push that would make a rejected path valid
            waits until it does: nobody reads a number that changes ten times a second.

    Returns:
        ``key``, ``verdicts`` and ``why`` (`Explanation`) of the path; where the page lacks
        them ``scene`` (objects with outlines, the picture), ``map`` and ``rings`` of the chosen
        type, ``small`` maps per type, and in the verdicts the ``share`` of all bends that is
        accepted and the share ``unknown``; ``before`` (the same without what was put down, or
        None) and ``milliseconds`` spent here.
    """
    began = time.perf_counter()
    with explorer.lock:
        key = explorer.key(question)
        view = explorer.view(question)
        path = path_of(view.scene, question.control)
        rule = clearance_of(view, question.type)
        reason = explain(
            view, path, question.type, counterfactual=not moving,
            units=explorer.units, metres_per_unit=explorer.scale_of(question.scene_id),
            symbols=None if rule is None else rule.relevant,
        )  # fmt: skip
        verdict = verdict_of(view, path, question.type)
        whole = has != key
        answer = _seen(explorer, question, path, whole=whole)
        if whole:
            answer["map"] = _map_document(
                explore_map(view, question.type), sure=not isinstance(view, RuleView)
            )
            answer["rings"] = _rings(explorer, view, question.type)
            # One number for one thing: the shares beside the person are those beside the map.
            mine = next(v for v in answer["verdicts"] if v["type"] == question.type)
            answer["map"] |= {"share": mine["share"], "unknown": mine["unknown"]}
        answer["before"] = None
        if question.edits.added:
            clean = replace(question, edits=question.edits.without_added())
            answer["before"] = _seen(explorer, clean, path, whole=whole)
    return {
        **answer,
        "key": key,
        "why": {
            **_reason(reason),
            "counterfactual_follows": moving and not reason.valid,
            **({} if verdict != "unknown" else _open(explorer, view, path, question.type)),
        },
        "certain": isinstance(view, RuleView),
        "milliseconds": round(1000 * (time.perf_counter() - began), 1),
    }


def _seen(explorer: Explorer, question: Question, path: Any, *, whole: bool) -> dict[str, Any]:
    """Every type's verdict on the path; with `whole` also its small map, and the scene."""
    view = explorer.view(question)
    types = tuple(explorer.model(question.model).types)
    verdicts: list[dict[str, Any]] = []
    for name in types:
        p = round(float(view.p_valid(path[None], name)[0]), 4)
        verdicts.append({"type": name, "verdict": verdict_of(view, path, name), "p_valid": p})
    if not whole:
        return {"verdicts": verdicts}
    maps = [explore_map(view, name, SMALL) for name in types]
    for verdict, found in zip(verdicts, maps, strict=True):
        verdict |= {"share": round(found.share, 4), "unknown": round(found.unknown, 4)}
    scene = explorer.scene(question.scene_id, question.edits)
    return {
        "verdicts": verdicts,
        "small": [_map_document(found, sure=False) for found in maps],
        "scene": scene_document(scene, question.edits),
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
        length = describe_length(change, explorer.scale_of(question.scene_id), explorer.units)
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
        "picture": data_url(scene) if scene.picture is not None else None,
    }


def outline_path(shape: Footprint) -> str:
    """A footprint as the ``d`` of a closed SVG path, one loop a part."""
    if isinstance(shape, Disc):
        (x, y), r = shape.center, max(float(shape.radius), 0.6)
        half = f"a{r:.2f} {r:.2f} 0 1 0"
        return f"M{x - r:.2f} {y:.2f}{half} {2 * r:.2f} 0{half} {-2 * r:.2f} 0Z"
    loops = ("L".join(f"{x:.1f} {y:.1f}" for x, y in rim) for rim in rims(shape))
    return "".join(f"M{loop}Z" for loop in loops)


def clearance_of(view: View, type: str) -> ClearanceRule | None:
    """The clearance rule that judges, where one does."""
    return view.model.of_type(type).clearance if isinstance(view, RuleView) else None


def verdict_of(view: View, path: Any, type: str) -> Verdict:
    """Accepted, rejected, or not known: what nobody decided is never accepted."""
    if isinstance(view, JudgingView):
        return view.verdicts(path[None], type)[0]
    return "accept" if float(view.logits(path[None], type)[0]) > 0 else "reject"


def _open(explorer: Explorer, view: View, path: Any, type: str) -> dict[str, Any]:
    """Why nothing decides: the object that comes nearer than anything that was accepted."""
    rule = clearance_of(view, type)
    nothing = {"sentence": f"Not known: no answer of {type} decides about such a path.",
               "object": None, "symbol": None, "counterfactual": None}  # fmt: skip
    if rule is None or not isinstance(view, RuleView):
        return nothing
    clear_of, _ = thresholds(view, type)
    near: list[tuple[float, SceneObject]] = []
    for item in view.scene.listed_objects():
        gap = float(nearest_approach(
            replace(view.scene, objects=(item,), relations=()), path[None], (item.symbol,),
            distance=rule.distance,
        )[0, 0])  # fmt: skip
        if gap < clear_of.get(item.symbol, -np.inf):
            near.append((gap, item))
    if not near:
        return nothing
    gap, item = min(near, key=lambda entry: entry[0])
    place = path[int(np.argmin(item.outline.signed_distance(path)))]
    scale = explorer.scale_of(view.scene.scene_id)
    length = describe_length(max(gap, 0.0), scale, explorer.units)
    return {
        "sentence": f"Not known: no answer shows whether {type} accepts a path {length} from "
        f"{item.id}.",
        "object": item.id,
        "symbol": item.symbol,
        "place": [float(v) for v in place],
        "counterfactual": None,
    }


def _rings(explorer: Explorer, view: View, type: str) -> str:
    """What the rule keeps from each object, drawn; nothing for models without a rule."""
    rule = clearance_of(view, type)
    if rule is None or not isinstance(view, RuleView):
        return ""
    scale, units = explorer.scale_of(view.scene.scene_id), explorer.units
    clear_of, _ = thresholds(view, type)
    unknown = [s for s in clear_of if s not in rule.value]
    drawn = rings_svg(view.scene, rule, scale, units)
    return drawn + ring_words_svg(view.scene, rule, scale, units, unknown=unknown)


def _map_document(found: BendMap, *, sure: bool) -> dict[str, Any]:
    """The boundaries; with `sure` also the lines p = 0.1 and p = 0.9 of a model that doubts."""
    document: dict[str, Any] = {
        "type": found.accepted.type,
        "region": boundary_path(found.accepted),
        "open": None if found.possible is found.accepted else boundary_path(found.possible),
        "share": round(found.share, 4),
        "unknown": round(found.unknown, 4),
    }
    if sure:
        document["sure"] = [boundary_path(found.accepted, v, closed=False) for v in (-_SURE, _SURE)]
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
