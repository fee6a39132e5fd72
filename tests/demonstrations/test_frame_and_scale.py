"""The frame of a set and the scale of its pictures: kept, refused where wrong, never guessed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    edit,
    read_set,
    write_set,
)
from demospec.demonstrations.readers import convert, read_mapping
from demospec.errors import InputError
from demospec.frames import Frame, metres_of_words, ruler
from demospec.scene import Disc, Picture, Scene, SceneObject


def a_set(units: str = "px", *, picture: bool = False, name: str = "a") -> DemonstrationSet:
    glass = SceneObject("g", "glass", (40.0, 30.0), None, Disc((40.0, 30.0), 5.0))
    image = Picture(array=np.zeros((60, 90, 3), dtype=np.uint8)) if picture else None
    scene = Scene(name, (5.0, 5.0), (75.0, 55.0), (glass,), image)
    item = Demonstration(f"{name}-1", name, np.array([[5.0, 5.0], [75.0, 55.0]]), valid=False)
    return DemonstrationSet((scene,), Demonstrations.of([item]), units=units, symbols=("glass",))


def metres(data: DemonstrationSet) -> np.ndarray:
    """The points through the homography of their set's frame."""
    assert data.frame is not None
    assert data.frame.homography is not None
    flat = data.demonstrations.flat[:, :2]
    image = np.column_stack([flat, np.ones(len(flat))]) @ np.array(data.frame.homography).T
    return image[:, :2] / image[:, 2:]


def run(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    return int(stopped.value.code or 0)


def test_frame_and_scale_survive_files(tmp_path: Path) -> None:
    turn = ((0.0, -0.01, 1.0), (0.01, 0.0, 2.0), (0.0, 0.0, 1.0))
    for frame in (None, Frame("map", "up"), Frame("camera", "down", turn)):
        data = replace(a_set(), frame=frame, metres_per_unit=0.01)
        data = replace(data, scenes=(replace(data.scenes[0], metres_per_unit=0.02),))
        folder = tmp_path / str(id(frame))
        write_set(data, folder)
        again = read_set(folder)
        assert again == data
        assert again.frame == frame
        assert again.scale_of(again.scenes[0]) == 0.02
        written = json.loads((folder / "dataset.json").read_text())
        assert ("frame" in written) == (frame is not None)


def test_a_frame_that_is_none_is_refused_in_one_line(tmp_path: Path) -> None:
    write_set(a_set(), tmp_path / "s")
    file = tmp_path / "s" / "dataset.json"
    good = json.loads(file.read_text())
    for frame, field in (
        ({"y": "left"}, "frame.y"),
        ({"y": "up", "homography": [[1, 0], [0, 1]]}, "frame.homography"),
        ({"y": "up", "homography": [[1, 0, 0], [2, 0, 0], [0, 0, 1]]}, "frame.homography"),
        ("map", "frame"),
    ):
        file.write_text(json.dumps({**good, "frame": frame}))
        with pytest.raises(InputError, match=field):
            read_set(tmp_path / "s")


def test_metres_say_their_own_scale() -> None:
    assert [a_set(u).metres_per_unit for u in ("px", "m", "cm", "mm")] == [None, 1.0, 0.01, 0.001]
    with pytest.raises(InputError, match=r"metres_per_unit: expected 0\.01 or null"):
        replace(a_set("cm"), metres_per_unit=0.5)
    assert edit.rescale(a_set("m"), 100.0).units == "cm"
    assert edit.rescale(a_set("m"), 250.0).units == "px"
    assert edit.rescale(a_set("m"), 250.0).metres_per_unit == pytest.approx(0.004)


def test_what_was_metres_goes_back_to_where_it_was() -> None:
    matrix = ((0.002, 0.0001, 0.3), (0.0, -0.002, 0.9), (0.0, 0.0001, 1.0))
    data = replace(a_set(picture=True), frame=Frame("map", "up", matrix), metres_per_unit=0.002)

    for other in (edit.rescale(data, 2.5), edit.crop(data, (3, 4, 50, 40))):
        np.testing.assert_allclose(metres(other), metres(data), rtol=1e-12)
    named = replace(a_set(), frame=Frame("map", "up"), metres_per_unit=0.01)
    assert edit.rescale(named, 4.0).frame == Frame("map", "up")
    moved = edit.crop(replace(named, scenes=data.scenes), (3, 4, 50, 40))
    np.testing.assert_allclose(metres(moved), named.demonstrations.flat[:, :2] * 0.01)


def test_pictures_of_another_scale_keep_theirs_when_sets_are_joined() -> None:
    first = replace(a_set(name="a"), metres_per_unit=0.01)
    second = replace(a_set(name="b"), metres_per_unit=0.001)
    both = edit.merge([first, second])
    assert [both.scale_of(s) for s in both.scenes] == [0.01, 0.001]
    with pytest.raises(InputError, match="metres_per_unit"):
        edit.merge([first, replace(second, metres_per_unit=None)])


def test_ruler(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert metres_of_words("30 cm") == pytest.approx(0.3)
    assert metres_of_words("250mm") == pytest.approx(0.25)
    assert ruler((0, 0), (30, 40), 0.5) == pytest.approx(0.01)
    for words in ("", "30", "-3cm", "3 feet", "0m"):
        with pytest.raises(InputError, match="length"):
            metres_of_words(words)
    write_set(a_set(), tmp_path / "s")
    arguments = ["edit", "rescale", str(tmp_path / "s"), "--ruler", "0", "0", "30", "40", "50cm"]
    assert run([*arguments, "--out", str(tmp_path / "all")]) == 0
    assert read_set(tmp_path / "all").metres_per_unit == pytest.approx(0.01)
    assert run([*arguments, "--scene", "a", "--out", str(tmp_path / "one")]) == 0
    one = read_set(tmp_path / "one")
    assert one.metres_per_unit is None
    assert one.scale_of(one.scene("a")) == pytest.approx(0.01)
    capsys.readouterr()
    for wrong in (["--factor", "2"], ["--scene", "nowhere"]):
        assert run([*arguments, *wrong, "--out", str(tmp_path / "no")]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    (tmp_path / "p.csv").write_text("demo,x,y\n1,0,0\n1,30,40\n")
    arguments = ["convert", str(tmp_path / "p.csv"), str(tmp_path / "c"), "--ruler", "0", "0"]
    assert run([*arguments, "30", "40", "50cm"]) == 0
    assert read_set(tmp_path / "c").metres_per_unit == pytest.approx(0.01)


def test_a_converted_recording_goes_back_into_its_frame(tmp_path: Path) -> None:
    points = np.array([[0.1, 0.2], [0.4, 0.3], [0.7, 0.9]])
    rows = "".join(f"1,{x},{y}\n" for x, y in points)
    (tmp_path / "p.csv").write_text("demo,x,y\n" + rows)
    pairs = [[[0, 0], [10, 200]], [[1, 0], [210, 190]], [[1, 1], [190, 20]], [[0, 1], [15, 10]]]
    mapping = {"units": "m", "projection": {"pairs": pairs}}
    (tmp_path / "map.json").write_text(json.dumps(mapping))
    convert(tmp_path / "p.csv", tmp_path / "s", mapping=read_mapping(tmp_path / "map.json"))
    data = read_set(tmp_path / "s")
    assert data.units == "px"
    assert data.frame is not None
    np.testing.assert_allclose(metres(data), points, atol=1e-9)
