"""Plans for rules with constraints, judged by dense samples that share no code with them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.planning import Plan, check_plan, cost_map, plan_path
from demospec.rules import Feature, register_feature, rules_from_document
from demospec.scene import Disc, Picture, Relation, Scene, SceneObject, rectangle

PICTURE = Picture(array=np.zeros((100, 100, 3), dtype=np.uint8))


def person(name: str, x: float, y: float, radius: float = 4.0, heading: float | None = 90.0):
    disc = Disc((x, y), radius)
    return SceneObject(name, "person", (x, y), None, disc, heading_deg=heading)


def laptop(x: float = 50.0, y: float = 50.0, top: float = 5.0, wide: float = 12.0):
    box = rectangle(x - wide / 2, y - wide / 2, wide, wide)
    return SceneObject("laptop", "laptop", (x, y), None, box, height=(0.0, top))


def table(*objects: SceneObject, start=(10.0, 50.0), goal=(90.0, 50.0), **more: Any) -> Scene:
    return Scene("s", start, goal, objects, PICTURE, **more)


def rule(*constraints: dict[str, Any], **clearance: float):
    entry: dict[str, Any] = {"constraints": list(constraints)}
    if clearance:
        entry["clearance"] = {"value": clearance}
    return rules_from_document({"types": {"anyone": entry}})


def dense(path: np.ndarray, t: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Points on the path and the speed there."""
    parts, speeds = [], []
    for i, (a, b) in enumerate(pairwise(path)):
        n = max(2, int(np.linalg.norm(b - a) / 0.02))
        parts.append(a + np.linspace(0, 1, n)[:, None] * (b - a))
        v = np.inf if t is None else np.linalg.norm((b - a)[:2]) / (t[i + 1] - t[i])
        speeds.append(np.full(n, v))
    return np.concatenate(parts), np.concatenate(speeds)


def margins_of(plan: Plan) -> list[float]:
    return [c.margin for c in plan.check.constraints]


def test_every_constraint_is_listed_with_its_margin() -> None:
    scene = table(person("p", 50, 52))
    plan = plan_path(
        rule(
            {"feature": "distance", "of": "person", "value": 10.0}, {"feature": "edge", "value": 3}
        ),
        scene,
    )
    assert plan.obeys
    listed = plan.to_json()["constraints"]
    assert [c["feature"] for c in listed] == ["distance", "edge"]
    assert all(c["kept"] and c["margin"] >= 0 for c in listed)
    assert [c["how"] for c in listed] == ["zone", "zone"]
    points, _ = dense(plan.points)
    assert (np.hypot(*(points - [50, 52]).T) - 4).min() >= 10 - 1e-6
    assert listed[0]["margin"] == pytest.approx(0, abs=1e-3)


def test_in_front_is_kept_and_behind_is_free() -> None:
    """It faces +y; the way behind (smaller y) is a straight line, the way in front is not."""
    asked = {"feature": "distance", "of": "person", "value": 20.0, "sector": "front"}
    plan = plan_path(rule(asked), table(person("p", 50, 46)))
    points, _ = dense(plan.points)
    ahead = points[:, 1] >= 46
    assert plan.obeys
    assert (np.hypot(*(points[ahead] - [50, 46]).T) - 4).min() >= 20 - 1e-6
    assert plan.length < 82
    turned = plan_path(rule(asked), table(person("p", 50, 46, heading=-90.0)))
    assert turned.length == pytest.approx(80, abs=1.0)


def test_a_side_of_a_thing_without_heading_is_not_known() -> None:
    plan = plan_path(
        rule({"feature": "distance", "of": "person", "value": 5.0, "sector": "front"}),
        table(person("p", 50, 20, heading=None)),
    )
    assert plan.uninformed == ("p",)
    assert plan.to_json()["obeys"] is None


def test_not_between_two_that_talk() -> None:
    """The line between them is crossed nowhere; the pair that does not talk is passed through."""
    people = person("a", 50, 30), person("b", 50, 70), person("c", 50, 95)
    scene = table(*people, relations=(Relation("talk", ("a", "b")),))
    plan = plan_path(rule({"feature": "between", "of": "talk", "value": 2.0}), scene)
    points, _ = dense(plan.points)
    beside = (points[:, 1] >= 30) & (points[:, 1] <= 70)
    assert plan.obeys
    assert np.abs(points[beside, 0] - 50).min() >= 2 - 1e-6


