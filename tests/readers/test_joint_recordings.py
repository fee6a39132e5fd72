"""Joint recordings: forward kinematics against an arm whose place is known by hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="pip install 'demospec[robot]'")

from demospec.demonstrations import read_set
from demospec.demonstrations.readers import Mapping, convert, read_source
from demospec.errors import InputError

LIMIT = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
ARM = f"""<?xml version="1.0"?>
<robot name="arm">
  <link name="base"><visual><geometry><mesh filename="package://no/such.stl"/></geometry></visual>
  </link>
  <link name="post"/><link name="upper"/><link name="lower"/><link name="tool"/>
  <link name="finger"/>
  <joint name="lift" type="prismatic"><parent link="base"/><child link="post"/>
    <axis xyz="0 0 1"/>{LIMIT}</joint>
  <joint name="shoulder_joint" type="revolute"><parent link="post"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="elbow_joint" type="revolute"><origin xyz="1 0 0"/><parent link="upper"/>
    <child link="lower"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="flange" type="fixed"><origin xyz="0.5 0 0"/><parent link="lower"/>
    <child link="tool"/></joint>
  <joint name="finger_joint" type="revolute"><parent link="tool"/><child link="finger"/>
    <axis xyz="0 0 1"/><limit lower="-6" upper="6" effort="1" velocity="1"/>
    <mimic joint="shoulder_joint" multiplier="2" offset="0.1"/></joint>
</robot>
"""
N = 9
SHOULDER, ELBOW = np.linspace(-1.0, 1.2, N), np.linspace(0.5, -0.7, N)
LIFTED = np.linspace(0.0, 0.4, N)


def by_hand(shoulder: np.ndarray = SHOULDER, elbow: np.ndarray = ELBOW) -> np.ndarray:
    """The tool's x, y, z and its turn about z as a quaternion, (n, 7)."""
    whole = shoulder + elbow
    x = np.cos(shoulder) + 0.5 * np.cos(whole)
    y = np.sin(shoulder) + 0.5 * np.sin(whole)
    zero = np.zeros(len(x))
    return np.stack(
        [x, y, LIFTED, zero, zero, np.sin(whole / 2), np.cos(whole / 2)], axis=1
    )  # fmt: skip


def table(folder: Path, header: str, *columns: np.ndarray, name: str = "run.csv") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(ARM)
    rows = [",".join(repr(float(v)) for v in row) for row in zip(*columns, strict=True)]
    (folder / name).write_text("\n".join([header, *rows]) + "\n")
    return folder / name


def read(source: Path, link: str = "tool", unit: str | None = None, **how: Any) -> Any:
    robot = {"urdf": "arm.urdf", "link": link, **({} if unit is None else {"unit": unit})}
    return read_source(source, mapping=Mapping.model_validate({"robot": robot, **how}))


def points(source: Path, *args: Any, **how: Any) -> np.ndarray:
    (item,) = read(source, *args, **how).data.demonstrations
    return item.points


def test_the_tool_is_where_the_joints_put_it(tmp_path: Path) -> None:
    file = table(tmp_path, "lift,elbow_joint,shoulder_joint", LIFTED, ELBOW, SHOULDER)
    result = read(file)
    assert result.data.columns == ("x", "y", "z", "qx", "qy", "qz", "qw")
    assert result.data.units == "m"
    np.testing.assert_allclose(result.data.demonstrations[0].points, by_hand(), atol=1e-12)
    assert result.reading.frame.name == "base"
    assert any("tool in base" in note for note in result.notes)


@pytest.mark.parametrize(
    "header",
    [
        "lift,shoulder_joint,elbow_joint",
        "lift,shoulder,elbow",
        "lift.pos,shoulder.pos,elbow.pos",
        "Lift,Shoulder_Joint,Elbow_Joint",
        "robot/lift,robot/shoulder_joint,robot/elbow_joint",
        "lift,shoulder_joint [rad],elbow_joint [rad]",
    ],
)
def test_joints_are_found_by_their_names(tmp_path: Path, header: str) -> None:
    file = table(tmp_path, header, LIFTED, SHOULDER, ELBOW)
    np.testing.assert_allclose(points(file), by_hand(), atol=1e-12)


