"""How well clearance rules are learnt from object lists on the simulated tabletop.

Balanced accuracy on unseen scenes with unseen items (100 fresh curves a scene, judged by the
true rule), error of the clearances, classes found, with detector noise, and CPU time. All
types of a set are answered together, as ``demospec rules SET`` does.

    OMP_NUM_THREADS=1 python benchmarks/clearance.py [--seeds 300 310]

Beside the noise stand two answers that are told what the data do not say, from the same
likelihood: the classes and the size of the noise (`told`), and also that careful and normal
keep the same clearance (`told_alike`). No honest answer can be expected to be better.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet, bezier_points, simulate_set
from demospec.rules import learn_rules, nearest_approach
from demospec.rules._measurement import encounters_of
from demospec.rules.clearance._likelihood import ClearancePrior
from demospec.rules.clearance._offsets import offset_labels
from demospec.rules.clearance._posterior import SPREAD
from demospec.scene import Scene

SYMBOLS = ("utensil", "plate", "bowl", "glass")
TRUTH = {"careful": dict.fromkeys(SYMBOLS, 3.0), "normal": {"glass": 3.0}}
BARS = {("careful", 1): 0.96, ("careful", 3): 0.99, ("careful", 9): 0.995,
        ("normal", 1): 0.97, ("normal", 3): 0.987, ("normal", 9): 0.995}  # fmt: skip
NOISE_BAR, NOISE_PX = 0.96, 2.0


def moved(scene: Scene, rng: np.random.Generator, sd: float) -> Scene:
    """Every object displaced by normal noise of `sd` px in each direction."""
    items = scene.listed_objects()
    return replace(scene, objects=tuple(o.moved(rng.normal(0, sd, 2)) for o in items))


@dataclass(frozen=True)
class World:
    """One simulated set.

    Args:
        exact: Its training scenes; `noisy` the same with object lists that are off.
        nth: (n,) how many demonstrations of the same scene and type came before.
        new: (m, K) nearest approaches of fresh curves in the test scenes.
    """

    exact: DemonstrationSet
    noisy: DemonstrationSet
    nth: Any
    new: Any


def make(seed: int) -> World:
    """A set with up to nine demonstrations a scene and type."""
    data, _ = simulate_set(seed=seed, demonstrations=9)
    rng = np.random.default_rng(seed + 1000)
    new, scenes = [], {}
    for scene in data.scenes:
        if scene.split == "test":
            control = rng.uniform(-20, 120, (100, 1, 2))
            paths: Any = bezier_points(scene.start, scene.goal, control, 100)
            new.append(nearest_approach(scene, paths, SYMBOLS))
        else:
            scenes[scene.scene_id] = moved(scene, rng, NOISE_PX)
    exact = data.of_split("train")
    noisy = replace(exact, scenes=tuple(scenes[s.scene_id] for s in exact.scenes))
    d = exact.demonstrations
    seen: dict[Any, int] = {}
    nth = []
    for key in zip(d.scene_id, d.type, strict=True):
        seen[key] = seen.get(key, -1) + 1
        nth.append(seen[key])
    return World(exact, noisy, np.array(nth), np.concatenate(new))


def accepts(near: Any, rule: dict[str, float]) -> Any:
    """(n,) verdicts of a clearance rule."""
    return (near >= np.array([rule.get(s, -np.inf) for s in SYMBOLS])).all(axis=1)


def balanced(said: Any, truth: Any) -> float:
    """Mean of the two recalls."""
    return float((said[truth].mean() + (~said[~truth]).mean()) / 2)


def told(data: DemonstrationSet, names: Sequence[str]) -> float:
    """The clearance by who knows the classes, the noise, and that these types keep the same."""
    c = np.linspace(0.0, 20.0, 401)[:-1] + 0.025
    weight = np.log(np.diff(ClearancePrior(0.0, 60.0, SPREAD).share(np.linspace(0.0, 20.0, 401))))
    for name in names:
        rows = np.flatnonzero(data.demonstrations.type == name)
        member = np.array([s in TRUTH[name] for s in SYMBOLS])
        valid = data.demonstrations.valid[rows] == 1
        seen = encounters_of(data, rows, SYMBOLS, "footprint", 1.0)
        weight = weight + offset_labels(seen, valid, member, c, NOISE_PX, (0.002,))[0]
    share = np.exp(weight - weight.max())
    return float(share @ c / share.sum())


def scores(world: World, n: int, noisy: bool) -> dict[str, dict[str, float]]:
    """One answer about all types, scored type by type."""
    data = (world.noisy if noisy else world.exact).select(world.nth < n)
    rules = learn_rules(data, influence=False)
    out = {}
    for name, truth in TRUTH.items():
        rule, verdict = rules.rules[name].clearance, accepts(world.new, truth)
        assert rule is not None
        ends = [rule.interval[s] for s in truth if s in rule.value]
        off = [abs(rule.value[s] - 3.0) for s in truth if s in rule.value]
        out[name] = {
            "balanced_accuracy": balanced(accepts(world.new, dict(rule.value)), verdict),
            "classes_right": float(set(rule.value) == set(truth)),
            "c_error": float(np.mean(off or [np.nan])),
            "covered": float(np.mean([a <= 3.0 <= b for a, b in ends] or [np.nan])),
        }
        if noisy:
            for label, names in (("told", [name]), ("told_alike", list(TRUTH))):
                at = dict.fromkeys(truth, told(data, names))
                out[name][label] = balanced(accepts(world.new, at), verdict)
    return out


def table(worlds: Sequence[World], noisy: bool) -> dict[str, dict[str, float]]:
    """Means over the worlds, by type and number of demonstrations per scene."""
    out = {}
    for n in (1, 3, 9):
        found = [scores(w, n, noisy) for w in worlds]
        for name in TRUTH:
            rows = [f[name] for f in found]
            mean = {k: round(float(np.nanmean([r[k] for r in rows])), 4) for k in rows[0]}
            accuracy = [r["balanced_accuracy"] for r in rows]
            mean["worst"] = round(min(accuracy), 4)
            mean["standard_error"] = round(float(np.std(accuracy)) / len(rows) ** 0.5, 4)
            mean["bar"] = NOISE_BAR if noisy else BARS[name, n]
            out[f"{name} {n}"] = mean
            print(f"{name:8} n={n}", "2 px noise" if noisy else "", mean, flush=True)
    return out


def main() -> None:
    """Run, print, and write ``results/clearance.json``."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, nargs=2, default=(300, 310))
    args = parser.parse_args()
    worlds = [make(seed) for seed in range(*args.seeds)]
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
