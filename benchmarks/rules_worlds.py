"""Simulated worlds for the benchmarks of the influence rules: a truth, and what it labels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.rules import Bounds, RuleObject, RuleProblem, RuleScene, RuleTrajectory
from demospec.rules.influence.engines._step_functions import step_problem


@dataclass(frozen=True)
class World:
    """A problem and the parameters that made its labels."""

    problem: RuleProblem
    T_min: int
    T_object: tuple[int, ...]
    flipped: frozenset[int] = frozenset()

    @property
    def L(self) -> int:
        return self.T_min + sum(self.T_object)


def world(
    seed: int,
    points: int,
    trajectories: int,
    objects: int,
    size: int = 500,
    noise: float = 0.0,
    whole: bool = True,
    bound: int = 100,
) -> World:
    """Quadratic Bézier paths among random objects; half of them good where there are enough.

    F_max is the median summed distance of the paths that touch nothing. Labels of a share
    `noise` of the trajectories are flipped.
    """
    rng = np.random.default_rng(seed)
    items = tuple(
        RuleObject(f"object-{k}", f"object-{k}", tuple(float(c) for c in rng.integers(0, size, 2)))
        for k in range(objects)
    )
    T = int(rng.integers(bound // 20, bound // 4))
    own = rng.integers(bound // 10, bound * 3 // 4, objects)
    t = np.linspace(0, 1, points)[:, None]
    paths = []
    for _ in range(3 * trajectories):
        a, b, c = rng.random((3, 2)) * size
        curve = (1 - t) ** 2 * a + 2 * t * (1 - t) * c + t**2 * b
        paths.append(RuleTrajectory(0, True, np.rint(curve) if whole else curve))
    problem = RuleProblem(
        (RuleScene(items),), tuple(paths), 1, bounds=Bounds((1, bound), (1, bound))
    )
    steps = step_problem(problem)
    block = steps.blocks[0]
    total = sum(block.table[:, k, T + own[k]] for k in range(objects))
    contact = block.closest <= T
    free = np.sort(total[~contact & (total > 0)])
    F_max = max(1, int(free[len(free) // 2]) // problem.scale) if len(free) else 1
    valid = ~contact & (total < F_max * problem.scale)
    good, bad = np.flatnonzero(valid), np.flatnonzero(~valid)
    n_bad = min(len(bad), max(trajectories // 2, trajectories - len(good)))
    chosen = rng.permutation(np.concatenate([bad[:n_bad], good[: trajectories - n_bad]]))
    wrong = rng.random(len(chosen)) < noise
    labelled = tuple(
        replace(paths[i], valid=bool(valid[i] ^ w)) for i, w in zip(chosen, wrong, strict=True)
    )
    return World(
        replace(problem, trajectories=labelled, F_max=F_max),
        T,
        tuple(int(v) for v in own),
        frozenset(np.flatnonzero(wrong).tolist()),
    )


def record(name: str, command: str, results: dict) -> None:
    """Writes benchmarks/results/NAME.json with machine and versions."""
    import platform
    from importlib.metadata import version
    from pathlib import Path

    from demospec.files import write_json

    about = {
        "command": command,
        "machine": platform.machine(),
        "processor": _processor(),
        "python": platform.python_version(),
        "versions": {p: version(p) for p in ("numpy", "ortools", "demospec")},
    }
    path = Path(__file__).parent / "results" / f"{name}.json"
    write_json(path, {**about, **results})


def _processor() -> str:
    from pathlib import Path

    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return "unknown"
