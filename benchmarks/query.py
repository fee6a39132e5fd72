"""How many questions it takes to learn an influence rule by asking.

Simulated teachers with a known rule answer until at most `TARGET` parameter sets are left (two
objects, from 10^6), or for a fixed number of questions (five objects; teachers who err).

    python benchmarks/query.py [--worlds 20]
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from demospec.demonstrations import bezier_points
from demospec.rules import (
    Bounds,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    evaluate_rule,
    next_query,
)
from demospec.rules.active._candidates import paths_as_steps, verdicts, weighed_sets

TARGET = 1000


def world(rng: np.random.Generator, objects: int) -> tuple[RuleProblem, int, dict[str, int]]:
    """An empty problem with random objects on a 200 × 200 table, and a hidden truth."""
    centers = rng.uniform(40, 160, (objects, 2)).round(1)
    items = tuple(RuleObject(f"o{k}", f"o{k}", tuple(c)) for k, c in enumerate(centers.tolist()))
    problem = RuleProblem((RuleScene(items),), (), F_max=60, bounds=Bounds((1, 100), (1, 100)))
    truth = {f"o{k}": int(rng.integers(1, 101)) for k in range(objects)}
    return problem, int(rng.integers(1, 101)), truth


def answered(problem, query, T_min, truth, rng, errs):
    """The problem with the teacher's answer to one question."""
    path = RuleTrajectory(query.scene, True, query.points)
    (verdict,) = evaluate_rule(replace(problem, trajectories=(path,)), T_min, truth)
    label = verdict.valid != (rng.random() < errs)
    shown = RuleTrajectory(query.scene, bool(label), query.points)
    return replace(problem, trajectories=(*problem.trajectories, shown))


def questions_until(seed: int, random: bool, most: int) -> tuple[int, float]:
    """(questions, mean CPU seconds each) until at most `TARGET` sets are left; most + 1 if not."""
    rng = np.random.default_rng(seed)
    problem, T_min, truth = world(rng, 2)
    began = time.process_time()
    for asked in range(1, most + 1):
        query = next_query(problem, seed=seed * 1000 + asked, random=random)
        if query.status == "settled":
            if not random:
                return asked - 1, (time.process_time() - began) / asked
            continue
        problem = answered(problem, query, T_min, truth, rng, 0.0)
        label = problem.trajectories[-1].valid
        if (query.if_valid if label else query.if_invalid) <= TARGET:
            return asked, (time.process_time() - began) / asked
    return most + 1, (time.process_time() - began) / most


def random_demonstrations(seed: int, most: int) -> int:
    """Demonstrations as people give them unasked, until at most `TARGET` sets are left.

    Order-2 curves across the table between random places on its rim, 60 points each.
    """
    rng = np.random.default_rng(seed)
    problem, T_min, truth = world(rng, 2)
    left = weighed_sets(problem, 0.0, seed).sets
    for asked in range(1, most + 1):
        turn = rng.uniform(0, 2 * np.pi, 2)
        ends = 100 + 140 * np.column_stack([np.cos(turn), np.sin(turn)])
        points = bezier_points(ends[0], ends[1], rng.uniform(-40, 240, (1, 2)), 60).round(1)
        steps, ((block, row),) = paths_as_steps(problem, [(0, points)])
        truly = verdicts(steps, block, row, np.array([[T_min, truth["o0"], truth["o1"]]]))[0]
        left = left[verdicts(steps, block, row, left) == truly]
        if len(left) <= TARGET:
            return asked
    return most + 1


def five_objects(seed: int, questions: int, random: bool) -> tuple[float, float]:
    """Bits learnt and mean CPU seconds a question (estimates: sampled sets)."""
    rng = np.random.default_rng(seed)
    problem, T_min, truth = world(rng, 5)
    bits, began = 0.0, time.process_time()
    for asked in range(1, questions + 1):
        query = next_query(problem, seed=seed * 1000 + asked, random=random, error_rate=0.01)
        if query.status == "settled":
            continue
        problem = answered(problem, query, T_min, truth, rng, 0.0)
        p = query.p_valid if problem.trajectories[-1].valid else 1 - query.p_valid
        bits -= np.log2(max(p, 1e-6))
    return bits, (time.process_time() - began) / questions


def erring_teacher(seed: int, questions: int) -> tuple[float, float, float]:
    """A teacher who errs in 5 %: posterior mass near the truth, agreement of verdicts."""
    rng = np.random.default_rng(seed)
    problem, T_min, truth = world(rng, 2)
    problem = replace(problem, bounds=Bounds((1, 60), (1, 60)))
    T_min, truth = min(T_min, 60), {k: min(v, 60) for k, v in truth.items()}
    for asked in range(1, questions + 1):
        query = next_query(problem, seed=seed * 1000 + asked, error_rate=0.05)
        if query.status == "settled":
            break
        problem = answered(problem, query, T_min, truth, rng, 0.05)
    left = weighed_sets(problem, 0.05, seed)
    radii = np.column_stack([left.sets[:, 0], left.sets[:, :1] + left.sets[:, 1:]])
    true = np.array([T_min, *[T_min + truth[f"o{k}"] for k in range(2)]])
    near = (np.abs(radii - true) <= 5).all(axis=1)
    best = radii[left.weight.argmax()]
    return float(left.weight[near].sum()), float(np.abs(best - true).mean()), float(left.total or 0)


def main() -> None:
    """Run, print, and write ``results/query.json``."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--worlds", type=int, default=20)
    parser.add_argument("--random-most", type=int, default=200)
    args = parser.parse_args()
    seeds = range(args.worlds)
    asked = [questions_until(s, False, 60) for s in seeds]
    print("two objects, questions to <= 1000 of 10^6:", [a for a, _ in asked], flush=True)
    chance = [questions_until(s, True, args.random_most) for s in seeds]
    unasked = [random_demonstrations(s, 2000) for s in seeds]
    print("random demonstrations:", unasked, flush=True)
    print("random probes:", [a for a, _ in chance], flush=True)
    erring = [erring_teacher(s, 30) for s in range(max(args.worlds // 2, 1))]
    five = [five_objects(s, 20, False) for s in range(max(args.worlds // 4, 1))]
    five_random = [five_objects(s, 20, True) for s in range(max(args.worlds // 4, 1))]
    result = {
        "machine": platform.platform(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "command": "python " + " ".join(sys.argv),
        "seeds": f"0..{args.worlds - 1}",
        "two_objects": {
            "questions": [a for a, _ in asked],
            "median": float(np.median([a for a, _ in asked])),
            "cpu_s_per_question": float(np.mean([t for _, t in asked])),
            "random_demonstrations": unasked,
            "random_demonstrations_median": float(np.median(unasked)),
            "ratio_of_medians": float(np.median(unasked) / np.median([a for a, _ in asked])),
            "random_probes": [a for a, _ in chance],
            "random_probes_median": float(np.median([a for a, _ in chance])),
            "random_probes_stopped_at": args.random_most,
        },
        "teacher_errs_5_percent_30_questions": {
            "posterior_mass_within_5_of_truth": [round(m, 3) for m, _, _ in erring],
            "mean_error_of_best": [round(e, 2) for _, e, _ in erring],
        },
        "five_objects_20_questions": {
            "bits": [round(b, 2) for b, _ in five],
            "bits_random": [round(b, 2) for b, _ in five_random],
            "cpu_s_per_question": float(np.mean([t for _, t in five])),
        },
    }
    print(json.dumps(result, indent=1))
    out = Path(__file__).parent / "results" / "query.json"
    out.parent.mkdir(exist_ok=True)
    out.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
