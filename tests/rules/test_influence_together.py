"""Step functions of many scenes worked out together, against one scene after the other."""

import numpy as np
import pytest

from demospec.rules import RuleObject, RuleProblem, RuleScene, RuleTrajectory
from demospec.rules.influence._problem import Bounds
from demospec.rules.influence.engines import _step_functions

GRIDS = (1.0, 0.5, 0.1, 0.01, 0.001, None)  # None: no grid at all


def place(rng, grid, shape, span=40):
    values = rng.uniform(-span, span, shape)
    return values if grid is None else np.round(np.rint(values / grid) * grid, 3)


def problem(seed):
    """Scenes of one to three objects with one to three paths, some through and at whole radii."""
    rng = np.random.default_rng(seed)
    grid = GRIDS[seed % len(GRIDS)]
    scenes, paths = [], []
    for s in range(25):
        count = int(rng.choice([1, 2, 2, 2, 3]))
        centers = place(rng, grid, (count, 2), 20)
        scenes.append(
            RuleScene(
                tuple(
                    RuleObject(f"o{k}", str(rng.choice(["a", "b", "c"])), tuple(c.tolist()))
                    for k, c in enumerate(centers)
                )
            )
        )
        for _ in range(int(rng.integers(0, 4))):
            points = place(rng, grid, (int(rng.integers(1, 30)), 2))
            points[0] = centers[0] + [3.0, 4.0]  # 5 away: on a radius, whatever the rounding
            paths.append(RuleTrajectory(s, bool(rng.integers(2)), points))
    return RuleProblem(
        tuple(scenes), tuple(paths), 20, (1, 100, 1000)[seed % 3],
        "sum" if seed % 5 else "nearest",
        ("count", "distance", "hinge")[seed % 3],
        weights=("points", "arc")[seed // 2 % 2],
        thresholds="class", bounds=Bounds((0, 30), (0, 30)),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(60))
def test_together_is_what_each_scene_says_alone(monkeypatch, seed):
    case = problem(seed)
    calls = []
    plain = _step_functions.fill_scenes
    monkeypatch.setattr(_step_functions, "fill_scenes", lambda *a: (calls.append(1), plain(*a))[1])
    together = _step_functions.step_problem(case)
    assert bool(calls) == (case.reading == "sum")
    monkeypatch.setattr(_step_functions, "_FEW_POINTS", -1)
    calls.clear()
    alone = _step_functions.step_problem(case)
    assert not calls
    assert len(together.blocks) == len(alone.blocks)
    for one, other in zip(together.blocks, alone.blocks, strict=True):
        np.testing.assert_array_equal(one.rows, other.rows)
        np.testing.assert_array_equal(one.closest, other.closest)
        np.testing.assert_array_equal(one.table, other.table)
