"""Plans: obedient by independent geometry, short, honest about what blocks."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.errors import CannotJudgeError, InputError
from demospec.planning import PLANNERS, check_plan, cost_map, plan_path, read_plannable
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Picture, Polygon, Scene, SceneObject, rectangle

PICTURE = Picture(array=np.zeros((100, 100, 3), dtype=np.uint8))


def scene_of(*objects: SceneObject, start=(10.0, 90.0), goal=(90.0, 10.0), picture=PICTURE):
    return Scene("s", start, goal, tuple(objects), picture)


def disc(name: str, x: float, y: float, radius: float = 6.0, symbol: str = "glass"):
    return SceneObject(name, symbol, (x, y), None, Disc((x, y), radius))


def box(name: str, x0: float, y0: float, x1: float, y1: float) -> SceneObject:
    middle = ((x0 + x1) / 2, (y0 + y1) / 2)
    return SceneObject(name, "glass", middle, None, rectangle(x0, y0, x1 - x0, y1 - y0))


def rules_of(value: dict[str, float], interval: dict[str, tuple[float, float]] | None = None):
    return RuleSet({"careful": TypeRules(ClearanceRule(value, interval or {}))})


def least_margin(scene: Scene, value: dict[str, float], path: np.ndarray) -> float:
    """Independent oracle: samples 0.01 px apart, no planning code."""
    parts = []
    for a, b in pairwise(path):
        n = max(2, int(np.hypot(*(b - a)) / 0.01))
        parts.append(a + np.linspace(0, 1, n)[:, None] * (b - a))
    dense = np.concatenate(parts)
    gaps = [
        float(o.outline.signed_distance(dense).min()) - value[o.symbol]
        for o in scene.objects or ()
        if o.symbol in value
    ]
    return min(gaps, default=np.inf)


@settings(deadline=None, max_examples=40)
@given(
    st.lists(
        st.tuples(st.floats(28, 72), st.floats(28, 72), st.floats(1, 9)), min_size=1, max_size=4
    ),
    st.floats(0, 8),
)
def test_found_plans_keep_the_rule_by_independent_geometry(
    discs: list[tuple[float, float, float]], keep: float
) -> None:
    scene = scene_of(*[disc(f"g{i}", x, y, r) for i, (x, y, r) in enumerate(discs)])
    plan = plan_path(rules_of({"glass": keep}), scene)
    if plan.found:
        assert plan.obeys
        assert least_margin(scene, {"glass": keep}, plan.points) >= -1e-9
        assert plan.points[0].tolist() == [10, 90]
        assert plan.points[-1].tolist() == [90, 10]
        assert plan.length >= np.hypot(80, 80) - 1e-9
        assert ((plan.points >= 0) & (plan.points <= 100)).all()
    else:
        assert plan.status == "infeasible"
        assert set(plan.blocked_by) <= {f"g{i}" for i in range(len(discs))}
        assert plan.blocked_by


def test_way_around_one_disc_is_the_known_shortest() -> None:
    # Tangent, arc, tangent around a disc of radius R whose centre is on the straight line.
    radius, keep = 12.0, 5.0
    scene = scene_of(disc("g", 50, 50, radius))
    plan = plan_path(rules_of({"glass": keep}), scene)
    half, big = np.hypot(40, 40), radius + keep
    shortest = 2 * np.sqrt(half**2 - big**2) + big * 2 * np.arcsin(big / half)
    assert shortest <= plan.length <= 1.003 * shortest


def test_notched_polygon_is_respected() -> None:
    notched = Polygon([[35, 35], [65, 35], [65, 65], [50, 50], [35, 65]])
    scene = scene_of(SceneObject("b", "bowl", (50, 45), None, notched))
    plan = plan_path(rules_of({"bowl": 4.0}), scene)
    assert plan.obeys
    assert least_margin(scene, {"bowl": 4.0}, plan.points) >= -1e-9


def test_irrelevant_symbols_are_passed_over() -> None:
    scene = scene_of(disc("p", 50, 50, symbol="plate"))
    plan = plan_path(rules_of({"glass": 5.0}), scene)
    assert plan.length == pytest.approx(np.hypot(80, 80))
    assert plan.check.clearance["p"] < 0


def test_wall_is_infeasible_and_named() -> None:
    wall = Polygon([[-5, 45], [105, 45], [105, 55], [-5, 55]])
    scene = scene_of(SceneObject("wall", "glass", (50, 50), None, wall), disc("g", 20, 20, 3))
    plan = plan_path(rules_of({"glass": 2.0}), scene)
    assert plan.status == "infeasible"
    assert plan.blocked_by == ("wall",)
    assert "wall" in plan.reason
    document = plan.to_json()
    assert document["obeys"] is False
    assert document["points"] == []
    json.dumps(document, allow_nan=False)


def test_two_objects_that_block_together_are_both_named() -> None:
    left = Polygon([[-5, 45], [60, 45], [60, 55], [-5, 55]])
    right = Polygon([[40, 45], [105, 45], [105, 55], [40, 55]])
    objects = [
        SceneObject("left", "glass", (27, 50), None, left),
        SceneObject("right", "glass", (73, 50), None, right),
    ]
    assert set(plan_path(rules_of({"glass": 2.0}), scene_of(*objects)).blocked_by) == {
        "left",
        "right",
    }


def test_share_of_the_clearance_that_would_do_is_said() -> None:
    walls = [box("a", -5, 45, 40, 55), box("b", 60, 45, 105, 55)]
    plan = plan_path(rules_of({"glass": 12.5}), scene_of(*walls))
    assert plan.status == "infeasible"
    share = int(re.findall(r"with (\d+)% of the clearances", plan.reason)[0])
    assert 72 <= share <= 80  # the gap is 20 wide: 10 of 12.5 fit, less what the grid blurs
    assert plan_path(rules_of({"glass": 12.5 * share / 100}), scene_of(*walls)).obeys


def test_narrow_passage_is_found() -> None:
    walls = [box("a", -5, 45, 40, 55), box("b", 60, 45, 105, 55)]
    plan = plan_path(rules_of({"glass": 9.8}), scene_of(*walls))
    assert plan.obeys


def test_upper_corner_obeys_every_consistent_rule() -> None:
    scene = scene_of(disc("g", 45, 52), disc("b", 60, 35, symbol="bowl"))
    interval = {"glass": (2.0, 7.0), "bowl": (1.0, 5.0)}
    plan = plan_path(rules_of({"glass": 4.0, "bowl": 3.0}, interval), scene)
    for share in np.linspace(0, 1, 6):
        value = {k: a + share * (b - a) for k, (a, b) in interval.items()}
        assert check_plan(rules_of(value), scene, plan.points).obeys


def test_unbounded_interval_falls_back_and_says_so() -> None:
    scene = scene_of(disc("g", 50, 50))
    plan = plan_path(rules_of({"glass": 4.0}, {"glass": (1.0, float("inf"))}), scene)
    assert plan.unbounded == ("glass",)
    assert plan.check.clearance["g"] == pytest.approx(4.0, abs=0.1)


def test_objects_of_uninformed_classes_are_said() -> None:
    rules = RuleSet({"careful": TypeRules(ClearanceRule({"glass": 4.0}, {}, ("bowl",)))})
    scene = Scene(
        "u", (5.0, 50.0), (95.0, 50.0),
        (SceneObject("bowl-7", "bowl", (50.0, 50.0), None, Disc((50.0, 50.0), 6.0)),), PICTURE,
    )  # fmt: skip
    assert plan_path(rules, scene).uninformed == ("bowl-7",)


def test_start_within_the_envelope_only_caps_the_clearance() -> None:
    scene = scene_of(disc("g", 20, 80, 5.0))  # start is 9.14 away
    rules = rules_of({"glass": 4.0}, {"glass": (2.0, 12.0)})
    plan = plan_path(rules, scene)
    gap = np.hypot(10, 10) - 5
    assert plan.capped == {"glass": pytest.approx(gap)}
    assert plan.obeys
    assert plan.check.clearance["g"] >= gap - 1e-9


@pytest.mark.parametrize(("name", "place"), [("start", (20, 80)), ("goal", (80, 20))])
def test_end_in_a_forbidden_region_is_one_line(name: str, place: tuple[float, float]) -> None:
    scene = scene_of(disc("cup", *place, 5.0))
    with pytest.raises(InputError, match=rf"scene s, {name}: expected a {name} at least 11 px "
                       r"from cup, found \[.*\], 9.1 px from it"):  # fmt: skip
        plan_path(rules_of({"glass": 11.0}), scene)


def test_other_faults_are_one_line() -> None:
    rules, scene = rules_of({"glass": 3.0}), scene_of(disc("g", 50, 50))
    for options, text in (
        ({"type": "bold"}, "type: expected one of the types careful, found bold"),
        ({"envelope": "big"}, "envelope: expected one of"),
        ({"planner": "magic"}, "planner: expected one of grid"),
        ({"resolution": 0.0}, "resolution: expected a resolution > 0"),
        ({"resolution": 1e9}, "resolution: expected a map of at most"),
        ({"start": (-3.0, 5.0)}, "start: expected a start on the table"),
        ({"symbols": ["spoon"]}, "symbols: expected symbols of the rule or scene"),
        ({"allowance": -1.0}, "allowance: expected an allowance >= 0"),
    ):
        with pytest.raises(InputError, match=text):
            plan_path(rules, scene, **options)
    with pytest.raises(CannotJudgeError):
        plan_path(rules, Scene("s", (1, 1), (9, 9), None, PICTURE))


def test_scene_without_a_picture_is_planned_in_what_it_spans() -> None:
    scene = scene_of(disc("g", 50, 50, 60.0), start=(-50, 50), goal=(150, 50), picture=None)
    plan = plan_path(rules_of({"glass": 5.0}), scene)
    assert plan.obeys


def test_plans_move_and_scale_with_the_scene() -> None:
    rules = rules_of({"glass": 5.0})
    one = plan_path(rules, scene_of(disc("g", 48, 52), picture=None))
    moved = scene_of(disc("g", 1048, 52), start=(1010, 90), goal=(1090, 10), picture=None)
    assert plan_path(rules, moved).length == pytest.approx(one.length, rel=1e-3)
    big = scene_of(disc("g", 480, 520, 60.0), start=(100, 900), goal=(900, 100), picture=None)
    scaled = plan_path(rules_of({"glass": 50.0}), big)
    assert scaled.length == pytest.approx(10 * one.length, rel=1e-3)


def test_allowance_keeps_more() -> None:
    scene = scene_of(disc("g", 50, 50))
    plan = plan_path(rules_of({"glass": 3.0}), scene, allowance=1.5)
    assert plan.check.margin >= 1.5 - 1e-9
    near = scene_of(disc("g", 20, 80, 11.0))  # start is 3.14 away: less room than 1.5
    tight = plan_path(rules_of({"glass": 3.0}), near, allowance=1.5)
    assert tight.obeys


@pytest.mark.parametrize("planner", [p for p in PLANNERS if p != "grid"])
def test_other_planners_obey_too(planner: str) -> None:
    if planner != "latent":
        pytest.importorskip("ompl", reason="pip install 'demospec[planners]' brings OMPL")
    scene = scene_of(disc("g", 48, 53, 8.0), disc("h", 70, 70, 5.0))
    value = {"glass": 4.0}
    plan = plan_path(rules_of(value), scene, planner=planner, seed=1, time_limit_s=0.4)
    assert plan.found
    assert plan.obeys
    assert least_margin(scene, value, plan.points) >= -1e-9
    best = plan_path(rules_of(value), scene).length
    assert best * 0.98 <= plan.length <= best * 1.25


def test_latent_planner_repairs_where_no_sample_is_valid() -> None:
    from demospec.planning._cost_map import map_bounds
    from demospec.planning._latent import _curves, _margins, _repaired
    from demospec.planning._zones import clearance_zones

    scene = scene_of(disc("g", 50, 50, 10.0))
    zones = clearance_zones(ClearanceRule({"glass": 5.0}), scene)
    bounds = np.asarray(map_bounds(scene, zones))
    start, goal = np.array([10.0, 90.0]), np.array([90.0, 10.0])
    control = np.array([[52.0, 53.0], [49.0, 48.5]])
    before = _margins(zones, bounds, _curves(start, goal, control))
    after = _margins(
        zones, bounds, _curves(start, goal, _repaired(zones, bounds, start, goal, control))
    )
    assert (before < -5).all()
    assert (after > before + 5).all()


def test_failed_is_not_infeasible() -> None:
    # An S-shaped way: no order-2 curve fits, a grid path does.
    walls = [box("a", -5, 62, 70, 68), box("b", 30, 32, 105, 38)]
    scene = scene_of(*walls)
    rules = rules_of({"glass": 6.0})
    assert plan_path(rules, scene).obeys
    latent = plan_path(rules, scene, planner="latent")
    assert latent.status == "failed"
    assert "planner grid finds one" in latent.reason


def test_rules_of_every_kind_are_read(tmp_path: Path) -> None:
    file = tmp_path / "rules.json"
    file.write_text(json.dumps({"types": {"t": {"clearance": {"value": {"glass": 2}}}}}))
    assert read_plannable(file).types == ("t",)
    answer = {
        "family": "clearance", "status": "optimal", "relevant": ["glass"], "uninformed": ["bowl"],
        "interval": {"glass": [2.0, 3.5]}, "value": {"glass": 2.5},
        "settings": {"distance": "center"},
    }  # fmt: skip
    file.write_text(json.dumps(answer))
    known = read_plannable(file)
    assert known.types == ("anyone",)
    assert cost_map(known, scene_of(disc("g", 50, 50))).clearance([50, 60]) == pytest.approx(10)
    for wrong, field in (
        ({"hull": {}}, "hull"),
        ({"hull": {}, "settings": {"F_max": 3}}, "influence"),
        ({"family": "clearance", "value": 3}, "value"),
        ([answer], "object"),
    ):
        file.write_text(json.dumps(wrong))
        with pytest.raises(InputError, match=rf"rules\.json.*{field}"):
            read_plannable(file)
    file.write_text('{"nothing": 1}')
    with pytest.raises(InputError, match=r"rules\.json"):
        read_plannable(file)


def test_map_and_plan_agree() -> None:
    scene = scene_of(disc("g", 50, 50))
    rules = rules_of({"glass": 3.0})
    where = cost_map(rules, scene)
    plan = plan_path(rules, scene)
    assert where.margin(plan.points).min() >= -1e-9
    assert plan.cost == pytest.approx(plan.length, rel=1e-6)
