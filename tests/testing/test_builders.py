"""`demospec.testing`: builders keep the rules they state, in every unit; the contract can fail."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from demospec import testing
from demospec.demonstrations import DemonstrationSet, read_set
from demospec.frames import FloatArray
from demospec.geometry import Footprint
from demospec.rules import (
    RuleProblem,
    RuleSet,
    evaluate_rule,
    nearest_approach,
    rules_from_document,
)
from demospec.scene import Scene
from demospec.testing import strategies

RULES = {"careful": {"plate": 4.0, "glass": 6.0}, "free": {}}


@pytest.mark.parametrize("scale", [1.0, 0.0082, 100.0])
def test_a_demonstrator_set_keeps_its_rules_in_every_unit(scale: float) -> None:
    one, other = (
        testing.demonstrator_set(np.random.default_rng(3), RULES, 4, 10, scale=k)
        for k in (1.0, scale)
    )
    a, b = one.demonstrations, other.demonstrations
    assert np.array_equal(a.valid, b.valid)
    assert 0.1 < (a.valid[a.type == "careful"] == 1).mean() < 0.9
    assert (a.valid[a.type == "free"] == 1).all()
    np.testing.assert_allclose(a.flat * scale, b.flat)
    for i in range(len(b)):  # the oracle: dense samples against the outlines
        scene = other.scene(b.scene_id[i])
        gaps = {
            o.id: float(o.outline.signed_distance(b.points(i)).min()) / scale
            for o in scene.listed_objects()
        }
        rule = RULES[b.type[i]]
        keep = all(gaps[o.id] >= rule.get(o.symbol, -99) for o in scene.listed_objects())
        near = any(abs(gaps[o.id] - rule.get(o.symbol, -99)) < 0.3 for o in scene.listed_objects())
        assert near or keep == bool(b.valid[i])


def test_a_small_set_is_readable(tmp_path) -> None:
    folder = testing.write_small_set(tmp_path / "set", 5, t=True)
    data = read_set(folder)
    assert len(data.demonstrations) == 5
    assert data.types == ("careful", "normal")
    again = testing.with_labels(data, [1, 0, -1, 1, 0])
    assert again.demonstrations.valid.tolist() == [1, 0, -1, 1, 0]
    assert data.demonstrations.valid.tolist() != again.demonstrations.valid.tolist()


@given(problem=strategies.rule_problems())
@settings(max_examples=30, deadline=None)
def test_problems_survive_their_documents(problem: RuleProblem) -> None:
    from demospec.rules import problem_from_document

    document = testing.problem_document(problem)
    assert testing.problem_document(problem_from_document(document)) == document


def test_labels_are_those_of_a_rule_but_for_the_share_that_is_turned() -> None:
    exact = [testing.random_problem(seed, flip=0.0) for seed in range(40)]
    turned = [testing.random_problem(seed, flip=1.0) for seed in range(40)]
    differ = [
        a.valid != b.valid
        for one, other in zip(exact, turned, strict=True)
        for a, b in zip(one.trajectories, other.trajectories, strict=True)
    ]
    assert np.mean(differ) > 0.75  # the others were never labelled by a rule
    one = exact[1]
    assert len(evaluate_rule(one, 1, dict.fromkeys(one.parameters, 1))) == len(one.trajectories)


@given(
    shape=strategies.footprints(),
    scene=strategies.scenes(),
    paths=strategies.paths(),
    data=strategies.demonstration_sets(),
)
@settings(max_examples=20, deadline=None)
def test_strategies_give_valid_data(
    shape: Footprint, scene: Scene, paths: FloatArray, data: DemonstrationSet
) -> None:
    assert np.isfinite(shape.signed_distance(paths)).all()
    assert np.isfinite(nearest_approach(scene, paths, testing.SYMBOLS[-1:])).all()
    assert set(data.demonstrations.type) <= set(data.types)
    assert data.metres_per_unit is not None
    extent = max(s.length_scale for s in data.scenes) * data.metres_per_unit
    assert 0.4 < extent < 1.0  # metres: the same table in every unit


def test_the_contract_holds_for_formulas_and_rules() -> None:
    scene = testing.disc_scene((40, 60, 8), (70, 30, 5))
    paths = testing.random_paths(np.random.default_rng(0), 12)
    testing.check_model(testing.DiscModel(), scene, paths)
    rules: RuleSet = rules_from_document({"types": {"one": {"clearance": {"glass": 4.0}}}})
    testing.check_model(rules, scene, paths)


def test_the_contract_can_fail() -> None:
    scene = testing.disc_scene((40, 60, 8))
    paths = testing.random_paths(np.random.default_rng(0), 12)

    class Steep(testing.SlopedDiscView):
        def logits_and_gradients(self, paths, type):
            logits, slope = super().logits_and_gradients(paths, type)
            return logits, 2.0 * slope

    class Wrong(testing.DiscModel):
        def see(self, scene: Scene) -> testing.SlopedDiscView:
            return Steep(scene, self.keep)

    with pytest.raises(AssertionError, match="careful: gradients"):
        testing.check_model(Wrong(), scene, paths)
    flipped = testing.FormulaModel(lambda scene, paths, type_: np.full(len(paths), 1.5))
    with pytest.raises(AssertionError, match=r"one: p_valid lies in \[0, 1\]"):
        testing.check_model(flipped, scene, paths)
    with pytest.raises(AssertionError, match="no type"):
        testing.check_model(testing.FormulaModel(lambda *_: np.zeros(0), ()), scene, paths)
