"""Speed of the influence engines: against the per-point encoding, at size, and on the grid.

    python benchmarks/rules_speed.py [--quick]

CPU seconds of one process. The ratio is CP-SAT's own solving time for both ends of L with the
per-point encoding (making the model not counted) over our whole answer: reading the points,
both optima, all ties, hull and count. `--quick` leaves `direct` out.
"""

from __future__ import annotations

import math
import resource
import statistics
import sys
import time

from rules_worlds import record, world

from demospec.rules import solve, threshold_grid
from demospec.rules.influence.engines.cp_sat._direct import encode_direct
from demospec.rules.influence.engines.cp_sat._encoding import both_ends

AGAINST = [(200, 20, 2, 1000), (300, 50, 3, 800)]
LIMITED = (500, 200, 5)
SIZES = [(500, 5000, 2, 1.0), (500, 2000, 5, 1.0), (300, 400, 8, 3.0), (500, 200, 5, 0.5)]


def seconds(call):
    began = time.process_time()
    result = call()
    return time.process_time() - began, result


def best(call, repeats=5):
    return min(seconds(call)[0] for _ in range(repeats))


def against(points, paths, objects, bar, size, seeds=3):
    rows = []
    for seed in range(seeds):
        problem = world(seed, points, paths, objects, size).problem
        ours = best(lambda problem=problem: solve(problem))
        answer = solve(problem)
        made, encoding = seconds(lambda problem=problem: encode_direct(problem))
        direct, ends = seconds(lambda e=encoding: both_ends(e, time.monotonic() + 300, 0))
        agree = ends[0] != "optimal" or (sum(ends[1]), sum(ends[2])) == (
            answer.L_min,
            answer.L_max,
        )
        rows.append(
            {"size": size, "seed": seed, "exact_s": ours, "direct_s": direct, "direct": ends[0],
             "encode_s": made, "ratio_with_encoding": (made + direct) / ours,
             "ratio": direct / ours, "agree": agree}
        )  # fmt: skip
        print(
            f"{points}×{paths}×{objects} in {size} px, seed {seed}: exact {ours * 1e3:.2f} ms, "
            f"direct {direct:.2f} s ({ends[0]}), {direct / ours:,.0f}× (bar {bar}×); "
            f"with making the model {(made + direct) / ours:,.0f}×",
            flush=True,
        )
    return rows


def main(quick: bool) -> None:
    solve(world(0, 20, 8, 2).problem)  # imports and first-touch costs
    out = {}
    # First, so that the peak of the process is its own.
    rows = []
    for seed in range(2):
        problem = world(seed, 200, 10_000, 12, 500).problem
        used, answer = seconds(lambda problem=problem: solve(problem, time_limit_s=300))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"200×10,000×12 in 500 px, seed {seed}: {used:.2f} s, peak {peak:.0f} MB, "
            f"{answer.status}",
            flush=True,
        )
        rows.append({"s": used, "peak_MB": peak, "status": answer.status})
    out["10000x12"] = rows
    for points, paths, objects, limit in SIZES:
        rows = []
        for size in (500, 150):
            for seed in range(3):
                for whole in (True, False):
                    problem = world(seed, points, paths, objects, size, whole=whole).problem
                    used, answer = seconds(lambda problem=problem: solve(problem))
                    rows.append({"size": size, "seed": seed, "whole": whole, "s": used,
                                 "status": answer.status})  # fmt: skip
        worst = max(row["s"] for row in rows)
        middle = statistics.median(row["s"] for row in rows)
        print(
            f"{points}×{paths}×{objects}: median {middle:.3f} s, worst {worst:.3f} s "
            f"(bar {limit} s), {sum(r['status'] == 'optimal' for r in rows)}/{len(rows)} optimal",
            flush=True,
        )
        out[f"{points}x{paths}x{objects}"] = {"bar_s": limit, "runs": rows}
    problem = world(0, 60, 40, 2, 150).problem
    used = best(lambda: threshold_grid(problem))
    print(f"grid 20×20×10: {used:.3f} s (bar 0.3 s)", flush=True)
    out["grid"] = {"s": used, "shape": list(threshold_grid(problem).least.shape), "bar_s": 0.3}
    if not quick:
        for points, paths, objects, bar in AGAINST:
            rows = [r for size in (500, 150) for r in against(points, paths, objects, bar, size)]
            middle = statistics.median(r["ratio"] for r in rows)
            print(f"  median {middle:,.0f}×, least {min(r['ratio'] for r in rows):,.0f}×")
            out[f"direct_{points}x{paths}x{objects}"] = {"bar": bar, "runs": rows}
        problem = world(1, *LIMITED, 150).problem
        ours = best(lambda: solve(problem), 2)
        used, ends = seconds(lambda: both_ends(encode_direct(problem), time.monotonic() + 60, 0))
        print(f"{LIMITED}: exact {ours:.3f} s; direct after {used:.0f} s: {ends[0]}")
        out["limited"] = {"exact_s": ours, "direct_s": used, "direct": ends[0]}
    assert all(math.isfinite(r["s"]) for r in out["10000x12"])
    record("rules_speed" + ("_quick" if quick else ""), "python benchmarks/rules_speed.py", out)


if __name__ == "__main__":
    main("--quick" in sys.argv)