def test_a_region_is_kept_out_of_and_another_stayed_in() -> None:
    regions = {"pool": [[40, 40], [60, 40], [60, 90], [40, 90]],
               "hall": [[5, 25], [95, 25], [95, 95], [5, 95]]}  # fmt: skip
    scene = table(extra=(("regions", regions),))
    asked = (
        {"feature": "region", "of": "pool", "value": 4.0, "sense": "at_least"},
        {"feature": "region", "of": "hall", "value": -2.0, "sense": "at_most"},
    )
    plan = plan_path(rule(*asked), scene)
    points, _ = dense(plan.points)
    assert plan.obeys
    assert ((points[:, 1] >= 27 - 1e-6) & (points[:, 1] <= 93 + 1e-6)).all()
    gap = np.maximum(np.abs(points - [50, 65]) - [10, 25], 0)
    assert np.hypot(*gap.T).min() >= 4 - 1e-6
    assert plan.points[:, 1].min() < 40


def test_must_come_near_is_by_way_of_the_nearest_of_its_class() -> None:
    scene = table(person("near", 50, 35), person("far", 20, 95))
    plan = plan_path(rule({"feature": "near", "of": "person", "value": 3.0}), scene)
    points, _ = dense(plan.points)
    assert plan.obeys
    assert (np.hypot(*(points - [50, 35]).T) - 4).min() <= 3 + 1e-6
    assert plan.length <= 1.01 * 2 * np.hypot(40, 8)


def test_slow_within_a_radius_and_not_slower_elsewhere() -> None:
    asked = {"feature": "speed", "value": 2.0, "when": {"within": 15.0, "of": "person"}}
    plan = plan_path(rule(asked), table(person("p", 50, 60)))
    assert plan.t is not None
    points, speed = dense(plan.points, plan.t)
    near = np.hypot(*(points[:, :2] - [50, 60]).T) - 4 <= 15
    assert near.any()
    assert (speed[near] <= 2.0).all()
    assert (speed[~near] > 2.0).mean() > 0.9
    assert plan.obeys


def test_over_a_thing_at_the_height_that_is_allowed_or_around_it() -> None:
    ends: dict[str, Any] = {"start": (10.0, 50.0, 5.0), "goal": (90.0, 50.0, 5.0)}
    low = {"feature": "height_over", "of": "laptop", "value": 4.0}
    over = plan_path(rule(low), table(laptop(wide=40), **ends))
    points, _ = dense(over.points)
    above = (np.abs(points[:, :2] - 50) < 20 - 1e-9).all(axis=1)
    assert over.columns == ("x", "y", "z")
    assert above.any()
    assert points[above, 2].min() >= 9 - 1e-6
    assert over.length <= 1.01 * (2 * np.hypot(20, 4) + 40)
    high = low | {"value": 60.0}
    around = plan_path(rule(high), table(laptop(wide=40), **ends))
    points, _ = dense(around.points)
    assert (np.abs(points[:, :2] - 50) >= 20 - 1e-6).any(axis=1).all()
    assert around.points[:, 2].max() < 10
    assert over.obeys
    assert around.obeys


def test_tilt_is_handed_on_and_judged_upright() -> None:
    plan = plan_path(rule({"feature": "tilt", "value": 15.0, "unit": "deg"}), table())
    (check,) = plan.check.constraints
    assert (check.how, check.margin) == ("execution", 15.0)
    tilted = check_plan(
        rule({"feature": "tilt", "value": 15.0, "unit": "deg"}), table(),
        [[10, 50, 0], [90, 50, 20]], columns=("x", "y", "tilt"),
    )  # fmt: skip
    assert not tilted.obeys


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ([{"feature": "length", "of": None, "value": 70.0}], "takes a way of at most 70"),
        (
            [{"feature": "dwell", "value": 1.0, "when": {"within": 15.0, "of": "person"}},
             {"feature": "speed", "value": 5.0}],
            "stays at most",
        ),
        (
            [{"feature": "near", "of": "person", "value": 2.0},
             {"feature": "distance", "of": "person", "value": 9.0}],
            "comes within 2",
        ),
    ],
)  # fmt: skip
def test_what_is_impossible_is_named(asked: list[dict[str, Any]], words: str) -> None:
    plan = plan_path(rule(*asked), table(person("p", 50, 50)))
    assert plan.status == "infeasible"
    assert words in plan.reason
    assert "\n" not in plan.reason


def test_a_start_that_breaks_a_constraint_is_refused() -> None:
    with pytest.raises(InputError, match="a start where the person keeps at least 20"):
        plan_path(
            rule({"feature": "distance", "of": "person", "value": 20.0}),
            table(person("p", 20, 50)),
        )