@pytest.mark.parametrize(
    ("header", "unit"),
    [
        ("lift,shoulder_joint,elbow_joint", "deg"),
        ("lift,shoulder_joint (deg),elbow_joint (deg)", None),
        ("lift,shoulder_deg,elbow_deg", None),
    ],
)
def test_degrees(tmp_path: Path, header: str, unit: str | None) -> None:
    file = table(tmp_path, header, LIFTED, np.rad2deg(SHOULDER), np.rad2deg(ELBOW))
    np.testing.assert_allclose(points(file, unit=unit), by_hand(), atol=1e-12)


def test_degrees_taken_for_radians_are_refused(tmp_path: Path) -> None:
    file = table(tmp_path, "lift,shoulder,elbow", LIFTED, np.rad2deg(SHOULDER), ELBOW)
    with pytest.raises(InputError, match=r"rad from -3 to 3 rad.*--joint-unit deg") as caught:
        read(file)
    assert caught.value.field == "shoulder"


def test_what_mimics_a_joint_needs_no_column(tmp_path: Path) -> None:
    file = table(tmp_path, "lift,shoulder,elbow", LIFTED, SHOULDER, ELBOW)
    found = points(file, "finger")
    turn = SHOULDER + ELBOW + 2 * SHOULDER + 0.1
    np.testing.assert_allclose(found[:, :3], by_hand()[:, :3], atol=1e-12)
    same = np.abs(found[:, 5] * np.sin(turn / 2) + found[:, 6] * np.cos(turn / 2))
    np.testing.assert_allclose(same, 1.0)


def test_time_gripper_and_labels_stay_and_positions_go(tmp_path: Path) -> None:
    t, open_ = np.arange(N) * 0.1, np.linspace(0, 1, N)
    file = table(
        tmp_path, "t,x,y,lift,shoulder,elbow,gripper", t, t, t, LIFTED, SHOULDER, ELBOW, open_
    )
    data = read(file).data
    assert data.columns == ("x", "y", "z", "qx", "qy", "qz", "qw", "gripper")
    (item,) = data.demonstrations
    np.testing.assert_allclose(item.points[:, :7], by_hand(), atol=1e-12)
    np.testing.assert_allclose(item.points[:, 7], open_)
    assert item.t is not None
    np.testing.assert_allclose(item.t - item.t[0], t, atol=1e-12)


def test_columns_without_names_are_named_by_the_mapping(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    table(tmp_path, "a", SHOULDER)
    values = np.stack([SHOULDER, np.zeros(N), ELBOW, LIFTED], axis=1)
    with h5py.File(tmp_path / "episode_0.hdf5", "w") as file:
        file["observations/qpos"] = values
        file["action"] = values
    source = tmp_path / "episode_0.hdf5"
    columns = {"shoulder_joint": 0, "elbow_joint": 2, "lift": 3}
    np.testing.assert_allclose(points(source, columns=columns), by_hand(), atol=1e-12)
    with pytest.raises(InputError, match="one column for the joint lift"):
        read(source)
    with pytest.raises(InputError, match="a column for each joint"):
        read(source, columns={**columns, "lift": 2})
    with pytest.raises(InputError, match="found wrist"):
        read(source, columns={**columns, "wrist": 1})


def test_joint_states_of_a_bag(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
    from bags import bag, header, ros

    table(tmp_path, "a", SHOULDER)
    kind, none = "sensor_msgs/msg/JointState", np.zeros(0)
    messages = [
        ("/joint_states", kind, 1.0 + i,
         ros(kind, header=header(1.0 + i), name=["elbow_joint", "shoulder_joint", "lift"],
             position=np.array([ELBOW[i], SHOULDER[i], LIFTED[i]]), velocity=none, effort=none))
        for i in range(N)
    ]  # fmt: skip
    robot = {"urdf": str(tmp_path / "arm.urdf"), "link": "tool"}
    found = points(bag(tmp_path / "bag", messages), robot=robot)
    np.testing.assert_allclose(found, by_hand(), atol=1e-12)


def test_joints_in_json(tmp_path: Path) -> None:
    table(tmp_path, "a", SHOULDER)
    joints = {"lift": LIFTED, "shoulder_joint": SHOULDER, "elbow_joint": ELBOW}
    lists = {name: values.tolist() for name, values in joints.items()}
    (tmp_path / "a.json").write_text(json.dumps([{"id": "d", "points": lists, "valid": True}]))
    data = read(tmp_path / "a.json").data
    np.testing.assert_allclose(data.demonstrations[0].points, by_hand(), atol=1e-12)
    assert data.demonstrations[0].valid is True


@pytest.mark.parametrize(
    ("robot", "match"),
    [
        ({"urdf": "arm.urdf", "link": "hand"}, "a link hand"),
        ({"urdf": "arm.urdf", "link": "base"}, "a link that a joint moves"),
        ({"urdf": "missing.urdf", "link": "tool"}, "no such file"),
        ({"urdf": "pandda", "link": "tool"}, "panda"),
    ],
)
def test_robots_and_links_that_are_not_there(
    tmp_path: Path, robot: dict[str, str], match: str
) -> None:
    file = table(tmp_path, "lift,shoulder,elbow", LIFTED, SHOULDER, ELBOW)
    with pytest.raises(InputError, match=match):
        read_source(file, mapping=Mapping.model_validate({"robot": robot}))


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("not XML", "a URDF file"),
        ("<sdf/>", "an element robot"),
        ('<robot name="r"/>', "xacro"),
        ("<!DOCTYPE a><robot/>", "a document type"),
        (ARM.replace('<parent link="lower"/>', ""), "a parent and a child"),
        (ARM.replace('type="prismatic"', 'type="floating"'), "one of fixed"),
        (ARM.replace('<child link="tool"/>', '<child link="upper"/>'), "one joint above"),
        (ARM.replace('<link name="post"/>', '<link name="post"/><link name="stray"/>'), "one link"),
        (ARM.replace('lower="-3"', 'lower="low"', 1), "numbers"),
        (ARM.replace('mimic joint="shoulder_joint"', 'mimic joint="ghost"'), "a joint to mimic"),
    ],
)
def test_descriptions_that_cannot_be_read(tmp_path: Path, text: str, match: str) -> None:
    file = table(tmp_path, "lift,shoulder,elbow", LIFTED, SHOULDER, ELBOW)
    (tmp_path / "arm.urdf").write_text(text)
    with pytest.raises(InputError, match=match):
        read(file, "finger")


