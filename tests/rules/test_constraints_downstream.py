"""Constraints in what follows learning: the posterior, gradients, causes, audits, tables."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.causal import Settings, checked, estimate, trials_of_set
from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, edit, write_set
from demospec.errors import InputError
from demospec.rules import (
    ClearanceRule,
    Constraint,
    RuleSet,
    TypeRules,
    When,
    learn_rules,
    rules_document,
    simulate_by_rule,
)
from demospec.scene import Disc, Scene, SceneObject
from demospec.specification import RepairSettings, audit_set, repair_set

BETWEEN = Constraint("between", ("cup", "bowl"), "at_least", 5.0, interval=(4.0, 6.0))
EDGE = Constraint("edge", None, "at_least", 5.0)
SLOW = Constraint(
    "speed", None, "at_most", 18.0, interval=(17.0, 19.0), unit="px/s", when=When(15.0, "glass")
)
OVER = Constraint("height_over", "plate", "at_least", 8.0, interval=(7.0, 9.0))
UPRIGHT = Constraint("tilt", None, "at_most", 15.0, interval=(14.0, 16.0), unit="deg")


def table() -> Scene:
    items = [
        SceneObject("a", "cup", (40.0, 30.0), None, Disc((40.0, 30.0), 3.0)),
        SceneObject("b", "bowl", (60.0, 70.0), None, Disc((60.0, 70.0), 3.0)),
    ]
    return Scene("s", (10.0, 50.0), (90.0, 50.0), objects=tuple(items))


def rules_of(*constraints: Constraint, clearance: ClearanceRule | None = None) -> RuleSet:
    return RuleSet({"p": TypeRules(clearance, constraints=constraints)}, "px", 0.0082)


def set_of(*constraints: Constraint, scenes: int = 8) -> DemonstrationSet:
    rules = rules_of(*constraints)
    return simulate_by_rule(rules, train_scenes=scenes, test_scenes=0, demonstrations=9, seed=5)[0]


def test_rules_drawn_from_the_posterior_keep_the_constraints() -> None:
    nothing = ClearanceRule({}, draws=({},) * 40)
    view = rules_of(BETWEEN, clearance=nothing).see(table())
    away = 4.9  # from the line that joins them, at its lower end
    across = np.array([[10.0, 50.0], [90.0, 50.0]])
    beside = np.array([[10.0, 30.0 - away], [44.0, 30.0 - away]])
    accepted = view.by_draw([across, beside], "p")
    assert accepted.shape == (40, 2)
    assert not accepted[:, 0].any()
    # Values are drawn evenly from 4 to 6: of those, 45 % are kept at a distance of 4.9.
    assert accepted[:, 1].mean() == pytest.approx(0.45, abs=0.03)


@pytest.mark.parametrize("constraint", [BETWEEN, EDGE, Constraint("length", None, "at_most", 90.0)])
def test_gradients_of_constraints_agree_with_what_paths_gain(constraint: Constraint) -> None:
    scene = replace(table(), extra={"regions": {"table": [[0, 0], [100, 0], [100, 100], [0, 100]]}})
    view = rules_of(constraint).see(scene)
    rng = np.random.default_rng(3)
    for _ in range(5):
        path = np.stack([np.linspace(12, 90, 12), 8.0 + 20 * rng.random(12)], axis=1)
        value, slope = view.logits_and_gradients(path[None], "p")
        assert np.isfinite(slope).all()
        assert np.abs(slope).max() > 0
        step = 1e-4 * rng.standard_normal(path.shape)
        after = view.logits((path + step)[None], "p")
        assert after[0] - value[0] == pytest.approx((slope[0] * step).sum(), abs=2e-6)


def test_a_clearance_and_a_constraint_share_the_gradient_of_the_least_kept() -> None:
    clearance = ClearanceRule({"cup": 4.0})
    scene = table()
    near_cup = np.array([[[10.0, 24.5], [40.0, 24.5], [44.0, 24.5]]])
    both = rules_of(BETWEEN, clearance=clearance).see(scene)
    alone = rules_of(clearance=clearance).see(scene)
    assert np.allclose(
        both.logits_and_gradients(near_cup, "p")[1], alone.logits_and_gradients(near_cup, "p")[1]
    )


@pytest.mark.parametrize(("asked", "cause"), [(SLOW, "glass"), (OVER, "plate")])
def test_causes_are_asked_of_paths_that_have_heights_and_times(
    asked: Constraint, cause: str
) -> None:
    data = set_of(asked)
    rules = rules_of(asked, UPRIGHT)
    settings = Settings(placements=4, draws=12, interventions=("add",))
    table = trials_of_set(rules, data, settings=settings)
    assert any("heights, tilts and times" in note for note in table.notes)
    findings = checked(estimate(table, settings), rules, data.scenes)
    avoided = {c.symbol for c in findings.effects if c.effect < -0.01}
    assert avoided == {cause}
    assert not any(c.effect > 0 for c in findings.effects)
    assert any("whatever stands there" in sentence for sentence in findings.sentences)


def test_added_things_have_the_height_and_heading_of_their_kind() -> None:
    from demospec.causal import editor_for

    front = Constraint("distance", "glass", "at_least", 8.0, sector="front")
    data = set_of(OVER, front, scenes=3)
    editor = editor_for(data.scenes)
    scene = data.scenes[0]
    after = editor.templates("plate", scene)[0].put(scene, (50.0, 50.0), 1.0)
    (new,) = (o for o in after.objects or () if o not in (scene.objects or ()))
    assert new.height in [o.height for s in data.scenes for o in s.objects or ()]
    assert new.heading_deg == pytest.approx(60.0)


def test_wrong_labels_are_found_under_constraints_and_right_ones_left_alone() -> None:
    data = set_of(UPRIGHT, scenes=10)
    d = data.demonstrations
    tilts = np.array([m.column("tilt").max() for m in data.motions(range(len(d))).motions])
    clear = np.flatnonzero(np.abs(tilts - 15.0) > 4.0)
    wrong = [int(clear[5]), int(clear[-9])]
    flipped = edit.relabel(
        data, {str(d.demo_id[i]): {"valid": bool(d.valid[i] == 0)} for i in wrong}
    )
    found = audit_set(flipped)
    reviewed = {e.demo_id: e.why for e in found.entries if e.verdict == "review"}
    assert {str(d.demo_id[i]) for i in wrong} <= set(reviewed)
    assert len(reviewed) <= 4
    for i in wrong:
        why = reviewed[str(d.demo_id[i])]
        assert "tilt" in why
        assert "°" in why
    (asked,) = found.constraints["p"]
    assert asked.feature == "tilt"
    assert found.to_json()["types"]["p"]["constraints"][0]["feature"] == "tilt"


def test_a_side_that_is_not_known_matters_only_where_it_could_be_nearest() -> None:
    front = Constraint("distance", "cup", "at_least", 8.0, sector="front")
    scene = table()
    one, other = scene.listed_objects()
    far = replace(other, symbol="cup")
    known = replace(scene, objects=(replace(one, heading_deg=90.0), far))
    path = np.array([[30.0, 38.0], [50.0, 38.0]])
    view = rules_of(front).see(known)
    assert view.margins([path], "p")[0, 0] == pytest.approx(-3.0)
    nearer = path + np.array([15.0, 20.0])
    assert np.isnan(view.margins([nearer], "p")[0, 0])


def test_the_words_and_the_page_of_a_run_speak_of_constraints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules = rules_of(SLOW)
    data, truth = simulate_by_rule(rules, train_scenes=8, test_scenes=0, demonstrations=9, seed=5)
    write_set(data, tmp_path / "set")
    (tmp_path / "set" / "truth.json").write_text(json.dumps(truth))
    learned = learn_rules(data, influence=False)
    (tmp_path / "rules.json").write_text(json.dumps(rules_document(learned)))
    with pytest.raises(SystemExit, match="0"):
        main(["rules", str(tmp_path / "set"), "--no-influence"])
    out = " ".join(capsys.readouterr().out.split())
    assert "Constraints type constraint chance" in out
    assert "> 99 %" in out
    scene = data.scenes[0].scene_id
    with pytest.raises(SystemExit, match="0"):
        main(["plan", str(tmp_path / "rules.json"), str(tmp_path / "set"), "--scene", scene])
    out = capsys.readouterr().out
    assert "px/s" not in out
    assert "to spare" in out or "comes to nothing" in out
    with pytest.raises(SystemExit, match="0"):
        main(["report", str(tmp_path)])
    page = (tmp_path / "report.html").read_text()
    assert "where a rejected path breaks the rule most" in page
    assert 'class="cross"' in page
    assert "is known: p moves at most 15 cm/s" in page
    assert "keeps no distance from what is listed" not in page


@pytest.mark.parametrize("asked", [SLOW, OVER, UPRIGHT])
def test_curves_are_not_said_to_be_repaired_in_what_they_do_not_hold(asked: Constraint) -> None:
    with pytest.raises(InputError, match="a repair knows no heights, tilts or times"):
        repair_set(rules_of(asked), set_of(asked, scenes=3), "p")


def test_curves_are_repaired_beside_a_line_between_things() -> None:
    asked = Constraint("between", ("glass", "plate"), "at_least", 5.0)
    data = set_of(asked, scenes=2)
    few = data.select(np.flatnonzero(data.demonstrations.valid == 0)[:3])
    rules = rules_of(asked)
    done = repair_set(rules, few, "p", rules=rules, settings=RepairSettings(particles=6, steps=12))
    assert len(done.items) == 3
    for item in done.items:
        assert item.moved > 0
        assert item.rule_valid