def test_an_interval_is_planned_with_its_safe_end_as_far_as_the_ends_leave_it() -> None:
    asked = {"feature": "distance", "of": "person", "value": 8.0, "interval": [6.0, 14.0]}
    plan = plan_path(rule(asked), table(person("p", 50, 55)))
    assert plan.check.constraints[0].worst.value >= 14 - 1e-6
    near = plan_path(rule(asked), table(person("p", 24, 50)))
    assert near.check.constraints[0].worst.value == pytest.approx(10, abs=1e-3)
    assert near.obeys


def test_clearances_and_constraints_are_kept_together() -> None:
    glass = SceneObject("g", "glass", (35, 50), None, Disc((35, 50), 4.0))
    scene = table(glass, person("p", 65, 50))
    known = rule({"feature": "distance", "of": "person", "value": 12.0}, glass=9.0)
    plan = plan_path(known, scene)
    points, _ = dense(plan.points)
    assert plan.obeys
    assert (np.hypot(*(points - [35, 50]).T) - 4).min() >= 9 - 1e-6
    assert (np.hypot(*(points - [65, 50]).T) - 4).min() >= 12 - 1e-6
    assert cost_map(known, scene).margin(plan.points).min() >= -1e-6


def test_a_users_own_feature_is_planned_by_trying() -> None:
    """It has no zone: the path must come as far as y = 80."""
    register_feature(
        Feature("northernmost", lambda m, scene, asked: float(m.xy[:, 1].max()), "length",
                ("at_least",))
    )  # fmt: skip
    plan = plan_path(rule({"feature": "northernmost", "value": 80.0}), table())
    assert plan.obeys
    assert plan.points[:, 1].max() >= 80
    (check,) = plan.check.constraints
    assert check.how == "check"


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(i, marks=pytest.mark.slow) for i in range(1, 8))]
)
def test_mixed_constraints_in_random_scenes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    people = [
        person(f"p{i}", *rng.uniform(25, 75, 2), float(rng.uniform(1, 4)), rng.uniform(0, 360))
        for i in range(4)
    ]
    keep, side, slow = rng.uniform(1, 5), rng.uniform(4, 9), rng.uniform(1, 4)
    known = rule(
        {"feature": "distance", "of": "person", "value": keep},
        {"feature": "distance", "of": "person", "value": side, "sector": "front"},
        {"feature": "edge", "value": 2.0},
        {"feature": "speed", "value": slow, "when": {"within": 10.0, "of": "person"}},
    )
    scene = table(*people, start=(5.0, 5.0), goal=(95.0, 95.0))
    plan = plan_path(known, scene)
    if not plan.found:
        assert plan.status == "infeasible"
        return
    assert plan.obeys
    assert plan.t is not None
    points, speed = dense(plan.points, plan.t)
    for p in people:
        away = points[:, :2] - p.center
        gap = np.hypot(*away.T) - p.outline.radius
        angle = np.radians(p.heading_deg)
        front = away @ [np.cos(angle), np.sin(angle)] >= 0
        assert gap.min() >= keep - 1e-6
        assert gap[front].min(initial=np.inf) >= side - 1e-6
        assert (speed[gap <= 10] <= slow).all()
    assert ((points >= 2 - 1e-6) & (points <= 98 + 1e-6)).all()


def test_height_and_speed_are_drawn_under_the_plan(tmp_path: Path) -> None:
    """A panel each, where the plan has them; none for a rule of distances."""
    import PIL.Image

    from demospec.report import draw_plan

    slow = {"feature": "speed", "value": 2.0, "when": {"within": 15.0, "of": "person"}}
    high = {"feature": "height", "value": 3.0, "sense": "at_least"}
    near = {"feature": "distance", "of": "person", "value": 5.0}
    heights = []
    for i, asked in enumerate([(near,), (near, slow), (near, slow, high)]):
        known, scene = rule(*asked), table(person("p", 50, 60))
        file = tmp_path / f"{i}.png"
        draw_plan(cost_map(known, scene), scene, plan_path(known, scene), file)
        with PIL.Image.open(file) as image:
            heights.append(image.size[1])
    assert heights[0] < heights[1] < heights[2]


@pytest.mark.parametrize("feature", ["speed", "dwell"])
def test_nothing_is_done_at_no_speed_or_in_no_time(feature: str) -> None:
    asked = {"feature": feature, "value": 0.0, "when": {"within": 5.0, "of": "person"}}
    with pytest.raises(InputError, match=f"a {feature} > 0"):
        plan_path(rule(asked), table(person("p", 50, 90)))
