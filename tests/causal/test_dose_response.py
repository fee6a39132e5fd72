"""Effect against distance: the shape that a known clearance gives, bands; unrelated things."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from demospec.causal import (
    CausalFindings,
    Settings,
    find_causes,
    findings_from_document,
    run_trials,
    to_arrow,
)
from demospec.demonstrations import Paths
from demospec.frames import FloatArray
from demospec.rules import ClearanceRule, RuleSet, TypeRules, nearest_approach
from demospec.scene import Disc, Scene, SceneObject
from demospec.testing import FormulaModel

KEPT = 6.0
SETTINGS = Settings(placements=3, draws=60)


def table(seed: int) -> Scene:
    """A table of 100 × 100 with one plate and one glass at places of their own."""
    rng = np.random.default_rng(seed)
    spots = [(30.0 + 10 * rng.random(), 25.0 + 10 * rng.random()),
             (60.0 + 10 * rng.random(), 70.0 + 10 * rng.random())]  # fmt: skip
    things = tuple(
        SceneObject(f"{name}-1", name, at, None, Disc(at, 4.0))
        for name, at in zip(("glass", "plate"), spots, strict=True)
    )
    return Scene(f"s{seed}", (5.0, 50.0), (95.0, 50.0), things)


SCENES = [table(seed) for seed in range(12)]


def rules(draws: tuple[dict[str, float], ...] = ()) -> RuleSet:
    rule = ClearanceRule({"glass": KEPT}, {}, (), draws=draws)
    return RuleSet({"anna": TypeRules(rule, "anna keeps 6 from glasses")}, units="px")


@pytest.fixture(scope="module")
def found() -> CausalFindings:
    return find_causes(rules(), SCENES, settings=SETTINGS)


def test_the_curve_ends_where_the_clearance_does(found: CausalFindings) -> None:
    curve = next(c for c in found.dose if c.symbol == "glass")
    near = [p for p in curve.points if p.high is not None and p.high <= KEPT]
    far = [p for p in curve.points if p.low is not None and p.low >= KEPT]
    assert near
    assert far
    # All that was accepted is lost below the clearance, and nothing beyond it.
    assert all(p.effect == pytest.approx(-p.before) for p in near)
    assert all(p.effect == 0 for p in far)
    assert min(p.effect for p in near) < -0.5


def test_a_class_that_does_not_matter_has_a_flat_curve(found: CausalFindings) -> None:
    curve = next(c for c in found.dose if c.symbol == "plate")
    assert {p.effect for p in curve.points} == {0.0}
    assert {p.interval for p in curve.points if p.n_scenes > 1} == {(0.0, 0.0)}


def test_bins_follow_one_another_and_count_scenes(found: CausalFindings) -> None:
    for curve in found.dose:
        ends = [(p.low, p.high) for p in curve.points]
        assert ends[-1][1] is None
        assert all(a[1] == b[0] for a, b in pairwise(ends))
        assert all(1 <= p.n_scenes <= len(SCENES) for p in curve.points)
        assert all((p.interval is None) == (p.n_scenes < 2) for p in curve.points)


def test_the_effect_is_the_curve_weighed_by_its_paths() -> None:
    """Over one scene, the curve's points average to the effect."""
    trials = run_trials(rules(), SCENES[:1], settings=SETTINGS)
    cells = to_arrow(trials).to_pandas()
    cells = cells[(cells.symbol == "glass") & (cells.intervention == "add")]
    curve = next(
        c for c in find_causes(rules(), SCENES[:1], settings=SETTINGS).dose if c.symbol == "glass"
    )
    for point in curve.points:
        inside = np.ones(len(cells), dtype=bool)
        if point.low is not None:
            inside &= cells.distance >= point.low
        if point.high is not None:
            inside &= cells.distance < point.high
        assert point.effect == pytest.approx((cells.after - cells.before)[inside].mean())


def test_what_the_answers_leave_open_widens_the_band(found: CausalFindings) -> None:
    """Rules of the posterior that differ between 3 and 12: between these the band is wide."""
    draws = tuple({"glass": float(c)} for c in np.linspace(3.0, 12.0, 40))
    vague = find_causes(rules(draws), SCENES, settings=SETTINGS)
    width = {}
    for name, findings in (("sharp", found), ("vague", vague)):
        curve = next(c for c in findings.dose if c.symbol == "glass")
        point = next(p for p in curve.points if (p.low or 0) > KEPT)
        assert point.interval is not None
        width[name] = point.interval[1] - point.interval[0]
    assert width["sharp"] == 0
    assert width["vague"] > 0.3


def test_curves_and_unrelated_things_survive_the_document(found: CausalFindings) -> None:
    document = json.loads(json.dumps(found.to_json()))
    first = document["dose_response"][0]
    assert set(first["points"][0]) == {"low", "high", "effect", "interval", "before", "n_scenes"}
    again = findings_from_document(document)
    assert again.dose == found.dose
    assert again.unrelated == found.unrelated
    for name in ("dose_response", "unrelated"):  # documents of earlier versions
        del document[name]
    assert findings_from_document(document).dose == ()


def test_rules_leave_unrelated_things_alone(found: CausalFindings) -> None:
    (one,) = found.unrelated
    assert one.null
    assert one.n_scenes == len(SCENES)
    assert one.changed == 0
    assert any("nobody has shown" in s and "changes nothing" in s for s in found.sentences)


def from_all(scene: Scene, paths: Paths, type: str) -> FloatArray:
    """Keeps from whatever stands there, of whatever class."""
    near = nearest_approach(scene, paths, sorted({o.symbol for o in scene.objects or ()}))
    return (near >= KEPT).all(axis=1).astype(np.float64)


def test_a_model_that_tells_no_classes_apart_fails_it() -> None:
    findings = find_causes(FormulaModel(from_all), SCENES, settings=SETTINGS)
    (one,) = findings.unrelated
    assert not one.null
    assert one.effect < -0.05
    assert any("things of any class" in s for s in findings.sentences)


def test_hidden_lists_have_no_unrelated_things() -> None:
    blind = FormulaModel(lambda scene, paths, type: np.ones(len(paths)))
    findings = find_causes(blind, SCENES, settings=replace(SETTINGS, hide_lists=True))
    assert findings.unrelated == ()


def test_the_report_draws_the_curves(found: CausalFindings) -> None:
    from demospec.report import draw_dose_response

    figure = draw_dose_response(found, "px")
    (axes,) = figure.axes
    names = {line.get_label() for line in axes.get_lines()}
    assert {"glass", "plate"} <= names
