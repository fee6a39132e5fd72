"""One trajectory, one place, one boundary: counterfactuals, effect maps, z_θ, agreement."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.causal import (
    Settings,
    agreement,
    boundary_shift,
    but_for,
    effect_map,
    find_causes,
    rules_of_causes,
)
from demospec.demonstrations import fit_bezier
from demospec.errors import CannotJudgeError, InputError
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Scene, SceneObject

START, GOAL = (10.0, 90.0), (90.0, 10.0)
STRAIGHT = np.array([START, GOAL])


def table_with(**discs: tuple[str, float, float]) -> Scene:
    items = tuple(
        SceneObject(name, symbol, (x, y), None, Disc((x, y), 4.0))
        for name, (symbol, x, y) in discs.items()
    )
    return Scene("a", START, GOAL, items)


def test_the_object_without_which_the_verdict_flips(truth) -> None:  # type: ignore[no-untyped-def]
    scene = table_with(cup=("glass", 50.0, 50.0), dish=("plate", 20.0, 20.0))
    found = but_for(truth, scene, STRAIGHT, "normal")
    assert found.p_valid == 0.0
    assert found.causes == ("cup",)
    assert found.without[0].p_valid == 1.0
    assert not found.without[1].flips
    assert found.sentence == (
        "normal rejects this path (p = 0.00); had cup not been there, normal would accept it "
        "(p = 1.00)."
    )
    assert found.to_json()["causes"] == ["cup"]


def test_two_objects_that_each_forbid_the_path(truth) -> None:  # type: ignore[no-untyped-def]
    scene = table_with(cup=("glass", 30.0, 70.0), mug=("glass", 70.0, 30.0))
    found = but_for(truth, scene, STRAIGHT, "careful")
    assert found.causes == ()
    assert found.empty_p_valid == 1.0
    assert "all together do" in found.sentence


def test_a_path_that_nothing_decides(truth) -> None:  # type: ignore[no-untyped-def]
    scene = table_with(cup=("glass", 20.0, 20.0))
    found = but_for(truth, scene, STRAIGHT, "aggressive")
    assert found.causes == ()
    assert found.p_valid == found.empty_p_valid == 1.0
    assert "by at most 0.00" in found.sentence
    with pytest.raises(CannotJudgeError):
        but_for(truth, replace(scene, objects=None), STRAIGHT, "careful")


def test_effect_map_knows_where_it_matters(truth) -> None:  # type: ignore[no-untyped-def]
    corners = {"edge": ("bowl", 4.0, 4.0), "far": ("bowl", 96.0, 96.0)}
    scene = table_with(cup=("glass", 40.0, 20.0), dish=("plate", 75.0, 75.0), **corners)
    found = effect_map(truth, scene, "glass", "normal", grid=12, draws=150)
    assert found.effect.shape == (12, 12)
    assert np.nanmin(found.effect) < -0.2
    assert np.nanmax(found.effect) <= 0.0
    x, y = found.strongest or (0.0, 0.0)
    assert abs((x - 10) + (y - 90)) / np.sqrt(2) < 30  # near the line of most paths
    for row, column in np.argwhere(np.isnan(found.effect)):
        place = (found.x[column], found.y[row])
        near = min(float(o.outline.signed_distance(place)) for o in scene.listed_objects())
        ends = min(np.hypot(place[0] - e[0], place[1] - e[1]) for e in (START, GOAL))
        at_rim = min(place[0], place[1], 100 - place[0], 100 - place[1]) < 5
        assert near < 6.0 or ends < 12.1 or at_rim
    nothing = effect_map(truth, scene, "plate", "normal", grid=6, draws=20)
    assert np.nanmax(np.abs(nothing.effect)) == 0.0
    with pytest.raises(InputError, match="found vase"):
        effect_map(truth, scene, "vase", "normal")


def test_boundary_of_a_circle_in_control_space(formula_model) -> None:  # type: ignore[no-untyped-def]
    """Invalid inside a circle of z_θ, larger after: lines, areas and losses are known."""
    scene = table_with(cup=("glass", 50.0, 50.0), a=("bowl", 0.0, 0.0), b=("bowl", 100.0, 100.0))

    def model(radius):  # type: ignore[no-untyped-def]
        def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
            z = np.array([fit_bezier(p, refine=0)[0] for p in paths])
            return (np.hypot(z[:, 0] - 50, z[:, 1] - 50) > radius).astype(float)

        return formula_model(formula).see(scene)

    found = boundary_shift(model(20.0), model(30.0), "one", grid=31)
    side = found.high[0] - found.low[0]
    step = side / 30
    for boundary, radius in ((found.before, 20.0), (found.after, 30.0)):
        assert len(boundary.lines) == 1
        gap = np.hypot(*(boundary.lines[0] - 50).T) - radius
        assert np.abs(gap).max() < step / 32
        assert boundary.area == pytest.approx(1 - np.pi * radius**2 / side**2, abs=0.02)
    assert found.gained == 0.0
    assert found.lost == pytest.approx(np.pi * (30**2 - 20**2) / side**2, abs=0.02)
    assert found.distance == pytest.approx(10.0, abs=step / 8)


def test_boundary_shift_agrees_with_the_effect(truth) -> None:  # type: ignore[no-untyped-def]
    before = table_with(dish=("plate", 20.0, 20.0), x=("bowl", 4.0, 4.0), y=("bowl", 96.0, 96.0))
    cup = SceneObject("cup", "glass", (55.0, 60.0), None, Disc((55.0, 60.0), 4.0))
    after = before.with_changes(objects=(*before.listed_objects(), cup), picture=None)
    found = boundary_shift(truth.see(before), truth.see(after), "normal")
    assert found.before.area == 1.0
    assert found.before.lines == ()
    assert len(found.after.lines) >= 1
    assert found.lost == pytest.approx(1 - found.after.area)


def test_agreement_counts_and_names_what_differs(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = find_causes(truth, scenes, settings=Settings(placements=3, draws=60))
    same = agreement(found, truth)
    assert same.score == 1.0
    assert same.n_cells == 12
    assert same.disagreements == ()
    other = RuleSet(
        {
            "careful": TypeRules(ClearanceRule({"plate": 3.0, "bowl": 3.0, "utensil": 3.0})),
            "normal": TypeRules(ClearanceRule({"bowl": 7.5}, uninformed=("plate",))),
        }
    )
    differ = agreement(found, other)
    named = {(d.type, d.symbol): d.kind for d in differ.disagreements}
    assert named == {
        ("careful", "glass"): "only the model",
        ("normal", "glass"): "only the model",
        ("normal", "bowl"): "only the rules",
    }
    assert differ.n_cells == 7
    assert differ.score == pytest.approx(4 / 7)
    assert "normal/plate: no demonstration informs the rule" in differ.open
    assert any("7.5 px" in d.why for d in differ.disagreements)
    assert differ.to_json()["score"] == differ.score


def test_rules_keep_what_is_causal_undecided_or_untried(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = find_causes(truth, scenes, settings=Settings(placements=2, draws=40))
    learned = RuleSet(
        {
            "careful": TypeRules(ClearanceRule({"plate": 3.0, "bowl": 3.0, "lamp": 2.0})),
            "normal": TypeRules(
                ClearanceRule({"glass": 3.0, "bowl": 2.0}, {"bowl": (1.0, 3.0)}), sentence="old"
            ),
            "stranger": TypeRules(ClearanceRule({"plate": 1.0})),
        }
    )
    cut = rules_of_causes(learned, found)
    assert cut.rules["careful"] == learned.rules["careful"]
    assert cut.rules["stranger"] == learned.rules["stranger"]
    normal = cut.rules["normal"]
    assert normal.clearance is not None
    assert normal.clearance.value == {"glass": 3.0}
    assert normal.clearance.interval == {}
    assert normal.sentence == "normal keeps 3 px from glasses."
    assert "normal: no causal effect, left out: bowls" in cut.notes
    assert any(n.startswith("careful: glasses are causal for the model, but") for n in cut.notes)
    assert any(n.startswith("stranger: not asked about") for n in cut.notes)


def test_single_cases_are_drawn(truth, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import PIL.Image

    from demospec.report import (
        draw_boundary_shift,
        draw_counterfactual,
        draw_counterfactual_strip,
        draw_effect_map,
        save_figure,
    )

    scene = table_with(cup=("glass", 50.0, 50.0), a=("bowl", 4.0, 4.0), b=("bowl", 96.0, 96.0))
    bare = scene.with_changes(objects=scene.listed_objects()[1:], picture=None)
    case = but_for(truth, scene, STRAIGHT, "careful")
    figures = {
        "map": draw_effect_map(
            effect_map(truth, scene, "glass", "normal", grid=5, draws=10), scene
        ),
        "boundary": draw_boundary_shift(
            boundary_shift(truth.see(bare), truth.see(scene), "careful", grid=11), scene
        ),
        "case": draw_counterfactual(case, scene, STRAIGHT),
        "strip": draw_counterfactual_strip(
            [scene, bare], [0.0, 1.0], STRAIGHT, ["as it is", "without cup"]
        ),
    }
    for name, figure in figures.items():
        save_figure(figure, tmp_path / f"{name}.png")
        with PIL.Image.open(tmp_path / f"{name}.png") as picture:
            assert len(set(np.asarray(picture.convert("L")).ravel().tolist())) > 20
    text = " ".join(t.get_text() for t in figures["case"].axes[0].texts)
    assert "without cup: p = 1.00" in text
    titles = [axes.get_title() for axes in figures["strip"].axes]
    assert titles == [
        "as it is\nrejected, p(valid) = 0.00",
        "without cup\naccepted, p(valid) = 1.00",
    ]
