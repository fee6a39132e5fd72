"""What single commands wrote with --out, in the shape that the stages of a demo write."""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet

Documents = dict[str, dict[str, Any] | None]


def as_stages_write(found: Documents, data: DemonstrationSet) -> Documents:
    """One model's causes, one question, one evaluation, one plan, one list of repairs."""
    out = dict(found)
    causes, query, accuracy = (out[n] for n in ("causes", "query", "accuracy"))
    if causes is not None and "effects" in causes:
        out["causes"] = {"given": causes}
    if query is not None and "status" in query:
        out["query"] = {str(query.get("type") or "anyone"): query}
    if accuracy is not None and "types" in accuracy:
        out["accuracy"] = {"given": {"given": accuracy["types"]}}
    plan, repairs = out["plans"], out["repairs"]
    if plan is not None and "points" in plan:
        scene = data.scene(plan["scene_id"])
        straight = float(np.hypot(*np.subtract(scene.goal[:2], scene.start[:2])))
        out["plans"] = {"plans": [{**plan, "scene": scene.scene_id, "straight": straight}]}
    if repairs is not None and isinstance(repairs.get("repairs"), list):
        out["repairs"] = {"given": {"given": _repaired(repairs["repairs"], data)}}
    return out


def _repaired(repairs: list[dict[str, Any]], data: DemonstrationSet) -> dict[str, Any]:
    """The repairs by type, judged by the rules that the command was given, if any."""
    d = data.demonstrations
    type_of = {str(name): d.type[i] for i, name in enumerate(d.demo_id)}
    groups: dict[str, list[dict[str, Any]]] = {}
    for repair in repairs:
        groups.setdefault(str(type_of[repair["demo_id"]] or "anyone"), []).append(repair)
    out: dict[str, Any] = {}
    for type_, mine in groups.items():
        judged = [r["rule_valid"] for r in mine if r["rule_valid"] is not None]
        out[type_] = {
            "n": len(mine),
            "vacuous": False,
            "repaired_by_truth": float(np.mean(judged)) if len(judged) == len(mine) else None,
            "accepted_by_model": float(np.mean([r["p_valid"] > 0.5 for r in mine])),
            "moved_px": float(np.mean([r["moved"] for r in mine])),
            "examples": [],
        }
    return out


def clearance_words(clearance: dict[str, Any], units: str) -> str:
    """``3 px from every glass and plate``, for a rule that says nothing of itself."""
    by_distance: dict[float, list[str]] = {}
    for symbol in clearance.get("relevant", []):
        by_distance.setdefault(clearance["value"][symbol], []).append(symbol)
    parts = []
    for distance, names in by_distance.items():
        every = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
        parts.append(f"{distance:g} {units} from every {every}")
    return "; ".join(parts) or "clear of nothing"
