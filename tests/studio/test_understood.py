"""What the studio understands, without a browser."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
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
)
from demospec.errors import InputError
from demospec.report import contour_at, rings_svg
from demospec.rules import RuleSet, learn_rules, nearest_approach, passes, rules_document
from demospec.scene import Capsule, Disc, Picture, Polygon, Scene, SceneObject
from demospec.studio.session._distance_cache import NearMemory, PassMemory
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._state import TeachState
from demospec.studio.teach._summary import (
    Memory,
    Understood,
    how_many_more,
    question,
    understand,
)

GLASS = SceneObject("glass-0", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 6.0))
PLATE = SceneObject("plate-0", "plate", (50.0, 20.0), None, Disc((50.0, 20.0), 5.0))
SCENE = Scene("a", (5.0, 50.0), (95.0, 50.0), (GLASS, PLATE), None, "test")


def set_of(controls: list[tuple[float, float]], valid: list[bool | None]) -> DemonstrationSet:
    paths = bezier_points(SCENE.start, SCENE.goal, np.array(controls)[:, None, :], 60)
    demos = [
        Demonstration(f"d{i}", "a", path, "me", None, v)
        for i, (path, v) in enumerate(zip(paths, valid, strict=True))
    ]
    return DemonstrationSet(
        (SCENE,), Demonstrations.of(demos), symbols=("glass", "plate"), types=("me",)
    )


def judged(offsets: list[float], clearance: float) -> DemonstrationSet:
    """Paths below the glass at many distances, judged by the true clearance."""
    controls = [(50.0, 50.0 + o) for o in offsets]
    unlabelled = set_of(controls, [None] * len(controls))
    near = nearest_approach(SCENE, unlabelled.demonstrations.paths_xy(), ("glass",))[:, 0]
    return set_of(controls, [bool(v >= clearance) for v in near])


@settings(deadline=None, max_examples=15)
@given(st.floats(2, 12), st.integers(0, 1000))
def test_the_interval_brackets_the_true_clearance(clearance: float, seed: int) -> None:
    offsets = np.random.default_rng(seed).uniform(10, 70, 8).tolist()
    data = judged([*offsets, 0.0, 80.0], clearance)
    found = understand(data, "me")
    assert found.rule is not None
    assert found.rule.relevant == ("glass",)
    low, high = found.rule.interval["glass"]
    assert low <= clearance <= high
    assert not found.conflicts


def test_nothing_shown_and_nothing_labelled_are_said() -> None:
    assert understand(None, "me").sentence == "nothing shown yet"
    one = understand(set_of([(50, 90)], [None]), "me")
    assert (one.rule, one.unsaid) == (None, 1)
    assert understand(set_of([(50, 90)], [True]), "somebody else").rule is None
    with pytest.raises(InputError, match="accepted or rejected path first"):
        question(None, "me")


def test_scenes_of_every_split_are_learned_from() -> None:
    data = set_of([(50, 90), (50, 50)], [True, False])
    assert data.scenes[0].split == "test"
    assert understand(data, "me").rule is not None
    assert question(data, "me").type == "me"


def test_the_question_is_between_what_is_known() -> None:
    data = judged([20, 60, 0, 80], 7.0)
    asked = question(data, "me")
    assert asked.status == "ask"
    assert asked.points is not None
    low, high = understand(data, "me").rule.interval["glass"]  # type: ignore[union-attr]
    near = nearest_approach(SCENE, [asked.points], ("glass",))[0, 0]
    assert low - 0.5 <= near <= high + 0.5
    assert "more answer" in how_many_more(asked, understand(data, "me"))


def test_the_number_of_answers_foretold_is_about_what_it_takes() -> None:
    data = judged([30, 0], 7.0)
    foretold, taken = None, 0
    for taken in range(40):
        asked = question(data, "me", seed=taken // 8)
        words = how_many_more(asked, understand(data, "me"))
        if words.startswith("Settled"):
            break
        foretold = foretold or int(words.split()[1])
        assert asked.points is not None
        near = nearest_approach(SCENE, [asked.points], ("glass",))[0, 0]
        more = Demonstration(f"q{taken}", "a", asked.points, "me", None, bool(near >= 7.0))
        data = replace(data, demonstrations=Demonstrations.of([*data.demonstrations, more]))
    assert foretold is not None
    assert foretold / 2 <= taken <= 2 * foretold


def test_what_is_missing_altogether_is_asked_for_first() -> None:
    for offsets, words in (([60], "comes too near"), ([0], "far enough")):
        data = judged([*offsets], 7.0)
        asked = question(data, "me")
        assert words in how_many_more(asked, understand(data, "me"))


def test_a_question_stays_in_the_picture() -> None:
    # Beside objects at the rim, most telling curves leave the picture.
    glass = SceneObject("glass-0", "glass", (50.0, 90.0), None, Disc((50.0, 90.0), 6.0))
    picture = Picture(array=np.zeros((100, 100, 3), dtype=np.uint8))
    scene = replace(SCENE, objects=(glass,), picture=picture)
    data = replace(judged([30, 0], 7.0), scenes=(scene,), symbols=("glass",))
    for seed in range(6):
        asked = question(data, "me", seed=seed)
        assert asked.points is not None
        assert (asked.points >= 0).all()
        assert (asked.points <= 100).all()


def test_remembered_distances_are_the_distances() -> None:
    paths = judged([20, 60, 0, 80], 7.0).demonstrations.paths_xy()
    memory = NearMemory()
    for some in (paths[:2], paths, np.stack(paths), paths[::-1]):
        for scene in (SCENE, replace(SCENE, objects=(PLATE,))):
            for symbols in (("glass", "plate"), ("plate",)):
                found = memory(scene, some, symbols)
                assert np.array_equal(found, nearest_approach(scene, some, symbols))


def test_remembered_passes_are_the_passes_and_teach_the_same_rules() -> None:
    data = judged([20, 60, 0, 80, 35, 48], 7.0)
    paths, memory = data.demonstrations.paths_xy(), PassMemory()
    for some in (paths[:2], paths, paths[::-1], [paths[0], paths[0]]):
        for scene in (SCENE, replace(SCENE, objects=(PLATE,)), replace(SCENE, objects=())):
            found = memory(scene, some, ("glass", "plate"), unit=0.5)
            exact = passes(scene, some, ("glass", "plate"), unit=0.5)
            for name in ("demo", "thing", "column", "gap", "away", "slope", "table"):
                assert np.array_equal(getattr(found, name), getattr(exact, name)), name
    plain = learn_rules(data, split=None, influence=False)
    for _ in range(2):  # the second time nothing is measured
        again = learn_rules(
            data, split=None, influence=False, measure=NearMemory(), passing=PassMemory()
        )
        assert rules_document(again) == rules_document(plain)


@pytest.mark.parametrize(
    "shape",
    [
        Disc((10.0, 20.0), 4.0),
        Capsule((0.0, 0.0), (20.0, 5.0), 2.0),
        Polygon([[0, 0], [20, 0], [20, 4], [4, 4], [4, 20], [0, 20]]),
    ],
)
@pytest.mark.parametrize("distance", [0.0, 1.5, 8.0])
def test_rings_lie_at_their_distance(shape: Disc | Capsule | Polygon, distance: float) -> None:
    lines = contour_at(shape, distance)
    assert lines
    for line in lines:
        assert np.abs(shape.signed_distance(line) - distance).max() < 0.35
        assert np.allclose(line[0], line[-1])


def test_rings_show_both_ends_of_the_interval() -> None:
    found = understand(judged([20, 60, 0, 80], 7.0), "me")
    svg = rings_svg(SCENE, found.rule)
    assert svg.count("ring lower") == 1
    assert svg.count("ring upper") == 1
    assert rings_svg(SCENE, None) == ""


def test_only_what_is_judged_anew_is_learned_anew() -> None:
    memory = Memory()
    data = set_of([(50, 140), (50, 60), (50, 80)], [True, False, None])
    first = understand(data, "me", memory)
    more = set_of([(50, 140), (50, 60), (50, 80), (50, 90)], [True, False, None, None])
    again = understand(more, "me", memory)
    assert again.rule is first.rule
    assert (again.accepted, again.rejected, again.unsaid) == (1, 1, 2)
    for valid in ([True, True, None], [True, None, None], [True, False, True]):
        other = set_of([(50, 140), (50, 60), (50, 80)], list(valid))
        assert understand(other, "me", memory) == understand(other, "me")
    moved = replace(SCENE, objects=(replace(PLATE, id="plate-1"), GLASS))
    elsewhere = replace(data, scenes=(moved,))
    assert understand(elsewhere, "me", memory).rule is not first.rule


def test_a_verdict_that_was_foreseen_is_not_learned_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learned = []

    def learning(data: DemonstrationSet, **settings: Any) -> RuleSet:
        learned.append(len(data.demonstrations))
        return learn_rules(data, **settings)

    monkeypatch.setattr("demospec.studio.teach._summary.learn_rules", learning)
    bench = Workbench(out=tmp_path / "taught")
    state = TeachState(bench)
    scene = bench.scenes[0]
    controls = np.array([[[50.0, y]] for y in (20, 50, 80)])
    for path in bezier_points(scene.start[:2], scene.goal[:2], controls, 40):
        state.do("stroke", {"scene": scene.scene_id, "points": path.tolist()})
        state.foresee()
        learned.clear()
        state.do("key", "accept")
        state.understand()
        assert not learned
        assert state.understood == understand(bench.data(), state.type)
    state.do("key", "undo")
    learned.clear()
    state.understand()
    assert not learned
    # The answer to a question too.
    state.ask()
    state.do("key", "ask")
    assert state.asked is not None
    state.foresee()
    learned.clear()
    state.do("key", "reject")
    state.understand()
    assert state.understood.rejected == 1
    assert not learned
    bench.close()


def test_two_threads_learn_once_and_an_error_reaches_both() -> None:
    memory, began, go = Memory(), threading.Event(), threading.Event()

    def fails() -> Understood:
        began.set()
        go.wait(60)
        raise InputError("a rule", "none")

    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(memory.of, "basis", fails)
        began.wait(60)
        second = pool.submit(memory.of, "basis", lambda: understand(None, "me"))
        go.set()
        for one in (first, second):
            with pytest.raises(InputError, match="expected a rule"):
                one.result(60)
