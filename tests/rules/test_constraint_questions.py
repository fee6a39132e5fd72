"""Questions about constraints: at a value in doubt, on a path that keeps the rest."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from demospec.demonstrations import Motion
from demospec.rules import Constraint, learn_rules, query_set, worst

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def people() -> ModuleType:
    """The benchmark's people."""
    sys.path.insert(0, str(BENCHMARKS))
    try:
        where = BENCHMARKS / "constraints.py"
        spec = importlib.util.spec_from_file_location("constraint_people", where)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules["constraint_people"] = module
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(BENCHMARKS))
    return module


@pytest.mark.parametrize(("name", "scenes"), [("height_over", 6), ("front", 5)])
def test_a_threshold_in_doubt_is_asked_for_inside_its_interval(
    people: ModuleType, name: str, scenes: int
) -> None:
    data, _, truth = people.person((people.SINGLE[name],), 1, scenes)
    query = query_set(data)
    assert query.status == "ask"
    asked = query.constraint
    assert asked is not None
    assert people.same(asked, truth[0])
    assert asked.interval is not None
    assert query.points is not None
    assert query.columns == data.columns
    motion = Motion(query.points, query.t, data.columns)
    value = worst(asked, data.scene(str(query.scene)), motion).value
    low, high = asked.interval
    assert low < value < high
    assert query.p_valid == pytest.approx((value - low) / (high - low), abs=1e-6)
    assert "which value exactly?" in query.note
    document = query.to_json()
    assert document["constraint"]["feature"] == asked.feature
    assert document["columns"] == list(data.columns)
    assert len(document["t"]) == len(document["points"])


def test_the_answer_to_a_question_narrows_the_interval(people: ModuleType) -> None:
    data, _, truth = people.person((people.SINGLE["height_over"],), 1, 6)
    query = query_set(data)
    assert query.constraint is not None
    assert query.points is not None
    scene = data.scene(str(query.scene))
    motion = Motion(query.points, query.t, data.columns)
    kept = worst(truth[0], scene, motion).margin >= 0
    d = data.demonstrations
    old = list(d)
    new = replace(
        old[0], demo_id="answer", scene_id=scene.scene_id, points=query.points, t=query.t,
        valid=bool(kept),
    )  # fmt: skip
    more = replace(data, demonstrations=type(d).of([*old, new], columns=len(data.columns)))
    (after,) = learn_rules(more, influence=False).of_type("someone").constraints
    assert query.constraint.interval is not None
    assert after.interval is not None
    assert np.ptp(after.interval) < 0.75 * np.ptp(query.constraint.interval)
    assert after.interval[0] <= truth[0].value <= after.interval[1]


def test_who_keeps_a_distance_is_asked_about_distances(people: ModuleType) -> None:
    data = people.table(np.random.default_rng(0), 4)
    data = people.labelled(data, [Constraint("distance", "glass", value=6.0)])
    query = query_set(data)
    assert query.constraint is None
    assert "constraint" not in query.to_json()
