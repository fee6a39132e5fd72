"""Readings are chosen by numbers: other numbers, other words."""

from __future__ import annotations

from typing import Any

import pytest

from demospec.experiments.paper._page_rules import _change, _optima
from demospec.experiments.paper._readings import (
    ablation_reading,
    accuracy_reading,
    causes_reading,
    latent_reading,
    repair_reading,
    transition_reading,
    types_reading,
    unseen_reading,
)


def _repairs(share: float | None, n: int) -> dict[str, Any]:
    value = {"vacuous": share is None, "repaired_by_truth": share, "n": n}
    return {"field": {"1": {"careful": value}}}


@pytest.mark.parametrize(
    ("share", "n", "words"),
    [(0.5, 200, "below"), (0.95, 200, "above"), (0.75, 200, "not to be told from"),
     (0.5, 4, "not to be told from"), (None, 0, "nothing to repair")],
)  # fmt: skip
def test_repair_is_set_beside_the_printed_share_by_its_interval(
    share: float | None, n: int, words: str
) -> None:
    assert words in repair_reading(_repairs(share, n))[0]


def _effects(causal: set[tuple[str, str]]) -> dict[str, Any]:
    cells = [
        {"type": t, "symbol": s, "causal": (t, s) in causal}
        for t in ("careful", "normal", "aggressive")
        for s in ("utensil", "plate", "bowl", "glass")
    ]
    return {"truth": {"effects": cells}}


def test_causes_are_counted_cell_by_cell() -> None:
    printed = {("careful", s) for s in ("utensil", "plate", "bowl", "glass")} | {
        ("normal", "glass")
    }
    assert "in 12 of 12 cells." in causes_reading(_effects(printed))[0]
    told = causes_reading(_effects(printed - {("normal", "glass")} | {("normal", "bowl")}))[0]
    assert "in 10 of 12 cells; not in normal + bowl, normal + glass." in told


def test_types_are_set_beside_the_printed_difference_by_their_interval() -> None:
    """The paper prints bases 0.43, 0.62 and 1.00."""
    cells = [
        {"from": "careful", "to": "normal", "interval": [0.1, 0.3]},  # printed: 0.19
        {"from": "normal", "to": "aggressive", "interval": [0.385, 0.5]},  # 0.38, rounded
        {"from": "careful", "to": "aggressive", "interval": [0.6, 0.7]},  # 0.57
        {"from": "careful", "to": "hasty", "interval": [0.0, 1.0]},  # not in the paper
    ]
    assert types_reading({"truth": {"types": cells}}) == [
        "Truth as model: the interval holds the printed difference for 2 of 3 pairs; not for "
        "careful → aggressive."
    ]


def test_changes_carry_sign_and_interval_and_no_negative_zero() -> None:
    change = {"effect": -0.162, "interval": [-0.21, -0.001]}
    assert _change(change) == "-0.16 [-0.21,\u00a0+0.00]"
    assert _change({"effect": -0.001, "interval": None}) == "+0.00"
    assert _change(None) == "–"


def test_maps_are_told_a_line_each_and_without_the_truth_itself() -> None:
    agreement = {"seen": {"field": {"careful": 0.95, "aggressive": 1.0}, "truth": {"careful": 1.0}}}
    assert latent_reading(agreement) == ["field (ours), seen scene: careful 95\u00a0%."]


def test_the_nearest_reading_of_the_protocol_is_found_not_named_beforehand() -> None:
    near, far = (0.72, 0.99), (0.6, 0.7)
    for name, means in (
        ("clustered", {"uniform": far, "clustered": near}),
        ("uniform", {"uniform": near, "clustered": far}),
    ):
        words = accuracy_reading(means, "")
        assert f"is the {name} reading: 99.0\u00a0%, as printed" in words
    split = accuracy_reading({"uniform": (0.72, 0.9), "clustered": (0.95, 0.98)}, "")
    assert "is the clustered reading" in split
    assert "Over both ends the uniform reading is nearer" in split


def _rows(full: float, classifier: float, where: str = "seen") -> list[dict[str, Any]]:
    """Two models, one type, n = 1 and 9; quartiles two points wide."""
    out = []
    for model, value in (("full", full), ("classifier", classifier)):
        for n in (1, 9):
            row = {"model": model, "n": n, "type": "careful"}
            for w in ("seen", "unseen"):
                row |= {f"bacc_{w}": value, f"quartiles_{w}": [value - 0.01, value + 0.01]}
            out.append(row)
    return out


@pytest.mark.parametrize(
    ("full", "classifier", "words"),
    [(0.51, 0.56, "it guesses"), (0.80, 0.81, "less than the quartiles span"),
     (0.90, 0.80, "bring 10.0 points"), (0.80, 0.90, "10.0 points ahead of the full model")],
)  # fmt: skip
def test_the_parts_of_the_papers_model_are_weighed_against_the_spread(
    full: float, classifier: float, words: str
) -> None:
    assert all(words in told for told in ablation_reading(_rows(full, classifier)))
    assert len(ablation_reading(_rows(full, classifier))) == 2


@pytest.mark.parametrize(
    ("level", "words"), [(0.5, "near guessing"), (0.7, "better than"), (0.95, "most paths")]
)
def test_unseen_scenes_are_told_by_their_number(level: float, words: str) -> None:
    told = unseen_reading(_rows(level, 0.5))
    assert len(told) == 1  # no field model among them: nothing is said of it
    assert words in told[0]
    assert f"{100 * level:.1f}" in told[0]


def test_the_transition_names_which_demonstrations_move_which_end() -> None:
    grid = {"least": [[10, 20], [10, 20]], "most": [[90, 90], [50, 50]]}
    width = {"counts": [1, 4, 9], "median": [None, 80.0, 30.0]}
    told = transition_reading({"width": width, "grid": grid})
    assert "80 with 4, 30 with 9" in told
    assert "the least L by rejected" in told
    assert "the greatest L by accepted" in told
    turned = {k: [list(row) for row in zip(*v, strict=True)] for k, v in grid.items()}
    assert "the least L by accepted" in transition_reading({"width": width, "grid": turned})
    nothing = {"counts": [1], "median": [None]}
    assert "No number" in transition_reading({"width": nothing, "grid": None})


def test_a_parameter_on_either_end_of_its_domain_is_flagged() -> None:
    cells, flags = _optima((36, 37, 37), (59, 135, 159), (1, 100))
    assert cells == ["(36) 59", "(37†) 135", "(37†) 159†"]
    assert flags == [True, False, True, True]
