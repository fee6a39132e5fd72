"""Does it know when it does not understand? Simulated people of many kinds (benchmarks/worlds.py).

    OMP_NUM_THREADS=1 python benchmarks/understanding.py [--sets 40] [--kinds "coin 50 %" speed]

For each kind: how often the fit says explains, partly, not; how often the right suspect comes
first; how often a 95 % interval holds the true clearance, and its width; and of plans in the first
two scenes of each set, how many are refused, keep the true rule, or break it. Outcomes are judged
by the generator, which shares no code with the learner. Rows of the kinds asked for replace
theirs in ``results/understanding.json``, so that it can be run in pieces.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import worlds

from demospec.errors import InputError
from demospec.planning import plan_path
from demospec.rules import RuleSet, learn_rules


def plan_keeps(kind: worlds.Kind, name: str, rules: RuleSet, world: worlds.World, data: Any,
               scene: int) -> str:  # fmt: skip
    """``refused``, ``kept``, ``broken`` or ``none`` (no way, or no truth to judge a path by)."""
    if not kind.truth and name != "must come near":
        judged = False
    else:
        judged = True
    try:
        plan = plan_path(rules, data.scenes[scene], "someone")
    except InputError as error:
        return "refused" if "explains" in error.expected else "none"
    if not plan.found or not judged:
        return "none" if judged else "unjudged"
    steps = np.linspace(0.0, 1.0, 400)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(plan.points, axis=0).T))])
    dense = np.stack(
        [np.interp(steps * length[-1], length, plan.points[:, axis]) for axis in (0, 1)], axis=1
    )
    gaps = {
        c: min(
            (np.linalg.norm(dense - (x, y), axis=1).min() - r
             for k, x, y, r in world.objects[scene] if k == c),
            default=np.inf,
        )
        for c in worlds.CLASSES
    }  # fmt: skip
    if name == "must come near":
        return "kept" if gaps["glass"] <= 8.0 else "broken"
    return "kept" if all(gaps[c] >= keep - 1e-3 for c, keep in kind.truth.items()) else "broken"


def study(name: str, sets: int) -> dict[str, Any]:
    """One kind of person."""
    kind = worlds.KINDS[name]
    verdicts: Counter[str] = Counter()
    plans: Counter[str] = Counter()
    first, held, wide, seconds = 0, [], [], 0.0
    stated = unasked = 0
    for seed in range(sets):
        rng = np.random.default_rng([seed, list(worlds.KINDS).index(name)])
        world = worlds.make_world(rng)
        data = worlds.as_set(world, kind.judge(world, rng), kind)
        began = time.process_time()
        rules = learn_rules(data, influence=False)
        seconds += time.process_time() - began
        found = rules.rules["someone"]
        assert found.fit is not None
        verdicts[found.fit.verdict] += 1
        suspects = found.fit.suspects
        named = [c.feature for c in found.constraints]
        first += bool(suspects) and suspects[0].feature == kind.suspect
        stated += {"side": "distance"}.get(str(kind.suspect), kind.suspect) in named
        unasked += bool(named) and kind.family != "out"
        clearance = found.clearance
        assert clearance is not None
        for symbol, keep in kind.truth.items():
            if symbol in clearance.interval:
                low, high = clearance.interval[symbol]
                held.append(low <= keep <= high)
                wide.append(high - low)
            else:
                held.append(False)
        for scene in (0, 1):
            plans[plan_keeps(kind, name, rules, world, data, scene)] += 1
    return {
        "kind": name,
        "sets": sets,
        "family": kind.family,
        **{v: verdicts[v] for v in ("explains", "partly", "not")},
        "suspect": kind.suspect,
        "suspect_first": first,
        "stated_as_constraint": stated,
        "constraint_unasked": unasked,
        "interval_holds": f"{sum(held)} of {len(held)}" if held else None,
        "width_px": round(float(np.median(wide)), 2) if wide else None,
        "plans": dict(plans),
        "seconds": round(seconds / sets, 3),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=40)
    parser.add_argument("--kinds", nargs="+", default=list(worlds.KINDS))
    args = parser.parse_args()
    out = Path(__file__).parent / "results" / "understanding.json"
    known = json.loads(out.read_text())["rows"] if out.exists() else []
    rows = {row["kind"]: row for row in known}
    for name in args.kinds:
        rows[name] = study(name, args.sets)
        print(json.dumps(rows[name]), flush=True)
        found = [rows[kind] for kind in worlds.KINDS if kind in rows]
        document = {"machine": platform.processor(), "rows": found}
        out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
