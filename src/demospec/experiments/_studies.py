"""Small studies that a run is made of. Outcomes are judged by the truth, never by the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet, ValidityModel, bezier_points
from demospec.errors import InputError
from demospec.planning import check_plan, plan_path
from demospec.progress import Progress, silent
from demospec.rules import RuleSet
from demospec.scene import Scene
from demospec.specification import RepairSettings, evaluate, repair

EXAMPLES = 6
"""Repairs of a type that are kept step by step, each in a scene of its own."""


def accuracy_study(
    models: Mapping[str, ValidityModel],
    sets: Mapping[str, DemonstrationSet],
    truth: RuleSet,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Scores of each model on each set, everywhere and further than 2 px from the boundary."""
    out: dict[str, Any] = {}
    count = 0
    for name, model in models.items():
        out[name] = {}
        for which, data in sets.items():
            progress("judging demonstrations", count, len(models) * len(sets))
            out[name][which] = evaluate(model, data, truth=truth).to_json()["types"]
            count += 1
    return out


def repair_study(
    model: ValidityModel,
    scenes: Sequence[Scene],
    truth: RuleSet,
    *,
    starts: int = 40,
    particles: int = 1,
    seed: int = 0,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Repairs random trajectories that the truth rejects; the truth judges the outcome.

    Scenes in which none of 400 random control points is valid are left out (there is nothing
    to find); a type without invalid starts is vacuous.

    Args:
        scenes: With their objects listed, for the truth.
        starts: Per type, spread evenly over the scenes (rounded up).

    Returns:
        Type → {n, vacuous, repaired_by_truth, accepted_by_model, moved_px, scenes_left_out,
        examples}; lengths in set units.
    """
    out: dict[str, Any] = {}
    # The paper stops where its model is content, and states no number.
    settings = RepairSettings(particles=particles, confidence=0.9)
    each = -(-starts // len(scenes))
    for t, type_ in enumerate(truth.types):
        rng = np.random.default_rng([seed, t])
        good: list[bool] = []
        believed: list[bool] = []
        moved: list[float] = []
        examples: list[dict[str, Any]] = []
        left_out = 0
        for i, scene in enumerate(scenes):
            progress("repairing trajectories", t * len(scenes) + i, len(truth.types) * len(scenes))
            judge = truth.see(scene)
            control = rng.uniform(0, scene.size_px or (100, 100), (400, 1, 2))
            paths = bezier_points(scene.start[:2], scene.goal[:2], control)
            valid = judge.p_valid(paths, type_) > 0.5
            if valid.all() or not valid.any():
                left_out += not valid.any()
                continue
            view = model.see(scene)
            first = control[~valid][:each]
            known = np.ones(len(first), dtype=bool)
            answer = repair(view, first, type_, settings=settings, known_invalid=known)
            done = judge.p_valid(answer.points, type_) > 0.5
            good += done.tolist()
            believed += (answer.p_valid > 0.5).tolist()
            moved += answer.moved.tolist()
            if len(examples) < EXAMPLES:
                trace = bezier_points(scene.start[:2], scene.goal[:2], answer.trace[0], 60)
                examples.append(
                    {
                        "scene": scene.scene_id,
                        "steps": np.round(trace, 2).tolist(),
                        "rule_valid": bool(done[0]),
                    }
                )
        out[type_] = {
            "n": len(good),
            "vacuous": not good,
            "repaired_by_truth": float(np.mean(good)) if good else None,
            "accepted_by_model": float(np.mean(believed)) if good else None,
            "moved_px": float(np.mean(moved)) if good else None,
            "scenes_left_out": left_out,
            "examples": examples,
        }
    return out


def plan_study(
    rules: RuleSet,
    scenes: Sequence[Scene],
    truth: RuleSet,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Plans in every scene for every type from the learned rules; the truth judges them."""
    plans: list[dict[str, Any]] = []
    for t, type_ in enumerate(rules.types):
        for i, scene in enumerate(scenes):
            progress("planning", t * len(scenes) + i, len(rules.types) * len(scenes))
            straight = float(np.hypot(*np.subtract(scene.goal[:2], scene.start[:2])))
            entry: dict[str, Any] = {"scene": scene.scene_id, "type": type_, "straight": straight}
            try:
                plan = plan_path(rules, scene, type_)
            except InputError as error:  # start or goal inside a zone: an outcome, not a failure
                plans.append({**entry, "status": "refused", "reason": str(error)})
                continue
            entry.update(plan.to_json())
            if plan.found:
                entry["true_obeys"] = check_plan(truth, scene, plan.points, type_).obeys
            plans.append(entry)
    return {"plans": plans}
