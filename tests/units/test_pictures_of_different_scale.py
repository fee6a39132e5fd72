"""Pictures of different scale: learned from together in metres, judged and planned each in its own
pixels, refused where a scale is missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from unit_worlds import as_set, world

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, edit, in_one_unit, read_set, write_set
from demospec.errors import CannotJudgeError, InputError
from demospec.planning import export_request, plan_path
from demospec.rules import ClearanceRule, RuleSet, TypeRules, learn_rules, query_set, rules_for_set
from demospec.specification import audit_set, predict

PER_METRE = (400.0, 1200.0)


@pytest.fixture(scope="module")
def metres() -> DemonstrationSet:
    return as_set(world(4), "m")


@pytest.fixture(scope="module")
def mixed(metres: DemonstrationSet) -> DemonstrationSet:
    """Its first scene at 400 px a metre, its second at 1200."""
    parts = []
    for scene, factor in zip(metres.scenes, PER_METRE, strict=True):
        rows = metres.demonstrations.scene_id == scene.scene_id
        alone = replace(metres, scenes=(scene,), demonstrations=metres.demonstrations.rows(rows))
        parts.append(edit.rescale(alone, factor, units="px"))
    return edit.merge(parts)


def test_they_are_learned_from_together_in_metres(
    mixed: DemonstrationSet, metres: DemonstrationSet
) -> None:
    assert [mixed.scale_of(s) for s in mixed.scenes] == [1 / f for f in PER_METRE]
    found = learn_rules(mixed, influence=False)
    assert (found.units, found.metres_per_unit) == ("m", 1.0)
    expected = learn_rules(metres, influence=False)
    for name, rule in expected.rules.items():
        assert rule.clearance is not None
        assert found.rules[name].sentence == rule.sentence
        assert found.rules[name].clearance.value == pytest.approx(  # type: ignore[union-attr]
            rule.clearance.value, rel=1e-9
        )
    assert audit_set(mixed).to_json()["conflict"] == audit_set(metres).to_json()["conflict"]


def test_each_scene_is_judged_and_planned_in_its_own_pixels(
    mixed: DemonstrationSet, metres: DemonstrationSet
) -> None:
    in_metres = learn_rules(metres, influence=False)
    rules = rules_for_set(in_metres, mixed)
    assert [p.p_valid for p in predict(rules, mixed).items] == [
        p.p_valid for p in predict(in_metres, metres).items
    ]
    for scene, plain, factor in zip(mixed.scenes, metres.scenes, PER_METRE, strict=True):
        plan, same = plan_path(rules, scene, "second"), plan_path(in_metres, plain, "second")
        assert plan.obeys
        np.testing.assert_allclose(plan.points / factor, same.points, rtol=1e-9)
        request = export_request(rules, scene, "second", axes=mixed.axes)
        direct = export_request(in_metres, plain, "second")
        assert request.scale_m == pytest.approx(1 / factor)
        ways = [r.frame.to_metres(r.timed_path()[1]) for r in (request, direct)]
        np.testing.assert_allclose(ways[0], ways[1], rtol=1e-9)


def test_a_question_is_asked_in_the_pixels_of_its_scene(
    mixed: DemonstrationSet, metres: DemonstrationSet
) -> None:
    found, expected = (query_set(d, type="first", pool=40) for d in (mixed, metres))
    assert (found.status, found.scene) == (expected.status, expected.scene)
    assert found.points is not None
    scale = mixed.scale_of(mixed.scene(str(found.scene)))
    np.testing.assert_allclose(found.points * scale, expected.points, rtol=1e-9)


def test_one_without_a_scale_is_refused_beside_others(
    mixed: DemonstrationSet, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bare = replace(mixed, metres_per_unit=None)
    for refused in (learn_rules, audit_set, query_set):
        with pytest.raises(InputError, match="scene s0, metres_per_unit"):
            refused(bare)  # type: ignore[operator]
    write_set(bare, tmp_path / "s")
    with pytest.raises(SystemExit) as stopped:
        main(["rules", str(tmp_path / "s")])
    assert stopped.value.code == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "--ruler" in said
    assert read_set(tmp_path / "s") == bare


def test_rules_without_a_scale_do_not_judge_a_picture_that_has_its_own(
    mixed: DemonstrationSet,
) -> None:
    rules = RuleSet({"first": TypeRules(ClearanceRule({"glass": 5.0}))})
    with pytest.raises(CannotJudgeError, match="rules with a scale"):
        rules.see(mixed.scenes[1])


def test_one_scale_said_scene_by_scene_is_the_set_s(metres: DemonstrationSet) -> None:
    data = edit.rescale(metres, 250.0, units="px")
    scenes = tuple(replace(s, metres_per_unit=data.metres_per_unit) for s in data.scenes)
    again = in_one_unit(replace(data, metres_per_unit=None, scenes=scenes))
    assert again == data