def test_a_missing_cell_is_named(tmp_path: Path) -> None:
    file = table(tmp_path, "lift,shoulder,elbow", LIFTED, SHOULDER, ELBOW)
    lines = file.read_text().splitlines()
    lines[3] = "0.1,,0.2"
    file.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match="line 4") as caught:
        read(file)
    assert caught.value.field == "shoulder"


def test_robots_by_name(tmp_path: Path) -> None:
    from importlib import metadata

    try:
        metadata.files("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("pip install 'demospec[robot]'")
    names = [f"panda_joint{i}" for i in range(1, 8)]
    rest = np.tile([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], (N, 1))
    rest[:, 0] = np.linspace(-1, 1, N)
    file = table(tmp_path, ",".join(names), *rest.T)
    robot = {"urdf": "panda", "link": "panda_link8"}
    (item,) = read_source(
        file, mapping=Mapping.model_validate({"robot": robot})
    ).data.demonstrations
    # The ready posture of the arm's documentation: the flange at (0.307, 0, 0.59) m.
    radius = np.hypot(item.points[:, 0], item.points[:, 1])
    np.testing.assert_allclose(radius, 0.307, atol=2e-3)
    np.testing.assert_allclose(item.points[:, 2], 0.59, atol=2e-3)
    np.testing.assert_allclose(
        np.arctan2(item.points[:, 1], item.points[:, 0]), rest[:, 0], atol=1e-3
    )


def test_the_command(tmp_path: Path) -> None:
    from demospec.cli import main

    file = table(tmp_path, "lift,shoulder,elbow", LIFTED, np.rad2deg(SHOULDER), np.rad2deg(ELBOW))
    robot = ["--urdf", "arm.urdf", "--link", "tool", "--joint-unit", "deg"]
    with pytest.raises(SystemExit) as done:
        main(["convert", str(file), str(tmp_path / "set"), *robot])
    assert not done.value.code
    (item,) = read_set(tmp_path / "set").demonstrations
    np.testing.assert_allclose(item.points, by_hand(), atol=1e-12)


def test_the_mapping_is_kept_as_it_was_said(tmp_path: Path) -> None:
    file = table(tmp_path / "in", "a,b,c", LIFTED, SHOULDER, ELBOW)
    columns = {"lift": "a", "shoulder_joint": "b", "elbow_joint": "c"}
    robot = {"urdf": "arm.urdf", "link": "tool"}
    how = Mapping.model_validate({"robot": robot, "columns": columns})
    convert(file, tmp_path / "set", mapping=how)
    kept = json.loads((tmp_path / "set" / "provenance.json").read_text())["mapping"]
    assert kept == {"robot": robot, "columns": columns}
