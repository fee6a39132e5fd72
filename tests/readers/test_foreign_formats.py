"""Close of the work: files written by other libraries become sets that read and check clean."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from foreign_files import (
    arc,
    picture,
    write_bag,
    write_lerobot,
    write_mcap,
    write_robomimic,
    write_ros1,
)

from demospec.demonstrations import check_set, read_set
from demospec.demonstrations.readers import Mapping, convert, guess_format, read_source
from demospec.errors import InputError

# Metres on the table to pixels of a 64×48 picture: 80 pixels a metre, y up.
TO_PIXELS = {"pairs": [[[0, 0], [0, 48]], [[0.8, 0], [64, 48]], [[0, 0.6], [0, 0]],
                       [[0.8, 0.6], [64, 0]]]}  # fmt: skip


def mapping(**given: object) -> Mapping:
    return Mapping.model_validate(given)


def in_pixels(points: np.ndarray) -> np.ndarray:
    return np.stack([80 * points[:, 0], 48 - 80 * points[:, 1], 80 * points[:, 2]], axis=1)


def test_robomimic_written_by_h5py(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    paths = write_robomimic(tmp_path / "low_dim.hdf5")
    assert guess_format(tmp_path / "low_dim.hdf5") == "hdf5"
    convert(
        tmp_path / "low_dim.hdf5",
        tmp_path / "set",
        mapping=mapping(picture="obs/agentview_image", projection=TO_PIXELS),
    )
    data = read_set(tmp_path / "set")
    assert [d.demo_id for d in data.demonstrations] == [f"demo_{i}" for i in range(4)]
    assert [d.valid for d in data.demonstrations] == [True, False, True, False]
    assert data.columns == ("x", "y", "z")
    for demonstration, points in zip(data.demonstrations, paths, strict=True):
        np.testing.assert_allclose(demonstration.points[:, :3], in_pixels(points), atol=1e-9)
    assert data.metres_per_unit == pytest.approx(1 / 80)
    assert [s.split for s in data.scenes] == ["train", "train", "train", "test"]
    assert np.array_equal(data.scenes[2].pixels(), picture(2))
    assert check_set(tmp_path / "set").readable


@pytest.mark.parametrize("camera", ["image", "video"])
def test_lerobot_v3_written_by_pyarrow(tmp_path: Path, camera: str) -> None:
    if camera == "video":
        pytest.importorskip("av", reason="pip install 'demospec[video]'")
    paths = write_lerobot(tmp_path / "source", camera=camera)
    assert guess_format(tmp_path / "source") == "lerobot"
    result = convert(
        tmp_path / "source",
        tmp_path / "set",
        mapping=mapping(picture="observation.images.top", projection=TO_PIXELS),
    )
    data = read_set(tmp_path / "set")
    assert [d.valid for d in data.demonstrations] == [True, False, True]
    assert [s.split for s in data.scenes] == ["train", "train", "test"]
    for demonstration, points in zip(data.demonstrations, paths, strict=True):
        np.testing.assert_allclose(demonstration.points[:, :3], in_pixels(points), atol=1e-5)
        assert demonstration.t is not None
        np.testing.assert_allclose(demonstration.t, np.arange(len(points)) / 10, atol=1e-6)
    for i, scene in enumerate(data.scenes):
        # Video is lossy; each episode must still show its own blocks.
        gap = np.abs(scene.pixels().astype(int) - picture(i).astype(int)).mean()
        others = [
            np.abs(scene.pixels().astype(int) - picture(j).astype(int)).mean()
            for j in range(3)
            if j != i
        ]
        assert gap == 0 if camera == "image" else gap < 0.3 * min(others)
    assert result.format == "lerobot"


def test_lerobot_without_a_picture_keeps_metres(tmp_path: Path) -> None:
    paths = write_lerobot(tmp_path / "source", camera="image")
    result = read_source(tmp_path / "source")
    assert result.data.units == "m"
    assert result.data.metres_per_unit == 1.0
    assert result.data.columns == ("x", "y", "z", "gripper")
    np.testing.assert_allclose(result.data.demonstrations[1].points[:, :3], paths[1], atol=1e-6)
    assert any("observation.images.top" in note for note in result.notes)


@pytest.mark.parametrize("storage", ["sqlite", "mcap", "bare mcap"])
def test_ros_bags_written_by_rosbags_and_mcap(tmp_path: Path, storage: str) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
    pytest.importorskip("mcap", reason="pip install 'demospec[ros]'")
    bags = tmp_path / "bags"
    bags.mkdir()
    paths = [arc(20, 0.0), arc(30, 0.1)]
    for i, points in enumerate(paths):
        if storage == "bare mcap":
            write_mcap(bags / f"run{i}.mcap", points, i == 0)
        else:
            write_bag(bags / f"run{i}", points, i == 0, mcap=storage == "mcap")
    assert guess_format(bags) == "ros"
    convert(
        bags,
        tmp_path / "set",
        mapping=mapping(picture="/camera", projection=TO_PIXELS, valid="/success", type="/user"),
    )
    data = read_set(tmp_path / "set")
    assert [d.demo_id for d in data.demonstrations] == ["run0", "run1"]
    assert [d.valid for d in data.demonstrations] == [True, False]
    assert data.types == ("careful",)
    for demonstration, points in zip(data.demonstrations, paths, strict=True):
        np.testing.assert_allclose(demonstration.points[:, :3], in_pixels(points), atol=1e-9)
        assert demonstration.t is not None
        np.testing.assert_allclose(demonstration.t, 0.1 * np.arange(len(points)), atol=1e-6)
    assert np.array_equal(data.scenes[0].pixels(), picture(3))


def test_joints_by_name(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
    write_bag(tmp_path / "bag", arc(20), True)
    how = mapping(path="/joint_states", columns={"x": "gantry_x", "y": "gantry_y"})
    data = read_source(tmp_path / "bag", mapping=how).data
    np.testing.assert_allclose(data.demonstrations[0].points, arc(20)[:, :2])


def test_older_and_bare_bags(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
    write_ros1(tmp_path / "old.bag", arc(5))
    item = read_source(tmp_path / "old.bag").data.demonstrations[0]
    np.testing.assert_allclose(item.points[:, :3], arc(5))
    assert item.t is not None
    assert item.t.tolist() == [0, 1, 2, 3, 4]
    write_bag(tmp_path / "bag", arc(5), True)
    (storage,) = (tmp_path / "bag").glob("*.db3")
    bare = storage.rename(tmp_path / "bare.db3")
    item = read_source(bare, mapping=mapping(path="/tool_pose")).data.demonstrations[0]
    np.testing.assert_allclose(item.points[:, :3], arc(5))


def test_several_pose_topics_must_be_told_apart(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
    write_bag(tmp_path / "bag", arc(5), True)
    with pytest.raises(InputError, match="a topic /nowhere"):
        read_source(tmp_path / "bag", mapping=mapping(path="/nowhere"))
    with pytest.raises(InputError, match="a field /nowhere"):
        read_source(tmp_path / "bag", mapping=mapping(path="/tool_pose", valid="/nowhere"))
