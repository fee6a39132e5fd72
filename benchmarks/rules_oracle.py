"""Every engine against brute force on small problems: optima, ties, hull, count.

    python benchmarks/rules_oracle.py [problems] [first seed]
    python benchmarks/rules_oracle.py --adaptive [problems] [first seed]

1 to 3 parameters, 1 or 2 scenes, 2-D and 3-D, every reading, penalty and weight, about one in
seven with labels that contradict. `direct` and `exact` (both its ways: swept, and searched)
take all of them, `step` those that separate (`sum`, `nearest`). The encodings say "not counted"
beyond 20,000 sets: that is noted, and not called a disagreement. `tests/rules` runs the same in
parts, marked slow.

`--adaptive`: sequences of paths that drive the exact engine into its special cases (each next
path halves what is left; rows that become constant; contact alone; F_max at a reachable sum),
with how often each case and each way of the engine was reached.
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

from demospec.rules import solve
from demospec.rules.influence import ENUMERATED, Effort

SEARCHED = Effort(sweep_cells=-1)
COUNTS = ("n_feasible", "n_optima_min", "n_optima_max")


def answers(problem):
    """(engine, answer) of every engine that takes the problem."""
    yield "exact, swept where small", solve(problem, "exact", listed=10**6)
    yield "exact, searched", solve(problem, "exact", listed=10**6, effort=SEARCHED)
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


def adaptive(problems: int, first: int) -> None:
    from rules_adaptive import CORNERS, adaptive_problem, corners
    from test_influence_adaptive import WAYS, check

    began = time.process_time()
    reached: Counter[str] = Counter()
    wrong: list[dict] = []
    for seed in range(first, first + problems):
        case = adaptive_problem(seed)
        ways: set[str] = set()
        try:
            check(seed, case, ways)
        except Exception as error:  # a wrong answer, or none
            wrong.append({"seed": seed, "error": f"{type(error).__name__}: {error}"[:300]})
            print(wrong[-1], flush=True)
        reached.update(ways | set(corners(case)))
        if (seed - first) % 1000 == 999:
            print(f"{seed - first + 1} problems, {len(wrong)} wrong", flush=True)
    rare = sorted(set(reached) - {*CORNERS, *WAYS})
    counts = {name: reached[name] for name in (*CORNERS, *WAYS, *rare)}
    for name, count in counts.items():
        print(f"{count:6} {name}")
    results = {
        "problems": problems,
        "first_seed": first,
        "wrong": wrong,
        "reached": counts,
        "cpu_s": time.process_time() - began,
    }
    command = f"python benchmarks/rules_oracle.py --adaptive {problems} {first}"
    record("rules_adaptive", command, results)


if __name__ == "__main__":
    numbers = [int(a) for a in sys.argv[1:] if not a.startswith("--")]
    if "--adaptive" in sys.argv:
        adaptive(*[*numbers, *(20_000, 10_000)[len(numbers) :]][:2])
    else:
        main(*[*numbers, *(2000, 1000)[len(numbers) :]][:2])
