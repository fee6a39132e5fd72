"""How often the interval of a clearance holds the truth, where object lists are off or are not.

Simulated tabletop, ``careful`` and ``normal`` answered together, lists with normal errors of 0, 1
and 2 px in both directions; 95 % is meant. A run is one type of one set; its share is that of its
classes that were found. Beside it the mean width (an open end counted as 30 px), how often the
ends are those of exact lists, and balanced accuracy on unseen scenes.

    OMP_NUM_THREADS=1 python benchmarks/clearance_coverage.py [--seeds 400 500]
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from clearance import TRUTH, World, accepts, balanced, make, moved

from demospec.demonstrations import DemonstrationSet
from demospec.rules import learn_rules

OPEN_PX = 30.0


def lists(world: World, seed: int) -> dict[str, DemonstrationSet]:
    """The training set with object lists of each quality."""
    rng = np.random.default_rng(seed + 5000)
    one = tuple(moved(scene, rng, 1.0) for scene in world.exact.scenes)
    return {
        "0 px": world.exact,
        "1 px": replace(world.exact, scenes=one),
        "2 px": world.noisy,
    }


def scores(world: World, data: DemonstrationSet) -> dict[str, dict[str, float]]:
    """One answer about all types, scored type by type."""
    rules = learn_rules(data, influence=False)
    out = {}
    for name, truth in TRUTH.items():
        found = rules.rules[name]
        rule = found.clearance
        assert rule is not None
        ends = [rule.interval[s] for s in truth if s in rule.value]
        verdict = accepts(world.new, truth)
        out[name] = {
            "covered": float(np.mean([a <= 3.0 <= b for a, b in ends] or [np.nan])),
            "width": float(np.mean([min(b, OPEN_PX) - a for a, b in ends] or [np.nan])),
            "exact_ends": float(found.evidence["interval"] == "exact"),
            "balanced_accuracy": balanced(accepts(world.new, dict(rule.value)), verdict),
        }
    return out


def main() -> None:
    """Run, print, and write ``results/clearance_coverage.json``."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, nargs=2, default=(400, 500))
    args = parser.parse_args()
    found: dict[str, list[dict[str, float]]] = {}
    for seed in range(*args.seeds):
        world = make(seed)
        for noise, data in lists(world, seed).items():
            for n in (1, 3, 9):
                for name, row in scores(world, data.select(world.nth < n)).items():
                    found.setdefault(f"{noise}, n = {n}, {name}", []).append(row)
    table: dict[str, Any] = {}
    for key, rows in found.items():
        table[key] = {k: round(float(np.nanmean([r[k] for r in rows])), 4) for k in rows[0]}
        table[key]["runs"] = len(rows)
        print(key, table[key])
    result = {
        "machine": platform.platform(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "command": "python " + " ".join(sys.argv),
        "seeds": f"{args.seeds[0]}..{args.seeds[1] - 1}",
        "table": table,
    }
    out = Path(__file__).parent / "results" / "clearance_coverage.json"
    out.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
