"""How well clearance rules are learnt from object lists on the simulated tabletop.

Balanced accuracy on unseen scenes with unseen items (100 fresh curves a scene, judged by the
true rule), error of the clearances, classes found, with detector noise, and CPU time.

    OMP_NUM_THREADS=1 python benchmarks/clearance.py [--seeds 300 310]
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import bezier_points, simulate_set
from demospec.rules import fit_clearance, learn_rules, nearest_approach
from demospec.scene import Scene

SYMBOLS = ("utensil", "plate", "bowl", "glass")
TRUTH = {"careful": dict.fromkeys(SYMBOLS, 3.0), "normal": {"glass": 3.0}}
BARS = {("careful", 1): 0.96, ("careful", 3): 0.99, ("careful", 9): 0.995,
        ("normal", 1): 0.97, ("normal", 3): 0.987, ("normal", 9): 0.995}  # fmt: skip


def moved(scene: Scene, rng: np.random.Generator, sd: float) -> Scene:
    """Every object displaced by normal noise of `sd` px in each direction."""
    items = scene.listed_objects()
    return replace(scene, objects=tuple(o.moved(rng.normal(0, sd, 2)) for o in items))


def distances(seed: int) -> dict[str, Any]:
    """Nearest approaches of one simulated set, true and with noisy object lists."""
    data, _ = simulate_set(seed=seed, demonstrations=9)
    rng = np.random.default_rng(seed + 1000)
    rows = data.rows_by_scene()
    parts: dict[str, list[Any]] = {k: [] for k in ("near", "noisy", "type", "valid", "nth", "new")}
    for scene in data.scenes:
        if scene.split == "test":
            control = rng.uniform(-20, 120, (100, 1, 2))
            paths: Any = bezier_points(scene.start, scene.goal, control, 100)
            parts["new"].append(nearest_approach(scene, paths, SYMBOLS))
            continue
        mine = rows[scene.scene_id]
        paths = data.demonstrations.paths_xy(mine)
        parts["near"].append(nearest_approach(scene, paths, SYMBOLS))
        parts["noisy"].append(nearest_approach(moved(scene, rng, 2.0), paths, SYMBOLS))
        names = data.demonstrations.type[mine]
        parts["type"].append(names)
        parts["valid"].append(data.demonstrations.valid[mine] == 1)
        parts["nth"].append([int((names[:i] == n).sum()) for i, n in enumerate(names)])
    return {k: np.concatenate(v) for k, v in parts.items()}


def accepts(near: Any, rule: dict[str, float]) -> Any:
    """(n,) verdicts of a clearance rule."""
    return (near >= np.array([rule.get(s, -np.inf) for s in SYMBOLS])).all(axis=1)


def balanced(said: Any, truth: Any) -> float:
    """Mean of the two recalls."""
    return float((said[truth].mean() + (~said[~truth]).mean()) / 2)


def one(world: dict[str, Any], name: str, n: int, noisy: bool) -> dict[str, float]:
    """One fit and its scores."""
    mine = (world["type"] == name) & (world["nth"] < n)
    near, valid = world["noisy" if noisy else "near"][mine], world["valid"][mine]
    fit = fit_clearance(near, valid, SYMBOLS)
    truth, value = TRUTH[name], dict(fit.rule.value)
    columns = [SYMBOLS.index(s) for s in truth]
    known = near[:, columns].min(axis=1)
    low, high = known[~valid].max(initial=0.0), known[valid].min(initial=50.0)
    verdict = accepts(world["new"], truth)
    ends = [fit.rule.interval[s] for s in truth if s in value]
    return {
        "balanced_accuracy": balanced(accepts(world["new"], value), verdict),
        "posterior_mean": balanced(fit.p_valid(world["new"]) > 0.5, verdict),
        "told_the_classes": balanced(
            accepts(world["new"], dict.fromkeys(truth, (low + high) / 2)), verdict
        ),
        "classes_right": float(set(value) == set(truth)),
        "c_error": float(np.mean([abs(value[s] - 3.0) for s in truth if s in value] or [np.nan])),
        "covered": float(np.mean([a <= 3.0 <= b for a, b in ends] or [np.nan])),
    }


def table(worlds: Sequence[dict[str, Any]], noisy: bool) -> dict[str, dict[str, float]]:
    """Means over the worlds, by type and number of demonstrations per scene."""
    out = {}
    for name in TRUTH:
        for n in (1, 3, 9):
            rows = [one(w, name, n, noisy) for w in worlds]
            mean = {k: round(float(np.nanmean([r[k] for r in rows])), 4) for k in rows[0]}
            mean["worst"] = round(min(r["balanced_accuracy"] for r in rows), 4)
            if not noisy:
                mean["bar"] = BARS[name, n]
            out[f"{name} {n}"] = mean
            print(f"{name:8} n={n}", "2 px noise" if noisy else "", mean, flush=True)
    return out


def main() -> None:
    """Run, print, and write ``results/clearance.json``."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, nargs=2, default=(300, 310))
    args = parser.parse_args()
    worlds = [distances(seed) for seed in range(*args.seeds)]
    result: dict[str, Any] = {
        "machine": platform.platform(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "command": "python " + " ".join(sys.argv),
        "seeds": f"{args.seeds[0]}..{args.seeds[1] - 1}",
        "exact_lists": table(worlds, noisy=False),
        "noisy_lists_2_px": table(worlds, noisy=True),
    }
    data, _ = simulate_set(seed=args.seeds[0], demonstrations=10, test_scenes=0)
    one_type = data.select(data.demonstrations.type == "careful")
    times = {}
    for label, some in (("three types, 20 x 10 each", data), ("one type, 20 x 10", one_type)):
        learn_rules(some, influence=False)
        laps = []
        for _ in range(5):
            began = time.process_time()
            learn_rules(some, influence=False)
            laps.append(time.process_time() - began)
        times[label] = round(float(np.median(laps)), 4)
    scene = data.scenes[0]
    control = np.random.default_rng(0).uniform(-20, 120, (20_000, 1, 2))
    paths = bezier_points(scene.start, scene.goal, control, 100)
    began = time.process_time()
    nearest_approach(scene, paths, SYMBOLS)
    times["judging 100,000 paths of 100 points (from 20,000)"] = round(
        5 * (time.process_time() - began), 2
    )
    result["cpu_s"] = times
    print(times)
    out = Path(__file__).parent / "results" / "clearance.json"
    out.parent.mkdir(exist_ok=True)
    out.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
