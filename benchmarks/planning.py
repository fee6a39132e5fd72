"""Obedience against length: what plans in unseen scenes cost, and whether they keep the true rule.

    python benchmarks/planning.py                  # 120 unseen scenes (about four minutes)
    python benchmarks/planning.py --scenes 20      # a quick look
    python benchmarks/planning.py --seed 7         # another world

Rules are learned from 20 training scenes × 10 demonstrations per type. Every plan is judged by
the demonstrator's true rule on the dense curve with exact footprints, never by the rule that it
was made with. Lengths are relative to the plan made with the true parameters by the same grid
planner. Times are CPU times of one process and one thread.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.errors import InputError  # noqa: E402
from demospec.planning import Plan, check_plan, plan_path  # noqa: E402
from demospec.rules import (  # noqa: E402
    ClearanceRule,
    RuleSet,
    TypeRules,
    learn_rules,
    rules_from_document,
)
from demospec.scene import Scene  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "planning.json"
OMPL = ("rrtstar", "bitstar", "informed-rrtstar")
OMPL_SECONDS = 0.25


def planners(learned: RuleSet, type: str, symbols: tuple[str, ...]) -> dict[str, Any]:
    """Name → function from a scene to a plan, or to points."""

    def grid(rules: RuleSet, envelope: str) -> Callable[[Scene], Plan]:
        return lambda scene: plan_path(rules, scene, type, envelope)  # type: ignore[arg-type]

    rule = learned.of_type(type)
    influence = RuleSet({type: TypeRules(influence=rule.influence)})
    methods: dict[str, Any] = {
        "straight line": lambda scene: np.array([scene.start, scene.goal]),
        "clearance, upper corner (default)": grid(learned, "upper"),
        "clearance, point answer": grid(learned, "value"),
        "clearance, lower corner": grid(learned, "lower"),
        "influence, max-L (paper)": grid(influence, "max"),
        "influence, min-L (paper)": grid(influence, "min"),
        "influence, hull's upper corner": grid(influence, "upper"),
    }
    for radius in (1.0, 3.0, 6.0, 10.0):
        one = RuleSet({type: TypeRules(ClearanceRule(dict.fromkeys(symbols, radius)))})
        methods[f"one inflation radius, {radius:g} px"] = grid(one, "value")
    methods["latent (order-2 Bézier), upper"] = lambda scene: plan_path(
        learned, scene, type, planner="latent"
    )
    for name in OMPL:
        methods[f"OMPL {name}, {OMPL_SECONDS} s, upper"] = lambda scene, name=name: plan_path(
            learned, scene, type, planner=name, seed=1, time_limit_s=OMPL_SECONDS
        )
    return methods


def study(method: Any, scenes: list[Scene], truth: RuleSet, type: str, best: list[float]) -> Any:
    """One row of the table."""
    obeys, ratios, detours, seconds, refused = 0, [], [], [], 0
    for scene, shortest in zip(scenes, best, strict=True):
        began = time.process_time()
        try:
            plan = method(scene)
        except InputError:
            refused += 1
            continue
        finally:
            seconds.append(time.process_time() - began)
        points = plan.points if isinstance(plan, Plan) else plan
        if len(points) == 0:
            continue
        exact = check_plan(truth, scene, points, type).obeys
        sampled = bool(truth.see(scene).p_valid([points], type)[0] > 0.5)
        obeys += exact and sampled
        if np.isfinite(shortest):
            ratios.append(float(np.hypot(*np.diff(points, axis=0).T).sum()) / shortest)
            if not check_plan(truth, scene, [scene.start[:2], scene.goal[:2]], type).obeys:
                detours.append(ratios[-1])
    return {
        "scenes": len(scenes),
        "planned": len(ratios),
        "end_in_forbidden_region": refused,
        "obeys_truth": obeys,
        "obeys_share_of_planned": obeys / max(1, len(ratios)),
        "length_ratio_median": float(np.median(ratios)) if ratios else None,
        "length_ratio_95": float(np.percentile(ratios, 95)) if ratios else None,
        "detours": len(detours),
        "length_ratio_median_of_detours": float(np.median(detours)) if detours else None,
        "ms_median": 1000 * float(np.median(seconds)),
        "ms_95": 1000 * float(np.percentile(seconds, 95)),
    }


def timing(size_px: int, seed: int, scenes: int) -> dict[str, float]:
    """Milliseconds a plan with the true rule on maps of that size."""
    data, document = simulate_set(
        train_scenes=1, test_scenes=scenes, demonstrations=1, size_px=size_px, seed=seed
    )
    truth = rules_from_document(document)
    plan_path(truth, data.scenes[0], "careful")
    seconds = []
    for scene in data.scenes:
        began = time.process_time()
        plan_path(truth, scene, "careful")
        seconds.append(time.process_time() - began)
    return {
        "median": 1000 * float(np.median(seconds)),
        "95": 1000 * float(np.percentile(seconds, 95)),
        "max": 1000 * float(np.max(seconds)),
        "scenes": float(len(seconds)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=120)
    parser.add_argument("--seed", type=int, default=3)
    chosen = parser.parse_args()
    data, document = simulate_set(test_scenes=chosen.scenes, seed=chosen.seed)
    learned = learn_rules(data)
    truth = replace(rules_from_document(document), metres_per_unit=data.metres_per_unit)
    scenes = list(data.of_split("test").scenes)
    plan_path(truth, scenes[0], "careful")  # imports are not part of a plan's time
    results: dict[str, Any] = {}
    for type in ("careful", "normal"):
        best = []
        for scene in scenes:
            try:
                best.append(plan_path(truth, scene, type).length)
            except InputError:
                best.append(float("nan"))
        print(f"\n{type}: {len(scenes)} unseen scenes, "
              f"{int(np.isfinite(best).sum())} with a plan under the true rule")  # fmt: skip
        heads = [("", 40), ("planned", 8), ("keeps truth", 12), ("length", 9), ("detours", 9)]
        heads += [("95 %", 7), ("ms", 8), ("95 %", 8)]
        print("".join(f"{name:>{width}}" for name, width in heads))
        rows = {}
        for name, method in planners(learned, type, data.symbols).items():
            row = study(method, scenes, truth, type, best)
            rows[name] = row
            length = row["length_ratio_median"] or float("nan")
            around = row["length_ratio_median_of_detours"] or float("nan")
            print(
                f"{name:40}{row['planned']:8d}{row['obeys_share_of_planned']:12.1%}"
                f"{length:9.4f}{around:9.4f}{row['length_ratio_95'] or 0:7.3f}"
                f"{row['ms_median']:8.1f}{row['ms_95']:8.1f}",
                flush=True,
            )
        results[type] = rows
    times = {f"{n}x{n}": timing(n, chosen.seed + 1, min(30, chosen.scenes)) for n in (100, 600)}
    print("\nmilliseconds a plan with the true rule (CPU):", json.dumps(times))
    RESULTS.parent.mkdir(exist_ok=True)
    about = {
        "command": "python benchmarks/planning.py " + " ".join(sys.argv[1:]),
        "seed": chosen.seed,
        "python": platform.python_version(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}",
        "versions": {n: version(n) for n in ("numpy", "scikit-image", "ompl", "demospec")},
    }
    document_out = {**about, "types": results, "ms_per_plan": times}
    RESULTS.write_text(json.dumps(document_out, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
