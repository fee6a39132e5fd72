"""Influence rules as a mixed-integer linear program (HiGHS, through scipy): a peer.

    python benchmarks/milp.py

The encoding shares no code with our engines: points are measured here. Whole variables T_min
and T_object-k; binaries b[k, v] = (T_min + T_object-k >= v) for every level v at which object k
takes a point in, and a[m] = (T_min >= m) for the closest level m of every rejected path; one
pseudo-Boolean row for each trajectory. Both ends of L must be those of `solve`.
"""

from __future__ import annotations

import time
from math import isqrt
from typing import Any

import numpy as np
from rules_worlds import record, world
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from demospec.rules import RuleProblem, solve

SIZES = [(100, 10, 2, 300), (200, 20, 2, 1000), (300, 50, 3, 800)]


class Program:
    """The constraints; ask it for either end of L."""

    def __init__(self, problem: RuleProblem) -> None:
        (scene,) = problem.scenes
        K = len(scene.objects)
        low, high = problem.bounds.T_min
        object_low, object_high = problem.bounds.T_object
        reach = problem.bounds.radius[1]
        limit = problem.scale * int(problem.F_max or 0)
        self.K = K
        self.lower = [float(low)] + [float(object_low)] * K
        self.upper = [float(high)] + [float(object_high)] * K
        self.rows: list[dict[int, float]] = []
        self.at_least: list[float] = []
        self.at_most: list[float] = []
        steps: dict[tuple[int, int], int] = {}
        closer: dict[int, int] = {}
        for path in problem.trajectories:
            row: dict[int, float] = {}
            nearest = reach + 1
            for k, item in enumerate(scene.objects):
                squares = ((path.points[:, :2] - item.center[:2]) ** 2).sum(axis=1)
                for square in np.rint(squares).astype(int).tolist():
                    root = isqrt(square)
                    level = max(root + (root * root < square), problem.bounds.radius[0])
                    nearest = min(nearest, root + (root * root < square))
                    if level > reach:
                        continue
                    penalty = (isqrt(4 * problem.scale**2 * square) + 1) // 2
                    b = self._step(steps, k, level)
                    row[b] = row.get(b, 0.0) + penalty
            if path.valid:
                self._row(row, -np.inf, limit - 1)
                if nearest <= high:
                    self.upper[0] = min(self.upper[0], nearest - 1)
            elif nearest <= high:
                a = self._closer(closer, nearest)
                self._row({**row, a: float(limit)}, limit, np.inf)
            else:
                self._row(row, limit, np.inf)

    def _step(self, steps: dict[tuple[int, int], int], k: int, level: int) -> int:
        """b = 1 exactly where T_min + T_object-k >= level."""
        return self._indicator(steps, (k, level), {0: 1.0, 1 + k: 1.0}, level)

    def _closer(self, known: dict[int, int], level: int) -> int:
        """a = 1 exactly where T_min >= level."""
        return self._indicator(known, level, {0: 1.0}, level)

    def _indicator(self, known: dict[Any, int], key: Any, sum_of: dict[int, float], v: int) -> int:
        if key not in known:
            known[key] = b = len(self.lower)
            self.lower.append(0.0)
            self.upper.append(1.0)
            least = sum(self.lower[i] for i in sum_of)
            most = sum(self.upper[i] for i in sum_of)
            self._row({**sum_of, b: -(v - least)}, least, np.inf)  # b -> sum >= v
            self._row({**sum_of, b: -(most - v + 1)}, -np.inf, v - 1)  # not b -> sum <= v - 1
        return known[key]

    def _row(self, row: dict[int, float], least: float, most: float) -> None:
        self.rows.append(row)
        self.at_least.append(least)
        self.at_most.append(most)

    def end(self, greatest: bool, seconds: float) -> int | None:
        """Least or greatest L; None where the time is over or nothing is consistent."""
        n = len(self.lower)
        at = [(i, j, v) for i, row in enumerate(self.rows) for j, v in row.items()]
        i, j, v = zip(*at, strict=True)
        matrix = coo_array((v, (i, j)), shape=(len(self.rows), n)).tocsr()
        weights = np.zeros(n)
        weights[: 1 + self.K] = -1.0 if greatest else 1.0
        found = milp(
            weights,
            integrality=np.ones(n),
            bounds=Bounds(np.array(self.lower), np.array(self.upper)),
            constraints=LinearConstraint(matrix, self.at_least, self.at_most),
            options={"time_limit": seconds, "mip_rel_gap": 0.0},
        )
        return round(abs(float(found.fun))) if found.status == 0 else None


def against(size: tuple[int, int, int, int], seed: int, seconds: float = 60.0) -> dict[str, Any]:
    """CPU seconds of both ends by MILP beside our whole answer, in this process."""
    points, paths, objects, pixels = size
    problem = world(seed, points, paths, objects, pixels).problem
    solve(problem)
    began = time.process_time()
    answer = solve(problem)
    ours = time.process_time() - began
    began = time.process_time()
    program = Program(problem)
    ends = program.end(False, seconds), program.end(True, seconds)
    peer = time.process_time() - began
    return {
        "points": points, "paths": paths, "objects": objects, "px": pixels, "seed": seed,
        "exact_s": ours, "milp_s": peer, "ratio": peer / ours,
        "milp": ends, "exact": (answer.L_min, answer.L_max),
        "same_optimum": None if None in ends else ends == (answer.L_min, answer.L_max),
    }  # fmt: skip


def main() -> None:
    rows = []
    for size in SIZES:
        for seed in range(3):
            rows.append(row := against(size, seed))
            print(
                f"{size}, seed {seed}: exact {1e3 * row['exact_s']:.2f} ms, "
                f"MILP {row['milp_s']:.2f} s, {row['ratio']:,.0f}x, ends {row['milp']} "
                f"and ours {row['exact']}",
                flush=True,
            )
    record("milp", "python benchmarks/milp.py", {"rows": rows})


if __name__ == "__main__":
    main()
