"""Transforms: chains composed at the time of the sample, and no guess between candidates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
pytest.importorskip("mcap", reason="pip install 'demospec[ros]'")

from bags import bag, foxglove, header, mcap_file, protobuf_file, ros, stamped, tf

from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import InputError

TF = "tf2_msgs/msg/TFMessage"
LEVEL = (0.0, 0.0, 0.0, 1.0)
LEFT = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))
"""A quarter turn about z: x becomes y."""


def read(source: Path, path: str | None = None, **more: Any) -> Any:
    return read_source(source, mapping=Mapping(path=path, **more))


def points(source: Path, path: str | None = None, **more: Any) -> np.ndarray:
    return read(source, path, **more).data.demonstrations[0].points[:, :3]


def moving(name: str, n: int = 11, parent: str = "world") -> list[Any]:
    """A frame that goes from x = 0 to 1 in one second."""
    return [
        ("/tf", TF, 10 + s, tf(10 + s, (parent, name, (s, 0, 0), LEVEL)))
        for s in np.linspace(0, 1, n)
    ]


def still(parent: str, child: str, at: Sequence[float], turn: Sequence[float] = LEVEL) -> Any:
    return ("/tf_static", TF, 10.0, tf(9.0, (parent, child, at, turn)))


def test_the_only_moving_transform_needs_no_name(tmp_path: Path) -> None:
    source = bag(tmp_path / "b", [still("world", "table", (5, 5, 5)), *moving("tool")])
    np.testing.assert_allclose(points(source, "/tf")[:, 0], np.linspace(0, 1, 11))


def test_several_moving_transforms_are_listed(tmp_path: Path) -> None:
    source = bag(tmp_path / "b", [*moving("tool"), *moving("odom", parent="map")])
    with pytest.raises(InputError, match="world>tool, map>odom"):
        read(source, "/tf")


def test_a_frame_under_two_parents_needs_the_parent(tmp_path: Path) -> None:
    messages = [*moving("base", parent="odom"), *moving("base", n=5, parent="map")]
    source = bag(tmp_path / "b", sorted(messages, key=lambda m: m[2]))
    with pytest.raises(InputError, match="odom>base, map>base"):
        read(source, "/tf:base")
    assert len(points(source, "/tf:odom>base")) == 11
    assert len(points(source, "/tf:map>base")) == 5


def test_a_chain_with_a_static_end_is_composed(tmp_path: Path) -> None:
    source = bag(tmp_path / "b", [still("wrist", "tool", (0, 0, 0.1)), *moving("wrist")])
    found = points(source, "/tf:tool")
    np.testing.assert_allclose(found[:, 0], np.linspace(0, 1, 11))
    np.testing.assert_allclose(found[:, 2], 0.1)
    assert any("world > wrist > tool" in note for note in read(source, "/tf:tool").notes)


def test_turns_carry_what_hangs_on_them(tmp_path: Path) -> None:
    links = [
        still("world", "base", (1, 2, 0), LEFT),
        still("hand", "tool", (0.5, 0, 0), LEFT),
        *moving("hand", parent="base"),
    ]
    source = bag(tmp_path / "b", links)
    # The base is turned to the left, so that the hand runs along y; half a metre further, too.
    found = read(source, "/tf:tool").data.demonstrations[0].points
    np.testing.assert_allclose(found[:, 0], 1, atol=1e-12)
    np.testing.assert_allclose(found[:, 1], 2.5 + np.linspace(0, 1, 11))


def test_two_moving_links_are_read_at_the_time_of_the_sample(tmp_path: Path) -> None:
    # The lift is published twice a second, the tool ten times; between, the lift is interpolated.
    lift = [
        ("/tf", TF, t, tf(t, ("world", "lift", (0, 0, 2 * (t - 10)), LEVEL)))
        for t in (10.0, 10.5, 11.0)
    ]
    source = bag(tmp_path / "b", sorted([*moving("tool", parent="lift"), *lift],
                                        key=lambda m: m[2]))  # fmt: skip
    found = points(source, "/tf:tool")
    np.testing.assert_allclose(found[:, 0], np.linspace(0, 1, 11))
    np.testing.assert_allclose(found[:, 2], np.linspace(0, 2, 11), atol=1e-7)


def test_samples_without_a_known_chain_are_left_out_and_counted(tmp_path: Path) -> None:
    lift = [("/tf", TF, t, tf(t, ("world", "lift", (0, 0, t), LEVEL))) for t in (10.45, 10.75)]
    source = bag(tmp_path / "b", sorted([*moving("tool", parent="lift"), *lift],
                                        key=lambda m: m[2]))  # fmt: skip
    result = read(source, "/tf:tool")
    assert len(result.data.demonstrations[0].points) == 3
    assert any("8 samples left out" in note for note in result.notes)


def test_a_frame_seen_from_one_that_moves_itself(tmp_path: Path) -> None:
    source = bag(
        tmp_path / "b",
        [still("world", "camera", (0, 0, 3)), still("hand", "tool", (0, 1, 0)), *moving("hand")],
    )
    found = points(source, "/tf:camera>tool")
    np.testing.assert_allclose(found, [[s, 1, -3] for s in np.linspace(0, 1, 11)], atol=1e-12)
    back = points(source, "/tf:tool>camera")
    np.testing.assert_allclose(back, [[-s, -1, 3] for s in np.linspace(0, 1, 11)], atol=1e-12)


def test_the_stamps_count_not_the_order_of_recording(tmp_path: Path) -> None:
    messages = moving("tool")
    shuffled = [
        (topic, kind, 10 + i / 10, message)
        for i, (topic, kind, _, message) in enumerate([*messages[5:], *messages[:5]])
    ]
    found = points(bag(tmp_path / "b", shuffled), "/tf:tool")
    np.testing.assert_allclose(found[:, 0], np.linspace(0, 1, 11))


def test_static_transforms_of_another_robot_are_not_taken(tmp_path: Path) -> None:
    own = [("/one" + t, *rest) for t, *rest in [still("wrist", "tool", (0, 0, 0.1)),
                                                *moving("wrist")]]  # fmt: skip
    other = [("/two/tf_static", TF, 10.0, tf(9.0, ("wrist", "tool", (0, 0, 7), LEVEL)))]
    found = points(bag(tmp_path / "b", [*other, *own]), "/one/tf:tool")
    np.testing.assert_allclose(found[:, 2], 0.1)


@pytest.mark.parametrize(
    ("path", "match"),
    [
        ("/tf:nowhere", "a frame nowhere"),
        ("/tf:world>nowhere", "a frame nowhere"),
        ("/tf:island>tool", "transforms from island to tool"),
        ("/tf:world", "hangs on another"),
        ("/tf:far>island", "a transform that moves"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path: Path, path: str, match: str) -> None:
    source = bag(tmp_path / "b", [still("far", "island", (0, 0, 0)), *moving("tool")])
    with pytest.raises(InputError, match=match):
        read(source, path)


def test_a_circle_of_frames_is_refused(tmp_path: Path) -> None:
    source = bag(tmp_path / "b", [still("tool", "world", (0, 0, 0)), *moving("tool")])
    with pytest.raises(InputError, match="a circle"):
        read(source, "/tf:tool")


def test_a_rotation_that_is_none_is_refused(tmp_path: Path) -> None:
    source = bag(tmp_path / "b", [still("wrist", "tool", (0, 0, 0), (0, 0, 0, 0)),
                                  *moving("wrist")])  # fmt: skip
    with pytest.raises(InputError, match="a unit quaternion"):
        read(source, "/tf:tool")


def test_transforms_cut_into_demonstrations(tmp_path: Path) -> None:
    word = "std_msgs/msg/String"
    cuts = [
        ("/episode", word, 10.05, ros(word, data="a")),
        ("/episode", word, 10.45, ros(word, data="")),
        ("/episode", word, 10.65, ros(word, data="b")),
    ]
    messages = sorted([*moving("wrist"), *cuts], key=lambda m: m[2])
    source = bag(tmp_path / "b", [still("wrist", "tool", (0, 0, 0.1)), *messages])
    data = read(source, "/tf:tool", demonstration="/episode").data
    assert [d.demo_id for d in data.demonstrations] == ["b-a", "b-b"]
    assert [len(d.points) for d in data.demonstrations] == [4, 4]


def test_poses_in_two_frames_are_refused(tmp_path: Path) -> None:
    kind = "geometry_msgs/msg/PoseStamped"
    messages = [
        ("/pose", kind, t, stamped(t, (t, 0, 0), "map" if t < 5 else "odom")) for t in range(1, 9)
    ]
    with pytest.raises(InputError, match="map, odom"):
        read(bag(tmp_path / "b", messages))


def test_bags_in_two_frames_are_refused(tmp_path: Path) -> None:
    kind = "geometry_msgs/msg/PoseStamped"
    for name, frame in (("one", "map"), ("two", "odom")):
        bag(tmp_path / "bags" / name, [
            ("/pose", kind, t, stamped(t, (t, 0, 0), frame)) for t in (1.0, 2.0)
        ])  # fmt: skip
    with pytest.raises(InputError, match="the frame map, as in one"):
        read(tmp_path / "bags")


def test_the_orientation_comes_with_the_pose(tmp_path: Path) -> None:
    kind = "geometry_msgs/msg/PoseStamped"
    messages = [("/pose", kind, t, stamped(t, (t, 0, 0), q=LEFT)) for t in (1.0, 2.0, 3.0)]
    from demospec.demonstrations.readers._recording import Pictures
    from demospec.demonstrations.readers.ros._reader import read_bags
    from demospec.progress import silent

    source = read_bags(bag(tmp_path / "b", messages), Mapping(), silent, Pictures())
    assert source.recordings[0].columns == ("x", "y", "z", "qx", "qy", "qz", "qw")
    np.testing.assert_allclose(source.recordings[0].points[:, 3:], [LEFT] * 3)


def test_joints_in_another_order_are_the_same_joints(tmp_path: Path) -> None:
    kind = "sensor_msgs/msg/JointState"
    none = np.zeros(0)
    messages = []
    for i in range(4):
        names, values = ["a", "b"], np.array([float(i), 10.0 + i])
        if i % 2:
            names, values = names[::-1], values[::-1].copy()
        message = ros(kind, header=header(1.0 + i), name=names, position=values, velocity=none,
                      effort=none)  # fmt: skip
        messages.append(("/joints", kind, 1.0 + i, message))
    found = points(bag(tmp_path / "b", messages), "/joints", columns={"x": "a", "y": "b"})
    np.testing.assert_allclose(found, [[i, 10 + i] for i in range(4)])


def test_foxglove_transforms_in_protobuf(tmp_path: Path) -> None:
    pytest.importorskip("mcap_protobuf", reason="pip install 'demospec[ros]'")
    kinds = foxglove()

    def link(seconds: float, parent: str, child: str, x: float, z: float = 0.0) -> Any:
        made = kinds["FrameTransform"](parent_frame_id=parent, child_frame_id=child)
        made.timestamp.seconds = int(seconds)
        made.timestamp.nanos = round((seconds % 1) * 1e9)
        made.translation.x, made.translation.z = x, z
        made.rotation.w = 1.0
        return kinds["FrameTransforms"](transforms=[made])

    messages = [("/tf", 10 + s, link(10 + s, "world", "wrist", s)) for s in (0.0, 0.5, 1.0)]
    messages.append(("/tf_static", 10.0, link(10.0, "wrist", "tool", 0.0, 0.25)))
    source = protobuf_file(tmp_path / "f.mcap", messages)
    np.testing.assert_allclose(
        points(source, "/tf:world>tool"), [[0, 0, 0.25], [0.5, 0, 0.25], [1, 0, 0.25]]
    )


def test_mcap_and_sqlite_bags_give_the_same(tmp_path: Path) -> None:
    messages = [still("wrist", "tool", (0, 0, 0.1), LEFT), *moving("wrist")]
    found = [
        points(bag(tmp_path / "a", messages), "/tf:tool"),
        points(bag(tmp_path / "b", messages, mcap=True), "/tf:tool"),
        points(mcap_file(tmp_path / "c.mcap", messages), "/tf:tool"),
    ]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
