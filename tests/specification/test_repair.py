"""Repair, maps and samples over z_θ: formulas and rules as models, geometry as the judge."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import resample
from demospec.errors import InputError
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.specification import (
    ControlPlane,
    RepairSettings,
    explain,
    plane_bounds,
    repair,
    sample_valid,
    validity_map,
)
from demospec.testing import DiscModel, DiscView, SlopedDiscView, disc_scene

WORLD = disc_scene((50, 50, 10), (25, 60, 6))
RULE = RuleSet({"careful": TypeRules(clearance=ClearanceRule({"glass": 5.0}))})


def rejected(view, n: int, seed: int = 0) -> np.ndarray:
    z = np.random.default_rng(seed).uniform(0, 100, (50 * n, 1, 2))
    return z[ControlPlane(view).logits(z, "careful") <= 0][:n]


@pytest.mark.parametrize("make", [SlopedDiscView, DiscView])
@pytest.mark.parametrize("order", [2, 3])
def test_gradient_over_controls_is_the_difference_quotient(make, order):
    view = make(WORLD, 5.0)
    plane = ControlPlane(view, order=order)
    z = np.random.default_rng(1).uniform(0, 100, (8, order - 1, 2))
    logits, slope = plane.logits_and_gradients(z, "careful")
    np.testing.assert_allclose(logits, plane.logits(z, "careful"))
    direction = np.random.default_rng(2).normal(size=z.shape)
    h = 1e-3
    quotient = (
        plane.logits(z + h * direction, "careful") - plane.logits(z - h * direction, "careful")
    ) / (2 * h)
    difference = np.abs((slope * direction).sum(axis=(1, 2)) - quotient)
    # The smallest margin has kinks where another sample becomes the nearest: not at most of z.
    assert np.median(difference) < 0.02


@pytest.mark.parametrize(
    ("discs", "particles", "share", "ratio"),
    [
        (((50, 50, 10),), 1, 0.95, 1.3),
        # Between two discs a single climber gets stuck: that is the paper's 75 to 80 %.
        (((50, 50, 10), (25, 60, 6)), 1, 0.4, 3.0),
        (((50, 50, 10), (25, 60, 6)), 16, 0.99, 1.1),
    ],
)
def test_repairs_hold_and_are_nearly_the_least_change(discs, particles, share, ratio):
    view = SlopedDiscView(disc_scene(*discs), 5.0)
    z = rejected(view, 40)
    plane = ControlPlane(view)
    axis = np.arange(-20.0, 121.0, 1.0)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 1, 2)
    held = grid[plane.logits(grid, "careful") > 0, 0]
    least = np.linalg.norm(z - held[None], axis=2).min(axis=1)
    done = repair(view, z, "careful", settings=RepairSettings(particles=particles))
    ok = view.p_valid(done.points, "careful") > 0.5
    np.testing.assert_array_equal(ok, done.holds)
    assert ok.mean() >= share
    assert np.median(done.moved[ok] / np.maximum(least[ok], 1.0)) < ratio
    assert (done.steps <= 31).all()


def test_repair_starts_at_the_rejected_curve_and_ends_at_the_kept_one():
    view = SlopedDiscView(WORLD, 5.0)
    z = rejected(view, 5)
    done = repair(view, z[:, 0], "careful")
    for i in range(5):
        np.testing.assert_allclose(done.trace[i][0], z[i])
        np.testing.assert_allclose(done.trace[i][-1], done.control[i])
        moved = np.linalg.norm(done.control[i] - z[i])
        assert done.moved[i] == pytest.approx(moved)


def test_repair_keeps_each_curves_own_ends():
    view = SlopedDiscView(WORLD, 5.0)
    z = rejected(view, 3)
    start = np.array([[10.0, 90.0], [12.0, 88.0], [5.0, 95.0]])
    done = repair(view, z, "careful", start=start, goal=[90.0, 10.0])
    np.testing.assert_allclose(done.points[:, 0], start)
    np.testing.assert_allclose(done.points[:, -1], np.tile([90.0, 10.0], (3, 1)))


def test_repair_of_what_nobody_accepts_says_so():
    view = SlopedDiscView(disc_scene((10, 90, 20)), 5.0)  # the start is inside the disc
    done = repair(view, [[50.0, 50.0]], "careful")
    assert not done.holds[0]


def test_a_repair_goes_beyond_a_verdict_that_is_known_to_be_too_lenient():
    view = SlopedDiscView(WORLD, 2.0)  # the truth keeps 5 px
    truth = SlopedDiscView(WORLD, 5.0)
    z = rejected(truth, 60)
    z = z[ControlPlane(view).logits(z, "careful") > 0.2]
    done = repair(view, z, "careful", known_invalid=np.ones(len(z), bool))
    assert len(z) > 3
    assert (view.logits(done.points, "careful") > ControlPlane(view).logits(z, "careful")).all()


def test_rules_repair_too_and_rules_judge():
    view = RULE.see(WORLD)
    z = rejected(SlopedDiscView(WORLD, 5.0), 6)
    done = repair(view, z, "careful", settings=RepairSettings(particles=8))
    assert (view.p_valid(done.points, "careful") == 1).all()


def test_map_agrees_with_the_view_point_by_point():
    view = SlopedDiscView(WORLD, 5.0)
    found = validity_map(view, "careful", size=(21, 11), bounds=(0, 0, 100, 100))
    assert found.logits.shape == (11, 21)
    plane = ControlPlane(view)
    for row, column in ((0, 0), (5, 20), (10, 3)):
        one = plane.logits(np.array([[[found.x[column], found.y[row]]]]), "careful")
        assert found.logits[row, column] == pytest.approx(one[0])
    assert 0 < found.valid_share < 1
    assert validity_map(view, "bold").valid_share == 1.0


@pytest.mark.parametrize("method", ["map", "langevin"])
def test_samples_are_valid_varied_and_pass_on_both_sides(method):
    view = SlopedDiscView(disc_scene((50, 50, 12)), 5.0)
    found = sample_valid(view, "careful", 20, method=method)
    assert len(found.control) == 20
    assert (view.p_valid(found.points, "careful") == 1).all()
    assert found.modes == 2
    assert set(found.mode.tolist()) == {0, 1}
    # Left and right of the straight line from start to goal.
    side = found.points[:, 50].sum(axis=1) > 100
    assert (side == side[0]).sum() not in (0, 20)
    assert all(len(set(side[found.mode == m])) == 1 for m in (0, 1))
    assert found.diversity > 20
    again = sample_valid(view, "careful", 20, method=method)
    np.testing.assert_array_equal(again.control, found.control)


def test_sampling_where_nothing_is_valid_gives_nothing():
    view = SlopedDiscView(disc_scene((10, 90, 20)), 5.0)
    found = sample_valid(view, "careful", 5)
    assert len(found.control) == 0
    assert found.to_json()["trajectories"] == []
    with pytest.raises(InputError):
        sample_valid(view, "careful", 0)


def test_plane_reaches_beyond_the_picture_and_exists_without_one():
    assert plane_bounds(WORLD) == (-20.0, -20.0, 120.0, 120.0)
    bare = WORLD.with_changes(objects=None, picture=None)
    x0, y0, x1, y1 = plane_bounds(bare)
    assert x0 < 10 < 90 < x1
    assert y0 < 10 < 90 < y1


@settings(deadline=None, max_examples=25)
@given(st.floats(20, 80), st.floats(20, 80), st.floats(4, 12), st.integers(0, 10_000))
def test_explanations_name_the_culprit_and_their_counterfactual_flips(x, y, radius, seed):
    scene = disc_scene((x, y, radius), (95, 95, 3))
    view = SlopedDiscView(scene, 5.0)
    path = ControlPlane(view).paths(np.random.default_rng(seed).uniform(0, 100, (1, 1, 2)))[0]
    found = explain(view, path, "careful")
    assert found.valid == bool(view.p_valid(path[None], "careful")[0])
    if found.valid:
        assert found.further is None
        return
    assert found.object_id == "glass-0"
    if found.further is not None:
        assert found.flips
        assert view.p_valid(found.counterfactual[None], "careful")[0] == 1
        # What was missing to the clearance is what has to be added.
        # (By the explanation's own points: `path` has fewer, and misses the deepest of them.)
        assert found.further == pytest.approx(-found.logit, abs=0.3)


def test_explaining_without_the_counterfactual_names_the_same_place():
    view = RULE.see(WORLD)
    path = ControlPlane(view).paths(np.array([[[50.0, 50.0]]]))[0]
    whole = explain(view, path, "careful")
    quick = explain(view, path, "careful", counterfactual=False)
    assert (quick.valid, quick.place, quick.object_id) == (False, whole.place, whole.object_id)
    assert (quick.further, quick.counterfactual, quick.flips) == (None, None, False)
    assert whole.sentence.startswith(quick.sentence.removesuffix("."))


def test_the_least_push_is_the_least_of_a_fine_scan():
    view = RULE.see(WORLD)
    path = ControlPlane(view).paths(np.array([[[50.0, 50.0]]]))[0]
    found = explain(view, path, "careful")
    points = resample(path, 200)
    push = found.counterfactual - points
    shares = np.concatenate([np.linspace(0.0, 0.999, 100), -np.linspace(0.0, 0.95, 100)])
    shorter = view.logits(points + shares[:, None, None] * push, "careful")
    assert (shorter <= 0).all()  # the other way neither
    assert view.logits(found.counterfactual[None], "careful")[0] > 0


def test_explanation_speaks_in_units_and_works_with_rules():
    view = RULE.see(WORLD)
    path = ControlPlane(view).paths(np.array([[[50.0, 50.0]]]))[0]
    found = explain(view, path, "careful", metres_per_unit=0.004)
    assert not found.valid
    assert "inside glass-0" in found.sentence  # the id names the class already
    assert "cm" in found.sentence
    assert found.flips


def test_settings_are_checked():
    for bad in ({"particles": 33}, {"particles": 0}, {"steps": 0}, {"confidence": 0.4}):
        with pytest.raises(InputError, match=next(iter(bad))):
            RepairSettings(**bad)


def test_disc_model_is_a_validity_model():
    from demospec.demonstrations import DifferentiableView, ValidityModel

    assert isinstance(DiscModel(), ValidityModel)
    assert isinstance(SlopedDiscView(WORLD, 5.0), DifferentiableView)
    assert not isinstance(DiscView(WORLD, 5.0), DifferentiableView)
