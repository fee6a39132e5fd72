"""Objects that people mark in a picture: where the set does not list them, rules still come."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from demospec.demonstrations import bezier_points, read_set
from demospec.errors import InputError
from demospec.studio.session._upload import scene_from_picture
from demospec.studio.session._workspace import Workbench
from demospec.studio.teach._state import NotNow, TeachState
from demospec.studio.teach._summary import understand


def loop(x: float, y: float, r: float) -> list[list[float]]:
    turns = np.linspace(0, 2 * np.pi, 24)
    return np.column_stack([x + r * np.cos(turns), y + r * np.sin(turns)]).tolist()  # type: ignore[no-any-return]


@pytest.fixture
def bench(tmp_path: Path) -> Workbench:
    bench = Workbench(out=tmp_path / "new")
    file = tmp_path / "table.png"
    PIL.Image.new("RGB", (200, 100), (200, 180, 160)).save(file)
    bench.add_scene(scene_from_picture(file.read_bytes(), "table", []), actor="a")
    return bench


def test_a_marked_cup_is_learned_about_written_and_taken_back(bench: Workbench) -> None:
    assert bench.mark("table", [("cup", loop(100, 50, 8))], actor="a") == ("cup-0",)
    scene = bench.scene("table")
    for bend, valid in ((150.0, True), (60.0, False), (95.0, True)):
        path = bezier_points(scene.start, scene.goal, np.array([[[100.0, bend]]]), 60)[0]
        bench.draw("table", path, actor="a", type="me", valid=valid)
    found = understand(bench.comparable("table"), "me")
    assert found.rule is not None
    assert found.rule.relevant == ("cup",)
    low, high = found.rule.interval["cup"]
    assert 0 <= low < high < 20
    kept = {s.scene_id: s for s in read_set(bench.write()).scenes}["table"]
    (cup,) = kept.listed_objects()
    assert cup.symbol == "cup"
    assert cup.outline.signed_distance(np.array([100.0, 50.0])) == pytest.approx(-8, abs=0.3)
    bench.unmark("table", "cup-0", actor="a")
    assert bench.scene("table").objects is None
    bench.undo("a")
    assert [o.id for o in bench.scene("table").listed_objects()] == ["cup-0"]
    assert bench.mark("table", [("cup", loop(30, 30, 5))], actor="a") == ("cup-1",)
    bench.close()


def test_marks_that_are_no_loop_or_not_wanted_are_refused(bench: Workbench) -> None:
    for outline in ([[10, 10], [20, 20], [30, 30]], [[10, 10]], loop(300, 50, 8)):
        with pytest.raises(InputError):
            bench.mark("table", [("cup", outline)], actor="a")
    with pytest.raises(InputError, match="word"):
        bench.mark("table", [("", loop(50, 50, 5))], actor="a")
    with pytest.raises(InputError, match="not listed"):
        bench.mark(bench.scenes[0].scene_id, [("cup", loop(50, 50, 5))], actor="a")
    assert bench.scene("table").objects is None
    bench.close()


def test_the_page_says_what_to_do_next(bench: Workbench) -> None:
    state = TeachState(bench)
    assert "from the circle to the star" in state.hint
    state.do("scene", "table")
    assert "mark the objects under Table" in state.hint
    bench.mark("table", [("cup", loop(50, 50, 5))], actor="a")
    assert "from the circle to the star" in state.hint
    with pytest.raises(NotNow, match="Draw a path first"):
        state.do("key", "accept")
    scene = state.scene
    state.do("stroke", {"scene": "table", "points": [scene.start, [100, 90], scene.goal]})
    assert "Would you accept this path?" in state.hint
    state.do("key", "accept")
    assert "#1 is accepted" in state.hint
    # After a reload the tab goes on where it was.
    again = TeachState(bench)
    again.do("hello", {"tab": "x", **state.to_remember()})
    assert (again.scene_id, again.chosen, again.hint) == ("table", state.chosen, state.hint)
    bench.close()
