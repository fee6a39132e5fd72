"""Contradictions: found exactly, asked about the newest first, kept for good; undo and redo."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    bezier_points,
    write_set,
)
from demospec.geometry import Disc
from demospec.rules import nearest_approach
from demospec.scene import Scene, SceneObject
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._conflicts import Conflict, conflicts, is_kept, questions
from demospec.studio.teach._state import TeachState
from demospec.studio.teach._text import conflict_words

GLASS = SceneObject("glass-0", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 6.0))
PLATE = SceneObject("plate-0", "plate", (50.0, 20.0), None, Disc((50.0, 20.0), 5.0))
SCENE = Scene("a", (5.0, 50.0), (95.0, 50.0), (GLASS, PLATE), None, "test")


def curve(y: float) -> np.ndarray:
    """A path that is bent towards (50, y)."""
    control = np.array([[[50.0, y]]])
    return np.asarray(bezier_points(SCENE.start, SCENE.goal, control, 60)[0])


def set_of(bends: list[float], valid: list[bool]) -> DemonstrationSet:
    demos = [
        Demonstration(f"d{i}", "a", curve(y), "me", None, v)
        for i, (y, v) in enumerate(zip(bends, valid, strict=True))
    ]
    return DemonstrationSet(
        (SCENE,), Demonstrations.of(demos), symbols=("glass", "plate"), types=("me",)
    )


def found_in(data: DemonstrationSet) -> tuple[Conflict, ...]:
    return conflicts(data, nearest_approach)


def test_a_contradiction_names_both_sides() -> None:
    # The rejected path stays further from everything than the accepted one.
    data = set_of([60, 120, 140], [True, False, True])
    (found,) = found_in(data)
    assert (found.demo_id, found.against) == ("d1", ("d0",))
    words = conflict_words((found,), "me")
    assert "You rejected <b>d1</b> but accepted <b>d0</b>, which passes closer to a glass" in words
    assert conflict_words((found,), "<i>").startswith("&lt;i&gt; rejected")
    fixed = replace(data, demonstrations=data.demonstrations.rows([0, 2]))
    assert found_in(fixed) == ()


def test_one_wrong_acceptance_is_asked_about_once() -> None:
    # d0 is accepted right at the glass, the four rejected ones keep further off.
    data = set_of([50, 56, 57, 58, 59, 140], [True, False, False, False, False, True])
    found = found_in(data)
    assert {c.demo_id for c in found} == {"d1", "d2", "d3", "d4"}
    (together,) = questions(found, {})
    assert together[0].against == ("d0",)
    words = conflict_words(together, "me")
    assert "as close as 4 paths that were rejected" in words
    assert "and others" in words
    # Two are two questions: either side may be wrong.
    assert [len(some) for some in questions(found[:2], {})] == [1, 1]


@settings(deadline=None, max_examples=30)
@given(st.lists(st.tuples(st.floats(-60, 160), st.booleans()), min_size=2, max_size=7))
def test_conflicts_are_exactly_what_no_rule_explains(rows: list[tuple[float, bool]]) -> None:
    data = set_of([y for y, _ in rows], [v for _, v in rows])
    near = nearest_approach(SCENE, data.demonstrations.paths_xy(), data.symbols)
    valid = data.demonstrations.valid == 1
    # Independent: try every rule whose clearances are those that some path kept (or none).
    tried = [[-np.inf, *(c for c in np.unique(near[:, k]) if c >= 0)] for k in range(near.shape[1])]
    ids = set()
    for row in np.flatnonzero(~valid):
        explained = any(
            (near[valid] >= [g, p]).all() and not (near[row] >= [g, p]).all()
            for g in tried[0]
            for p in tried[1]
        )
        if valid.any() and not explained:
            ids.add(f"d{row}")
    assert {c.demo_id for c in found_in(data)} == ids


def test_the_newest_label_is_asked_about_first() -> None:
    first, second = Conflict("d1", ("d0",)), Conflict("d2", ("d5",))
    assert questions([first, second], {"d5": 9, "d0": 3})[0] == (second,)
    assert questions([first, second], {"d5": 3, "d0": 9})[0] == (first,)


def test_what_was_kept_is_asked_about_again_only_when_a_label_is_newer() -> None:
    conflict = Conflict("d1", ("d0",))
    assert not is_kept(conflict, {}, {})
    assert is_kept(conflict, {"d1": 5}, {"d1": 2, "d0": 4})
    assert not is_kept(conflict, {"d1": 5}, {"d1": 2, "d0": 6})
    assert not is_kept(Conflict("d2", ("d0",)), {"d1": 5}, {})


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    data = set_of([120, 140], [True, True])
    bench = Workbench(write_set(data, tmp_path / "set"), out=tmp_path / "taught")
    yield bench
    bench.close()


def teach(state: TeachState, y: float, verdict: str) -> str:
    state.do("stroke", {"scene": "a", "points": curve(y).tolist()})
    state.do("key", verdict)
    assert state.chosen is not None
    return state.chosen


def asked(state: TeachState) -> list[tuple[Conflict, ...]]:
    state.understand()
    return state.conflicts


def test_keep_answers_a_question_for_good_and_can_be_undone(bench: Workbench) -> None:
    state = TeachState(bench)
    state.do("next_after", "when I say")
    near = teach(state, 60, "accept")
    far = teach(state, 100, "reject")
    ((conflict,),) = asked(state)
    assert (conflict.demo_id, conflict.against) == (far, (near,))
    state.do("keep", (far,))
    assert asked(state) == []
    # In a new tab too, and after a path that changes nothing about it.
    teach(state, 150, "accept")
    assert asked(TeachState(bench)) == []
    # A label that is given anew is a new question.
    for valid in (True, False):
        bench.label(far, valid, actor=state.actor)
    assert len(asked(state)) == 1
    state.do("keep", (far,))
    assert asked(state) == []
    state.do("key", "undo")
    assert len(asked(state)) == 1


def test_undo_and_redo_choose_what_they_changed(bench: Workbench) -> None:
    state = TeachState(bench)
    first = teach(state, 60, "accept")
    second = teach(state, 100, "reject")
    state.do("pick", first)
    state.do("key", "undo")  # the label of the second
    assert state.chosen == second
    state.do("pick", first)
    state.do("key", "redo")
    assert state.chosen == second
    state.do("key", "accept")  # the next key is about what was just seen to change
    assert bench.standing.demonstrations[second].valid is True
    assert bench.standing.demonstrations[first].valid is True


def test_found_objects_wait_for_a_name(bench: Workbench, monkeypatch: Any) -> None:
    state = TeachState(bench)
    assert "no name" not in state.hint
    scene = replace(SCENE, objects=tuple(replace(o, symbol=f"unnamed {o.symbol}")
                                         for o in (GLASS, PLATE)))  # fmt: skip
    monkeypatch.setattr(TeachState, "scene", scene)
    assert state.hint.startswith("2 found objects have no name yet: name them")
