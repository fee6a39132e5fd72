"""Robots that carry plans out in unseen scenes: tracking error, contacts, and the rule kept.

    python benchmarks/execution.py                 # 60 tabletop and 20 workbench scenes
    python benchmarks/execution.py --scenes 6      # a quick look

Rules are learned from 20 training scenes; plans are made from their upper corner with 0.5 px
(4 mm) to spare for the tracking error; the executed path is judged by the true rule.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.execution import Rollout, execute_plan  # noqa: E402
from demospec.planning import plan_path  # noqa: E402
from demospec.rules import learn_rules, rules_from_document  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "execution.json"


def row(rollouts: list[Rollout], seconds: float) -> dict[str, Any]:
    """One line of the table."""
    done = [r for r in rollouts if r.status == "done"]
    clearances = [min(r.clearance_m.values()) for r in done if r.clearance_m]
    return {
        "scenes": len(rollouts),
        "no_plan": sum(r.status == "no plan" for r in rollouts),
        "unreachable": {r.scene_id: r.reason for r in rollouts if r.status == "unreachable"},
        "executed": len(done),
        "goal_reached": sum(r.reached for r in done),
        "keeps_true_rule": sum(r.keeps_rule for r in done),
        "with_contact": {r.scene_id: [c.to_json() for c in r.contacts] for r in done if r.contacts},
        "tracking_rms_mm_median": 1000 * float(np.median([r.motion.rms_m for r in done])),
        "tracking_rms_mm_worst": 1000 * float(max(r.motion.rms_m for r in done)),
        "tracking_largest_mm": 1000 * float(max(r.motion.error_m.max() for r in done)),
        "least_3d_clearance_mm": 1000 * float(min(clearances)),
        "cpu_seconds_a_scene": seconds / len(rollouts),
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=11)
    chosen = parser.parse_args()
    results: dict[str, Any] = {}
    for task, carried, scenes in (
        ("tabletop", "shaker", chosen.scenes),
        ("workbench", "drill", max(2, chosen.scenes // 3)),
    ):
        data, document = simulate_set(task=task, test_scenes=scenes, seed=chosen.seed)
        truth = replace(rules_from_document(document), metres_per_unit=data.metres_per_unit)
        learned = replace(learn_rules(data), metres_per_unit=data.metres_per_unit)
        plans = [
            (scene, plan_path(learned, scene, "careful", allowance=0.5))
            for scene in data.of_split("test").scenes
        ]
        for robot in ("pr2", "panda"):
            began = time.process_time()
            rollouts = [
                execute_plan(plan, scene, truth, robot=robot, carried=carried)
                for scene, plan in plans
            ]
            results[f"{task}, {robot}"] = row(rollouts, time.process_time() - began)
            print(f"{task}, {robot}, {carried}:")
            print(json.dumps(results[f"{task}, {robot}"], indent=1), flush=True)
    RESULTS.parent.mkdir(exist_ok=True)
    about = {
        "command": "python benchmarks/execution.py " + " ".join(sys.argv[1:]),
        "seed": chosen.seed,
        "python": platform.python_version(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}",
        "versions": {n: version(n) for n in ("numpy", "mujoco", "mink", "example-robot-data")},
    }
    RESULTS.write_text(json.dumps({**about, "runs": results}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
