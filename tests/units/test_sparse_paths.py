"""Paths of few points in metres: measured segment by segment, learned from as they are."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    densify,
)
from demospec.geometry import path_distance
from demospec.rules import ClearanceRule, RuleSet, TypeRules, learn_rules
from demospec.scene import Disc, Scene, SceneObject
from demospec.specification import audit_set, predict

CLEARANCE = 0.04


def table(paths: list[np.ndarray], factor: float = 1.0, units: str = "m") -> DemonstrationSet:
    """Paths past a glass of 5 cm, labelled by the exact distance of their segments."""
    shape = Disc((0.4 * factor, 0.3 * factor), 0.05 * factor)
    glass = SceneObject("g", "glass", shape.center, None, shape)
    scene = Scene("t", (0.05 * factor, 0.3 * factor), (0.75 * factor, 0.3 * factor), (glass,))
    items = []
    for i, path in enumerate(paths):
        gap, _ = path_distance(shape, path * factor)
        items.append(
            Demonstration(f"d{i}", "t", path * factor, "me", None, gap >= CLEARANCE * factor)
        )
    return DemonstrationSet(
        (scene,), Demonstrations.of(items), units=units, symbols=("glass",), types=("me",),
        metres_per_unit=None if units == "m" else 1 / factor,
    )  # fmt: skip


def six_points(seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    x = np.linspace(0.05, 0.75, 6)
    paths = []
    for _ in range(60):
        y = 0.3 + rng.uniform(-0.2, 0.2) * np.sin(np.pi * np.linspace(0, 1, 6))
        y[1:-1] += rng.normal(0, 0.01, 4)
        paths.append(np.column_stack([x, y]))
    return paths


def test_two_points_through_the_middle_of_a_glass_are_rejected() -> None:
    straight = np.array([[0.05, 0.3], [0.75, 0.3]])
    around = np.array([[0.05, 0.3], [0.4, 0.6], [0.75, 0.3]])
    for factor, units in ((1.0, "m"), (100.0, "cm"), (100.0, "px")):
        rule = ClearanceRule({"glass": CLEARANCE * factor})
        data = table([straight, densify(straight, 0.001), around], factor, units)
        rules = RuleSet({"me": TypeRules(rule)}, units, data.metres_per_unit)
        assert [p.p_valid for p in predict(rules, data).items] == [0.0, 0.0, 1.0]
        near = rule.margins(data.scenes[0], data.demonstrations.paths_xy()) / factor
        assert near[:2] == pytest.approx(-0.05 - CLEARANCE)


@pytest.mark.parametrize("seed", [0, 1])
def test_six_points_a_path_are_enough(seed: int) -> None:
    for factor, units in ((1.0, "m"), (400.0, "px")):
        data = table(six_points(seed), factor, units)
        rule = learn_rules(data, influence=False).rules["me"]
        assert rule.clearance is not None
        low, high = rule.clearance.interval["glass"]
        assert low <= CLEARANCE * factor <= high
        assert high - low < 0.03 * factor
        assert rule.evidence["contradicted"] == []
        found = audit_set(data).to_json()["demonstrations"]
        assert [e["verdict"] for e in found] == ["pass"] * 60


def test_ten_thousand_points_say_what_six_say() -> None:
    paths = six_points(2)[:12]
    dense = [densify(p, 1e-4) for p in paths]
    assert min(len(p) for p in dense) > 5_000
    few, many = (learn_rules(table(p), influence=False).rules["me"] for p in (paths, dense))
    assert few.clearance is not None
    assert many.clearance is not None
    assert many.sentence == few.sentence
    assert many.clearance.value["glass"] == pytest.approx(few.clearance.value["glass"], rel=1e-9)
    assert many.clearance.interval["glass"] == pytest.approx(
        few.clearance.interval["glass"], rel=1e-9
    )
