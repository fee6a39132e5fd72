"""The worst value of every feature, against dense sampling of paths and hand-made cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.demonstrations import Motion, Motions
from demospec.errors import InputError
from demospec.rules import (
    Constraint,
    Feature,
    PointFeature,
    RuleSet,
    TypeRules,
    When,
    broken_words,
    constraint_from_json,
    constraint_words,
    margin,
    read_rules,
    register_feature,
    rules_document,
    rules_from_document,
    rules_in_unit,
    worst,
)
from demospec.scene import Disc, MultiPolygon, Polygon, Relation, Scene, SceneObject

COLUMNS = ("x", "y", "z", "tilt")
L_SHAPE = Polygon([[0, 0], [20, 0], [20, 6], [6, 6], [6, 20], [0, 20]])


def some_scene(rng: np.random.Generator) -> Scene:
    shapes = [
        Disc((0.0, 0.0), float(rng.uniform(2, 8))),
        L_SHAPE.moved((-8.0, -8.0)),
        MultiPolygon([Polygon([[-6, -4], [2, -4], [-2, 5]]), Polygon([[0, 0], [7, 0], [7, 7]])]),
    ]
    objects = []
    for k in range(5):
        at = rng.uniform(15, 85, 2)
        objects.append(
            SceneObject(
                f"thing-{k}",
                "laptop" if k % 2 else "person",
                (float(at[0]), float(at[1])),
                None,
                shapes[k % 3].moved(at),
                heading_deg=float(rng.uniform(-180, 180)),
                height=(0.0, float(rng.uniform(2, 10))),
            )
        )
    relations = (Relation("interact", ("thing-0", "thing-2")),)
    regions = {"trap": [[30, 30], [70, 35], [50, 40], [60, 70]]}
    return Scene(
        "s", (0.0, 0.0), (100.0, 100.0), tuple(objects), relations=relations,
        extra=(("regions", {**regions, "table": [[-5, -5], [105, -5], [105, 105], [-5, 105]]}),),
    )  # fmt: skip


def some_motion(rng: np.random.Generator, n: int = 6) -> Motion:
    points = np.column_stack(
        [rng.uniform(0, 100, (n, 2)), rng.uniform(0, 30, n), rng.uniform(0, 40, n)]
    )
    return Motion(points, np.cumsum(rng.uniform(0.2, 2.0, n)), COLUMNS)


def dense(motion: Motion, pieces: int = 3000) -> Motion:
    """The same motion, sampled finely: speed between samples is what it was."""
    assert motion.t is not None
    u = np.linspace(0, 1, pieces, endpoint=False)[:, None]
    full = np.column_stack([motion.points, motion.t])
    parts = [full[i] + u * (full[i + 1] - full[i]) for i in range(len(full) - 1)]
    every = np.concatenate([*parts, full[-1:]])
    return Motion(every[:, :-1], every[:, -1], motion.columns)


def by_sampling(c: Constraint, scene: Scene, motion: Motion) -> float:
    fine = dense(motion)
    p, z, tilt = fine.points[:, :2], fine.points[:, 2], fine.points[:, 3]
    assert fine.t is not None
    step = np.hypot(*np.diff(p, axis=0).T)
    rate = step / np.diff(fine.t)

    def items(symbol: object) -> list[SceneObject]:
        return [o for o in scene.objects or () if o.symbol == symbol]

    gap = [o.outline.signed_distance(p) for o in items(c.of)]
    if c.feature == "distance" and c.sector:
        turn = {"front": 0, "back": 180, "left": -90, "right": 90, "-x": None}[c.sector]
        out = []
        for o, own in zip(items(c.of), gap, strict=True):
            angle = np.pi if turn is None else np.radians((o.heading_deg or 0.0) + turn)
            side = (p - o.center) @ [np.cos(angle), np.sin(angle)]
            out.append(np.where(side >= 0, own, np.inf).min())
        return float(np.min(out))
    if c.feature in ("distance", "near"):
        return float(np.min(gap))
    if c.feature == "between":
        a, b = (np.array(o.center) for o in ((scene.objects or ())[0], (scene.objects or ())[2]))
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return float(np.hypot(*(p - a - t[:, None] * (b - a)).T).min())
    if c.feature == "height":
        return float(z.min() if c.sense == "at_least" else z.max())
    if c.feature == "tilt":
        return float(tilt.max())
    if c.feature == "height_over":
        over = [
            np.where(own <= 0, z - (o.height or (0, 0))[1], np.inf).min()
            for o, own in zip(items(c.of), gap, strict=True)
        ]
        return float(np.min(over))
    if c.feature in ("speed", "dwell") and c.when:
        every = [o.outline.signed_distance(p) <= c.when.within for o in items(c.when.of)]
        if c.feature == "dwell":
            return float(max((np.diff(fine.t) * (e[1:] & e[:-1])).sum() for e in every))
        held = np.any(every, axis=0)
        held = held[1:] & held[:-1]
        return float(rate[held].max()) if held.any() else -np.inf
    if c.feature == "speed":
        return float(rate.max())
    if c.feature == "edge":
        return float(np.minimum(p + 5, 105 - p).min())
    trap = Polygon(dict(scene.extra)["regions"]["trap"]).signed_distance(p)
    return float(trap.min() if c.sense == "at_least" else trap.max())


ASKED = [
    Constraint("distance", "person"),
    *(Constraint("distance", "laptop", sector=s) for s in ("front", "back", "left", "right", "-x")),
    Constraint("near", "laptop", "at_most"),
    Constraint("between", "interact"),
    Constraint("height"),
    Constraint("height", sense="at_most"),
    Constraint("height_over", "laptop"),
    Constraint("tilt", sense="at_most", unit="deg"),
    Constraint("speed", sense="at_most", unit="px/s"),
    Constraint("speed", sense="at_most", unit="px/s", when=When(9.0, "person")),
    Constraint("dwell", "person", "at_most", unit="s", when=When(9.0, "person")),
    Constraint("dwell", "laptop", "at_most", unit="s", when=When(0.0, "laptop")),
    Constraint("edge"),
    Constraint("region", "trap"),
    Constraint("region", "trap", "at_most"),
]


@pytest.mark.parametrize("asked", ASKED, ids=lambda c: f"{c.name} {c.sense}")
def test_the_worst_value_is_that_of_a_densely_sampled_path(asked: Constraint) -> None:
    rng = np.random.default_rng(3)
    for _ in range(6):
        scene, motion = some_scene(rng), some_motion(rng)
        exact = worst(asked, scene, motion)
        sampled = by_sampling(asked, scene, motion)
        if not np.isfinite(sampled):
            assert exact.value == sampled or not np.isfinite(exact.value)
            continue
        # Sampling misses the worst by at most a step of it, and is never worse than exact.
        step = 0.1
        assert abs(exact.value - sampled) <= step, (exact, sampled)
        sign = 1.0 if asked.feature == "near" else asked.sign  # the nearest place counts
        assert sign * (exact.value - sampled) <= 1e-6 or asked.feature == "dwell"
        if exact.point is not None and asked.feature in ("distance", "near"):
            named = next(o for o in scene.objects or () if o.id == exact.objects[0])
            assert named.outline.signed_distance(exact.point) == pytest.approx(exact.value)


@pytest.mark.parametrize("asked", ASKED, ids=lambda c: f"{c.name} {c.sense}")
def test_sampling_a_path_more_densely_changes_nothing(asked: Constraint) -> None:
    if asked.feature == "speed":
        return  # a mean over a tenth of the segments is taken from ten segments on
    rng = np.random.default_rng(4)
    scene, motion = some_scene(rng), some_motion(rng)
    few, many = worst(asked, scene, motion), worst(asked, scene, dense(motion, 7))
    assert many.value == pytest.approx(few.value, abs=1e-6)


def test_speed_near_people_is_not_smeared_over_the_rim() -> None:
    """Fast up to the rim and slow inside: the limit inside is kept."""
    scene = Scene(
        "s", (0, 0), (100, 0),
        (SceneObject("person-0", "person", (50.0, 0.0), None, Disc((50.0, 0.0), 5.0)),),
    )  # fmt: skip
    x = np.concatenate([np.linspace(0, 35, 60), np.linspace(35, 65, 60)[1:], [100.0]])
    rate = np.where(np.arange(len(x) - 1) < 59, 40.0, 10.0)
    rate[-1] = 40.0
    t = np.concatenate([[0.0], np.cumsum(np.diff(x) / rate)])
    c = Constraint("speed", None, "at_most", 10.0, unit="px/s", when=When(10.0 - 1e-9, "person"))
    found = worst(c, scene, np.column_stack([x, 0 * x]), t)
    assert found.value == pytest.approx(10.0)
    assert found.objects == ("person-0",)
    assert worst(replace(c, when=None), scene, np.column_stack([x, 0 * x]), t).value > 39


def test_what_a_path_does_not_hold_is_not_measured_and_the_verdict_is_unknown() -> None:
    rng = np.random.default_rng(0)
    scene, motion = some_scene(rng), some_motion(rng)
    asked = Constraint("tilt", None, "at_most", 90.0, unit="deg")
    assert np.isnan(margin(asked, scene, motion.points[:, :2]))
    view = RuleSet({"p": TypeRules(constraints=(asked,))}).see(scene)
    assert view.verdicts([motion.points[:, :2]], "p") == ["unknown"]
    assert view.verdicts(Motions([motion]), "p") == ["accept"]
    assert view.p_valid(Motions([motion]), "p").tolist() == [1.0]
    strict = RuleSet({"p": TypeRules(constraints=(replace(asked, value=0.1),))}).see(scene)
    assert strict.verdicts(Motions([motion]), "p") == ["reject"]


def test_a_rule_file_of_constraints_is_read_and_written_again(tmp_path) -> None:
    import json

    rule = {
        "types": {
            "courier": {
                "constraints": [
                    {"feature": "tilt", "sense": "at_most", "value": 12, "unit": "deg"},
                    {"feature": "speed", "value": 0.25, "unit": "m/s",
                     "when": {"within": 0.25, "of": "person"}},
                    {"feature": "between", "of": "interact", "value": 20},
                ]
            }
        },
        "units": "px", "metres_per_unit": 0.01,
    }  # fmt: skip
    file = tmp_path / "rule.json"
    file.write_text(json.dumps(rule))
    rules = read_rules(file)
    tilt, speed, between = rules.of_type("courier").constraints
    assert (tilt.value, speed.value, speed.unit) == (12, 25.0, "px/s")
    assert speed.when == When(25.0, "person")
    assert between.sense == "at_least"
    assert rules.types == ("courier",)
    sentence = rules.of_type("courier").sentence
    assert "keeps its tilt at most 12°" in sentence
    assert "moves at most 25 cm/s within 25 cm of people" in sentence
    again = rules_from_document(rules_document(rules))
    assert again.of_type("courier").constraints == rules.of_type("courier").constraints
    metres = rules_in_unit(rules, "m", 1.0).of_type("courier").constraints
    assert metres[1].value == pytest.approx(0.25)
    assert metres[1].unit == "m/s"
    assert metres[1].when == When(pytest.approx(0.25), "person")
    assert metres[0].value == 12


@pytest.mark.parametrize(
    ("broken", "field"),
    [
        ({"feature": "colour", "value": 1}, "feature"),
        ({"feature": "tilt", "sense": "at_least", "value": 1}, "sense"),
        ({"feature": "tilt"}, "value"),
        ({"feature": "tilt", "value": 1, "unit": "m"}, "unit"),
        ({"feature": "height", "value": 1, "unit": "cm"}, "unit"),
        ({"feature": "tilt", "value": 1, "of": "cup"}, "of"),
        ({"feature": "distance", "value": 1}, "of"),
        ({"feature": "distance", "of": "cup", "value": 1, "sector": "up"}, "sector"),
        ({"feature": "edge", "value": 1, "sector": "front"}, "sector"),
        ({"feature": "length", "value": 1, "when": {"within": 1, "of": "cup"}}, "when"),
        ({"feature": "speed", "value": 1, "when": {"within": -1, "of": "cup"}}, "when.within"),
        ({"feature": "length", "value": 1, "interval": [2, 1]}, "interval"),
        ({"feature": "between", "of": ["cup"], "value": 1}, "of"),
        ([], ""),
    ],
)
def test_a_broken_constraint_is_refused_in_one_line(broken, field) -> None:
    document = {"types": {"p": {"constraints": [broken]}}}
    with pytest.raises(InputError) as caught:
        rules_from_document(document)
    assert caught.value.field is not None
    assert caught.value.field.endswith(f"constraints[0].{field}".removesuffix("."))
    assert "\n" not in str(caught.value)


def test_words_of_a_broken_constraint_name_the_place() -> None:
    scene = Scene(
        "s", (0, 0), (100, 0),
        (SceneObject("person-0", "person", (63.0, 10.0), None, Disc((63.0, 10.0), 2.0)),),
    )  # fmt: skip
    c = Constraint("speed", None, "at_most", 25.0, unit="px/s", when=When(25.0, "person"))
    x = np.array([0.0, 60.0, 66.0, 100.0])
    t = np.cumsum([0.0, 60 / 20.0, 6 / 41.0, 34 / 20.0])
    found = worst(c, scene, np.column_stack([x, 0 * x]), t)
    assert broken_words(found, "px", 0.01) == (
        "at 63 % of the way: 41 cm/s within 25 cm of person-0; at most 25 cm/s would be accepted"
    )
    tilt = Constraint("tilt", None, "at_most", 12.0, (10.0, 14.0), "deg")
    assert constraint_words(tilt) == "keeps its tilt at most 12° (10 to 14)"


def test_a_feature_of_ones_own_is_registered_in_ten_lines() -> None:
    def rightmost(motion: Motion, scene: Scene, asked: Constraint) -> float:
        return float(motion.xy[:, 0].max())

    feature = Feature("test_rightmost", rightmost, "length", ("at_most",))
    register_feature(feature)
    register_feature(feature)
    with pytest.raises(InputError):
        register_feature(replace(feature, unit="deg"))
    with pytest.raises(InputError):
        register_feature(PointFeature("height", "something else {value} {name}"))
    c = constraint_from_json({"feature": "test_rightmost", "value": 80}, "c")
    scene = Scene("s", (0, 0), (100, 0), ())
    assert margin(c, scene, [[0.0, 0.0], [90.0, 0.0]]) == -10.0
    assert constraint_words(c) == "keeps its test rightmost at most 80 px"
