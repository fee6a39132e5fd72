"""Participants of the paper's rule, and participants whose rule the family cannot write."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from demospec.demonstrations import bezier_points, fit_bezier
from demospec.experiments.paper._participants import participant, participants_study
from demospec.experiments.paper._people import PEOPLE, free_strokes
from demospec.experiments.paper._readings import people_reading


@pytest.fixture(scope="module")
def people() -> list[dict[str, Any]]:
    return list(participants_study(16, 1, lambda *_: None, fresh=20)["participants"])


def test_the_hull_holds_those_who_label_by_the_family(people: list[dict[str, Any]]) -> None:
    inside = [p for p in people if p["in_family"]]
    assert len(inside) == 3
    for person in inside:
        assert person["hull_holds_truth"]
        assert person["answer"]["status"] == "optimal"
        assert person["contradicted"] == 0
        assert 0 < person["accepted"] < person["demonstrations"]


def test_the_hull_can_miss_those_who_do_not(people: list[dict[str, Any]]) -> None:
    outside = [p for p in people if not p["in_family"]]
    assert len(outside) == 4
    assert any(not p["hull_holds_truth"] for p in outside)
    # Some labels no parameters explain; and what both ends agree on is not always right.
    assert any(p["contradicted"] for p in outside)
    assert any(p["fresh"]["right"] < p["fresh"]["agreed"] for p in outside)
    told = people_reading(people)
    assert told[0] == "The hull holds the truth of 3 of 3 who label by the paper's rule."
    assert "who have another rule; it misses participant" in told[1]


def test_strokes_are_no_beziers() -> None:
    strokes = free_strokes(30, np.random.default_rng(0))
    gaps = []
    for stroke in strokes:
        control = fit_bezier(stroke)
        curve = bezier_points(stroke[0], stroke[-1], control, 400)
        nearest = np.linalg.norm(stroke[:, None] - curve, axis=2).min(axis=1)
        gaps.append(nearest.max())
        assert (stroke[0] == [20, 480]).all()
        assert (stroke[-1] == [480, 20]).all()
    assert np.median(gaps) > 20  # units of a 500 x 500 workbench


def test_the_same_seed_gives_the_same_labels() -> None:
    for number in (0, 3, 5):
        first, again = (participant(number, 8, 3) for _ in range(2))
        assert [t.valid for t in first.trajectories] == [t.valid for t in again.trajectories]
        assert len(first.trajectories) == 8


def test_speed_and_side_decide_where_the_drawn_line_does_not() -> None:
    """What makes these two people other than the family."""
    by_speed, by_side = PEOPLE[5], PEOPLE[6]
    rng = np.random.default_rng(0)
    drill = np.array([180.0, 260.0])
    along = np.linspace(-80, 80, 9)[:, None] * [1.0, 0.0] + drill + [0.0, 50.0]
    slowly = np.linspace(-80, 80, 161)[:, None] * [1.0, 0.0] + drill + [0.0, 50.0]
    assert by_speed.accepts([along, slowly], rng).tolist() == [False, True]
    handle, other = (np.tile(drill + d, (9, 1)) for d in ([40.0, 40.0], [-40.0, -40.0]))
    assert by_side.accepts([handle, other], rng).tolist() == [False, True]
