"""What several types accept alike: their overlap, and samples that please all of them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import simulate_set, write_set
from demospec.errors import InputError
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Scene, SceneObject
from demospec.specification import ControlPlane, overlap_of_types, sample_valid, validity_map

START, GOAL = (10.0, 90.0), (90.0, 10.0)


@pytest.fixture(scope="module")
def view():
    """One minds the glass, the other the plate: neither accepts all that the other does."""
    rules = RuleSet(
        {
            "glass": TypeRules(ClearanceRule({"glass": 6.0})),
            "plate": TypeRules(ClearanceRule({"plate": 6.0})),
        }
    )
    items = tuple(
        SceneObject(symbol, symbol, at, None, Disc(at, 8.0))
        for symbol, at in (("glass", (35.0, 35.0)), ("plate", (68.0, 68.0)))
    )
    return rules.see(Scene("a", START, GOAL, items))


def test_the_overlap_is_counted_cell_by_cell(view):
    found = overlap_of_types(view, ("glass", "plate"), size=31)
    glass, plate = (validity_map(view, t, size=31).logits > 0 for t in ("glass", "plate"))
    assert found.by_all == (glass & plate).mean()
    assert found.share("glass", "plate") == (glass & plate).sum() / (glass | plate).sum()
    assert 0 < found.by_all < min(glass.mean(), plate.mean())
    both = validity_map(view, ("glass", "plate"), size=31)
    np.testing.assert_array_equal(both.logits > 0, glass & plate)
    assert both.type == "glass and plate"
    for bad in (("glass",), ("glass", "glass"), ()):
        with pytest.raises(InputError, match="two different types"):
            overlap_of_types(view, bad)


@pytest.mark.parametrize("method", ["map", "langevin"])
def test_samples_for_several_please_each(view, method):
    found = sample_valid(view, ("glass", "plate"), 30, method=method)
    assert len(found.control) == 30
    for type_ in ("glass", "plate"):
        assert (view.p_valid(found.points, type_) == 1).all()
    # Samples for one of them do not all please the other.
    alone = sample_valid(view, "glass", 30)
    assert (view.p_valid(alone.points, "plate") == 0).any()


def test_gradients_are_those_of_the_type_that_minds_most(view):
    plane, types = ControlPlane(view), ("glass", "plate")
    z = np.array([[[30.0, 30.0]], [[75.0, 75.0]], [[5.0, 60.0]]])
    logits, slopes = plane.logits_and_gradients(z, types)
    each = [plane.logits_and_gradients(z, t) for t in types]
    np.testing.assert_allclose(logits, np.minimum(each[0][0], each[1][0]))
    for i in range(len(z)):
        least = int(each[1][0][i] < each[0][0][i])
        np.testing.assert_allclose(slopes[i], each[least][1][i])


def test_the_command_samples_for_several(tmp_path, capsys):
    data, truth = simulate_set(train_scenes=3, test_scenes=0, demonstrations=2, seed=2)
    write_set(data, tmp_path / "set", documents={"truth.json": truth})
    command = ["sample", str(tmp_path / "set" / "truth.json"), str(tmp_path / "set"),
               "--scene", "0000", "--n", "5"]  # fmt: skip

    def run(*more: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as stop:
            main([*command, *more])
        said = capsys.readouterr()
        return int(stop.value.code or 0), said.out, said.err

    status, out, _ = run("--types", "careful, normal", "--json")
    assert status == 0
    answer = json.loads(out)
    assert answer["types"] == ["careful", "normal"]
    (pair,) = answer["overlap"]["scenes"]
    assert pair["n_scenes"] == 3
    assert pair["interval"][0] <= pair["overlap"] <= pair["interval"][1]
    # Whoever keeps clear of everything keeps clear of glasses.
    accepted = answer["overlap"]["scene"]["accepted"]
    assert answer["overlap"]["scene"]["by_all"] == accepted["careful"]
    assert "overlap" not in json.loads(run("--type", "careful", "--json")[1])
    assert "Overlap" in run("--types", "careful,normal")[1]
    for bad, words in (
        ((), "found neither"),
        (("--type", "careful", "--types", "careful,normal"), "found both"),
        (("--types", "careful"), "two different types"),
        (("--types", "careful,nobody"), "found nobody"),
    ):
        status, _, err = run(*bad)
        assert status == 2
        assert words in err
        assert err.count("\n") == 1
