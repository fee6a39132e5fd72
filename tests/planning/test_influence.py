"""Planning with influence rules: within the budget, judged by the plain evaluator."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.planning import check_plan, cost_map, plan_path, read_plannable
from demospec.rules import RuleSet, TypeRules
from demospec.scene import Picture, Scene, SceneObject

PICTURE = Picture(array=np.zeros((60, 80, 3), dtype=np.uint8))


def answer(T_min: list[int], drill: list[int], clamp: list[int], **settings: Any) -> dict[str, Any]:
    return {
        "status": "optimal",
        "min": {"T_min": T_min[0], "T_object": {"drill": 3, "clamp": 2}, "L": 0},
        "max": {"T_min": T_min[1], "T_object": {"drill": 9, "clamp": 8}, "L": 0},
        "hull": {"T_min": T_min, "radius": {"drill": drill, "clamp": clamp}},
        "settings": {
            "F_max": 60, "scale": 1000, "reading": "sum", "penalty": "hinge", "weights": "arc",
            **settings,
        },
    }  # fmt: skip


def bench(*places: tuple[str, float, float]) -> Scene:
    objects = tuple(SceneObject(name, name, (x, y)) for name, x, y in places)
    return Scene("b", (5.0, 30.0), (75.0, 30.0), objects, PICTURE)


def rules(document: dict[str, Any]) -> RuleSet:
    return RuleSet({"anyone": TypeRules(influence=document)})


def independent_sum(
    path: np.ndarray, scene: Scene, radius: dict[str, float], T_min: float, penalty: str
) -> tuple[bool, float]:
    """Contact and Σ f with arc weights, in floating point, from the definition."""
    steps = np.hypot(*np.diff(path, axis=0).T)
    weight = (np.concatenate([[0], steps]) + np.concatenate([steps, [0]])) / 2
    contact, total = False, 0.0
    for item in scene.objects or ():
        d = np.hypot(*(path - np.array(item.center)).T)
        contact |= bool((d <= T_min).any())
        value = radius[item.symbol] - d if penalty == "hinge" else d
        total += float((np.where(d <= radius[item.symbol], value, 0) * weight).sum())
    return contact, total


@pytest.mark.parametrize("reading", ["sum", "nearest_active"])
def test_plan_from_the_upper_corner_obeys_every_corner(reading: str) -> None:
    scene = bench(("drill", 40.0, 32.0), ("clamp", 60.0, 10.0))
    document = answer([2, 4], [8, 14], [6, 10], reading=reading)
    plan = plan_path(rules(document), scene)
    assert plan.obeys
    # A reading that is not monotone gets a way that costs nothing, or the corner says little.
    assert plan.check.margin == (pytest.approx(60.0) if reading != "sum" else plan.check.margin)
    for envelope in ("lower", "value", "min", "max", "upper"):
        assert check_plan(rules(document), scene, plan.points, envelope=envelope).obeys  # type: ignore[arg-type]


def test_budget_is_spent_where_no_free_way_exists() -> None:
    # Discs that reach from edge to edge: there is no way around, only a price.
    scene = bench(("drill", 40.0, 12.0), ("clamp", 40.0, 48.0))
    document = answer([3, 3], [20, 20], [20, 20])
    plan = plan_path(rules(document), scene)
    assert plan.obeys
    contact, total = independent_sum(plan.points, scene, {"drill": 20, "clamp": 20}, 3, "hinge")
    assert not contact
    assert 0 < total < 60
    assert plan.check.margin == pytest.approx(60 - total, abs=0.1)


def test_too_small_a_budget_is_infeasible_and_names_who_blocks() -> None:
    scene = bench(("drill", 40.0, 12.0), ("clamp", 40.0, 48.0))
    document = answer([3, 3], [28, 28], [28, 28], F_max=1)
    plan = plan_path(rules(document), scene)
    assert plan.status == "infeasible"
    assert "F_max" in plan.reason


def test_verdict_is_the_rules_own() -> None:
    scene = bench(("drill", 40.0, 30.0), ("clamp", 20.0, 12.0))
    rng = np.random.default_rng(0)
    seen = set()
    for penalty in ("hinge", "distance"):
        document = answer([3, 3], [15, 15], [9, 9], penalty=penalty)
        for _ in range(30):
            middle = rng.uniform([10, 5], [70, 55])
            path = np.concatenate([
                np.linspace((5, 30), middle, 40), np.linspace(middle, (75, 30), 40)[1:],
            ])  # fmt: skip
            contact, total = independent_sum(path, scene, {"drill": 15, "clamp": 9}, 3, penalty)
            if abs(total - 60) < 0.5:
                continue
            obeys = check_plan(rules(document), scene, path, envelope="upper").obeys
            assert obeys == (not contact and total < 60)
            seen.add(obeys)
    assert seen == {True, False}


def test_answer_file_alone_can_be_planned_with(tmp_path: Path) -> None:
    file = tmp_path / "answer.json"
    file.write_text(json.dumps(answer([2, 4], [8, 14], [6, 10])))
    scene = bench(("drill", 40.0, 32.0))
    assert plan_path(read_plannable(file), scene).obeys
    assert cost_map(read_plannable(file), scene).zones[0].reach == pytest.approx(14, abs=1e-3)


def test_faults_are_one_line() -> None:
    scene = bench(("drill", 40.0, 32.0))
    with pytest.raises(InputError, match="expected objects named drill, clamp, found spoon"):
        plan_path(rules(answer([2, 4], [8, 14], [6, 10])), bench(("spoon", 40.0, 32.0)))
    infeasible = answer([2, 4], [8, 14], [6, 10]) | {"hull": None}
    with pytest.raises(InputError, match="hull: expected a hull"):
        plan_path(rules(infeasible), scene)
    with pytest.raises(InputError, match="start: expected a start at least 4 px from drill"):
        plan_path(rules(answer([2, 4], [8, 14], [6, 10])), bench(("drill", 6.0, 30.0)))


def test_answer_without_settings_is_obeyed_by_staying_out_of_every_disc() -> None:
    scene = bench(("drill", 40.0, 32.0), ("clamp", 60.0, 10.0))
    bare = answer([2, 4], [8, 14], [6, 10])
    del bare["settings"]
    plan = plan_path(rules(bare), scene)
    assert plan.obeys
    assert plan.check.clearance["drill"] > 14


def test_objects_that_the_answer_does_not_name_are_said() -> None:
    scene = bench(("drill", 40.0, 32.0), ("spoon", 30.0, 30.0))
    plan = plan_path(rules(answer([2, 4], [8, 14], [6, 10])), scene)
    assert plan.obeys
    assert plan.to_json()["uninformed"] == ["spoon"]
    # What the caller leaves out on purpose is no surprise.
    assert plan_path(rules(answer([2, 4], [8, 14], [6, 10])), scene, symbols=["drill"]).obeys


def test_thresholds_per_class_are_matched_by_class_alone() -> None:
    # An object whose id is the name of another class.
    item = SceneObject("clamp", "drill", (40.0, 30.0))
    scene = Scene("b", (5.0, 30.0), (75.0, 30.0), (item,), PICTURE)
    for thresholds, keep in (("class", 14), ("instance", 10)):
        known = rules(answer([2, 4], [8, 14], [6, 10], thresholds=thresholds))
        assert cost_map(known, scene).zones[0].reach == pytest.approx(keep, abs=1e-3)


def test_infeasible_answer_is_named_with_its_file(tmp_path: Path) -> None:
    file = tmp_path / "answer.json"
    none = answer([2, 4], [8, 14], [6, 10]) | {"status": "infeasible", "hull": None}
    file.write_text(json.dumps(none))
    with pytest.raises(InputError, match=r"answer\.json, status: .* found infeasible"):
        read_plannable(file)


def test_dense_path_can_be_judged_like_a_plan() -> None:
    scene = bench(("drill", 40.0, 12.0), ("clamp", 40.0, 48.0))
    known = rules(answer([3, 3], [20, 20], [20, 20], weights="points"))
    plan = plan_path(known, scene)
    assert plan.obeys
    assert plan.check.margin < 50  # it spends of its budget
    dense = np.concatenate([
        a + np.linspace(0, 1, 8)[:, None] * (b - a)
        for a, b in zip(plan.points[:-1], plan.points[1:], strict=True)
    ])  # fmt: skip
    assert not check_plan(known, scene, dense, envelope="upper").obeys
    assert check_plan(known, scene, dense, envelope="upper", spacing=1.0).obeys
