"""Is the truth where the answer says? Simulated worlds, matching rule, with and without noise.

    python benchmarks/rules_coverage.py [worlds]

`hull`: T_min and every radius of the truth lie in the hull. `L`: so does T_min + Σ T_object.
`printed pairs`: every parameter lies between its value at the least and at the greatest L, as
the paper's table prints them (T_min and the T_object; or T_min and the radii).
Wrong labels: `solve(problem, tolerant=True)` with its own label noise of 5 %. Its rule for the
number of contradictions (`slack_of`) was chosen on other seeds (500,000 and 700,000 onwards).
"""

from __future__ import annotations

import statistics
import sys
import time

from rules_worlds import record, world

from demospec.rules import solve


def between(value, a, b):
    return min(a, b) <= value <= max(a, b)


def clean(worlds):
    counts = dict.fromkeys(("hull", "L", "pairs_T_object", "pairs_radius"), 0)
    kinds = [(40, 20, 2, 100), (40, 40, 2, 100), (60, 30, 3, 150), (60, 60, 5, 200)]
    for seed in range(worlds):
        points, paths, objects, size = kinds[seed % len(kinds)]
        w = world(seed, points, paths, objects, size)
        answer = solve(w.problem, listed=1)
        radii = [w.T_min + t for t in w.T_object]
        counts["hull"] += between(w.T_min, *answer.hull_T_min) and all(
            between(r, *pair) for r, pair in zip(radii, answer.hull_radius, strict=True)
        )
        counts["L"] += answer.L_min <= w.L <= answer.L_max
        at_min, at_max = answer.min, answer.max
        T_in = between(w.T_min, at_min[0], at_max[0])
        counts["pairs_T_object"] += T_in and all(
            between(t, a, b) for t, a, b in zip(w.T_object, at_min[1:], at_max[1:], strict=True)
        )
        counts["pairs_radius"] += T_in and all(
            between(r, a + at_min[0], b + at_max[0])
            for r, a, b in zip(radii, at_min[1:], at_max[1:], strict=True)
        )
    return {name: count / worlds for name, count in counts.items()}


def noisy(worlds, paths, objects, size):
    covered = narrow = contradicting = cores = cores_right = fewer = 0
    widths, narrow_widths = [], []
    for seed in range(worlds):
        w = world(10_000 + seed, 40, paths, objects, size, noise=0.05)
        strict = solve(w.problem, listed=1)
        if strict.status == "infeasible":
            cores += 1
            cores_right += bool(set(strict.conflict) & w.flipped)
        answer = solve(w.problem, tolerant=True, listed=1)
        covered += answer.L_min <= w.L <= answer.L_max
        widths.append(answer.L_max - answer.L_min)
        best = answer.fewest
        narrow += best.L_min <= w.L <= best.L_max
        narrow_widths.append(best.L_max - best.L_min)
        wrong = answer.contradicted or ()
        contradicting += len(wrong)
        fewer += len(wrong) < len(w.flipped)
    return {
        "paths": paths,
        "objects": objects,
        "worlds": worlds,
        "L_covered": covered / worlds,
        "median_width_of_L": statistics.median(widths),
        "L_covered_by_fewest_contradictions_alone": narrow / worlds,
        "their_median_width_of_L": statistics.median(narrow_widths),
        "conflicts": cores,
        "conflicts_with_a_wrong_label": cores_right,
        "mean_contradicted": contradicting / worlds,
        "fits_that_contradict_fewer_than_were_wrong": fewer / worlds,
    }


def main(worlds: int) -> None:
    began = time.process_time()
    out = {"worlds": worlds, "clean": clean(worlds), "noisy": []}
    for name, share in out["clean"].items():
        print(f"{name:16s} {100 * share:6.1f} %   ({worlds} worlds)")
    for paths, objects, size in ((20, 2, 100), (40, 2, 100), (100, 2, 100), (40, 3, 150)):
        row = noisy(worlds, paths, objects, size)
        out["noisy"].append(row)
        print(
            f"5 % wrong labels, {paths} paths, {objects} objects: L covered "
            f"{100 * row['L_covered']:.1f} % (bar 95; fewest contradictions alone "
            f"{100 * row['L_covered_by_fewest_contradictions_alone']:.1f} %), median width "
            f"{row['median_width_of_L']:g} ({row['their_median_width_of_L']:g}), "
            f"conflicts with a wrong label "
            f"{row['conflicts_with_a_wrong_label']}/{row['conflicts']}",
            flush=True,
        )
    out["cpu_s"] = time.process_time() - began
    record("rules_coverage", f"python benchmarks/rules_coverage.py {worlds}", out)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 400)
