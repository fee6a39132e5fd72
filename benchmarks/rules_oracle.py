"""Every engine against brute force on random small problems: optima, ties, hull, count.

    python benchmarks/rules_oracle.py [problems] [first seed]

1 to 3 parameters, 1 or 2 scenes, 2-D and 3-D, every reading, penalty and weight, about one in
seven with labels that contradict. `direct` and `exact` (both its ways: swept, and searched)
take all of them, `step` those that separate (`sum`, `nearest`). The encodings say "not counted"
beyond 20,000 sets: that is noted, and not called a disagreement. `tests/rules` runs the same in
parts, marked slow.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from pathlib import Path

from rules_worlds import record

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "rules"))

from rules_oracle import answer_of
from rules_problems import random_problem

import demospec.rules.influence.engines._exact as exact
from demospec.rules import solve
from demospec.rules.influence.engines._cp_sat import ENUMERATED

SWEPT = exact.SWEEP_CELLS
COUNTS = ("n_feasible", "n_optima_min", "n_optima_max")


def answers(problem):
    """(engine, answer) of every engine that takes the problem."""
    exact.SWEEP_CELLS = SWEPT
    yield "exact, swept where small", solve(problem, "exact", listed=10**6)
    exact.SWEEP_CELLS = -1
    yield "exact, searched", solve(problem, "exact", listed=10**6)
    exact.SWEEP_CELLS = SWEPT
    yield "direct", solve(problem, "direct", listed=10**6)
    if problem.reading in ("sum", "nearest"):
        yield "step", solve(problem, "step", listed=10**6)


def main(problems: int, first: int) -> None:
    began = time.process_time()
    asked: dict[str, Counter[str]] = {}
    wrong: list[dict] = []
    uncounted: Counter[str] = Counter()
    infeasible = 0
    for done, seed in enumerate(range(first, first + problems), 1):
        problem = random_problem(seed)
        expected = answer_of(problem)
        infeasible += expected["status"] == "infeasible"
        for engine, answer in answers(problem):
            asked.setdefault(engine, Counter())[problem.reading] += 1
            for name, value in expected.items():
                got = getattr(answer, name)
                if got is None and name in COUNTS and value > ENUMERATED:
                    uncounted[engine] += 1
                    continue
                if (list(got) if isinstance(value, list) else got) != value:
                    wrong.append({"seed": seed, "engine": engine, "field": name})
        if done % 100 == 0 or done == problems:
            print(f"{done} problems, {len(wrong)} disagreements", flush=True)
            results = {
                "problems": done,
                "first_seed": first,
                "infeasible": infeasible,
                "asked": {e: {"all": sum(c.values()), **c} for e, c in asked.items()},
                "disagreements": wrong,
                "not_counted": dict(uncounted),
                "cpu_s": time.process_time() - began,
            }
            record("rules_oracle", f"python benchmarks/rules_oracle.py {problems} {first}", results)
    for engine, counts in asked.items():
        print(f"{engine}: {sum(counts.values())} problems, {dict(counts)}")


if __name__ == "__main__":
    main(
        int(sys.argv[1]) if len(sys.argv) > 1 else 2000,
        int(sys.argv[2]) if len(sys.argv) > 2 else 1000,
    )
