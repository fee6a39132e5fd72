"""Bags as other programs leave them, and topics whose messages are whole paths."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
pytest.importorskip("mcap", reason="pip install 'demospec[ros]'")

from bags import bag, foxglove, mcap_file, path, poses, protobuf_file, stamped

from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import InputError

PATH = "nav_msgs/msg/Path"
POSE = "geometry_msgs/msg/PoseStamped"
WAY = [(0.1 * i, 0.05 * i * i, 0.3) for i in range(12)]


def read(source: Path, topic: str | None = None, **more: Any) -> Any:
    return read_source(source, mapping=Mapping(path=topic, **more))


def only(source: Path, topic: str | None = None) -> np.ndarray:
    (item,) = read(source, topic).data.demonstrations
    return item.points[:, :3]


def replans(counts: tuple[int, ...] = (12, 8, 4)) -> list[Any]:
    """Plans while the robot drives: each the part that remains."""
    return [("/plan", PATH, 1.0 + i, path(1.0 + i, WAY[12 - n :])) for i, n in enumerate(counts)]


def test_one_path_is_one_demonstration(tmp_path: Path) -> None:
    np.testing.assert_allclose(only(bag(tmp_path / "b", replans((12,)))), WAY)


def test_several_paths_are_refused_with_their_lengths(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"3 paths on /plan \(12, 8, 4 points\)"):
        read(bag(tmp_path / "b", replans()))


@pytest.mark.parametrize(
    ("choice", "counts"),
    [("all", [12, 8, 4]), ("first", [12]), ("last", [4]), ("1", [8])],
)
def test_paths_that_are_chosen(tmp_path: Path, choice: str, counts: list[int]) -> None:
    data = read(bag(tmp_path / "b", replans()), f"/plan:{choice}").data
    assert [len(d.points) for d in data.demonstrations] == counts
    names = [d.demo_id for d in data.demonstrations]
    assert names == (["b-0", "b-1", "b-2"] if choice == "all" else ["b"])


@pytest.mark.parametrize("choice", ["3", "any", "-1"])
def test_paths_that_are_not_there(tmp_path: Path, choice: str) -> None:
    with pytest.raises(InputError, match="path"):
        read(bag(tmp_path / "b", replans()), f"/plan:{choice}")


def test_a_path_that_only_grows_is_its_last_message(tmp_path: Path) -> None:
    messages = [("/trace", PATH, 1.0 + n, path(1.0 + n, WAY[:n])) for n in (2, 5, 12)]
    result = read(bag(tmp_path / "b", messages))
    np.testing.assert_allclose(result.data.demonstrations[0].points[:, :3], WAY)
    assert any("the last of 3 paths" in note for note in result.notes)


def test_the_same_path_again_is_one_path(tmp_path: Path) -> None:
    messages = [("/plan", PATH, 1.0 + i, path(1.0 + i, WAY)) for i in range(3)]
    np.testing.assert_allclose(only(bag(tmp_path / "b", messages)), WAY)


def test_arrays_of_poses_are_told_apart_too(tmp_path: Path) -> None:
    kind = "geometry_msgs/msg/PoseArray"
    messages = [
        ("/markers", kind, 1.0 + i, poses(1.0 + i, [(i, 0, 0), (i, 1, 0)])) for i in range(20)
    ]
    source = bag(tmp_path / "b", messages)
    with pytest.raises(InputError, match="20 paths on /markers"):
        read(source, "/markers")
    assert len(read(source, "/markers:all").data.demonstrations) == 20


def test_empty_paths_are_no_paths(tmp_path: Path) -> None:
    messages = [*replans((12,)), ("/plan", PATH, 9.0, path(9.0, []))]
    np.testing.assert_allclose(only(bag(tmp_path / "b", messages)), WAY)


def test_a_choice_where_there_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="one point each"):
        read(bag(tmp_path / "b", drive()), "/pose:all")


def test_paths_in_two_frames_are_refused(tmp_path: Path) -> None:
    messages = [("/plan", PATH, 1.0, path(1.0, WAY[:3], "map")),
                ("/plan", PATH, 2.0, path(2.0, WAY[:6], "odom"))]  # fmt: skip
    with pytest.raises(InputError, match="map, odom"):
        read(bag(tmp_path / "b", messages), "/plan:all")


def drive() -> list[Any]:
    return [("/pose", POSE, 1.0 + i, stamped(1.0 + i, p)) for i, p in enumerate(WAY)]


@pytest.mark.parametrize(
    "options",
    [
        {"repeat_channels": False},
        {"repeat_channels": False, "repeat_schemas": False},
        {"repeat_channels": False, "use_statistics": False, "use_summary_offsets": False},
        {"use_chunking": False},
        {"use_chunking": False, "repeat_channels": False, "repeat_schemas": False},
    ],
)
def test_mcap_files_without_what_is_optional(tmp_path: Path, options: dict[str, bool]) -> None:
    np.testing.assert_allclose(only(mcap_file(tmp_path / "a.mcap", drive(), **options)), WAY)


@pytest.mark.parametrize("bytes_left_out", [1, 8, 60, 400])
def test_an_mcap_file_that_is_cut_off_is_named_so(tmp_path: Path, bytes_left_out: int) -> None:
    whole = mcap_file(tmp_path / "a.mcap", drive()).read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[:-bytes_left_out])
    with pytest.raises(InputError, match=r"mcap recover.*cut off"):
        read(tmp_path / "cut.mcap")


@pytest.mark.parametrize(
    ("version", "mcap"), [(1, False), (4, False), (8, False), (10, False), (1, True), (57, True)]
)
def test_bags_with_metadata_of_any_version(tmp_path: Path, version: int, mcap: bool) -> None:
    import yaml

    source = bag(tmp_path / "b", drive(), mcap=mcap)
    file = source / "metadata.yaml"
    document = yaml.safe_load(file.read_text())
    inner = document["rosbag2_bagfile_information"]
    inner["version"] = version
    if version < 9:
        for topic in inner["topics_with_message_count"]:
            topic["topic_metadata"]["offered_qos_profiles"] = ""
    if version < 5:
        inner.pop("files", None)
    if version < 3:
        inner.pop("compression_format", None)
        inner.pop("compression_mode", None)
    if version > 9:  # what a later version may add
        inner["topics_with_message_count"] = {"count": 1}
    file.write_text(yaml.safe_dump(document))
    np.testing.assert_allclose(only(source), WAY)


def test_a_split_bag_of_an_unknown_version_is_one_recording(tmp_path: Path) -> None:
    import shutil

    first = bag(tmp_path / "first", drive()[:6])
    second = bag(tmp_path / "second", drive()[6:])
    (tmp_path / "b").mkdir()
    for i, part in enumerate((first, second)):
        (storage,) = part.glob("*.db3")
        shutil.copy(storage, tmp_path / "b" / f"b_{i}.db3")
    text = (first / "metadata.yaml").read_text()
    (tmp_path / "b" / "metadata.yaml").write_text(text.replace("version: 9", "version: 12"))
    np.testing.assert_allclose(only(tmp_path / "b"), WAY)


def test_senders_that_disagree_about_a_topic_are_refused(tmp_path: Path) -> None:
    from bags import store
    from mcap.writer import Writer

    types = store()
    with open(tmp_path / "a.mcap", "wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        for kind, message in ((POSE, stamped(1.0, WAY[0])), (PATH, path(2.0, WAY))):
            text, _ = types.generate_msgdef(kind, ros_version=2)
            schema = writer.register_schema(name=kind, encoding="ros2msg", data=text.encode())
            channel = writer.register_channel("/pose", "cdr", schema)
            data = bytes(types.serialize_cdr(message, kind))
            writer.add_message(channel, log_time=1, publish_time=1, data=data)
        writer.finish()
    with pytest.raises(InputError, match="messages of one type"):
        read(tmp_path / "a.mcap", "/pose")


def poses_in_frame(kinds: dict[str, Any], seconds: float, p: tuple[float, ...]) -> Any:
    made = kinds["PoseInFrame"](frame_id="table")
    made.timestamp.seconds, made.timestamp.nanos = int(seconds), round((seconds % 1) * 1e9)
    made.pose.position.x, made.pose.position.y, made.pose.position.z = p
    made.pose.orientation.w = 1.0
    return made


def test_foxglove_poses_in_protobuf(tmp_path: Path) -> None:
    pytest.importorskip("mcap_protobuf", reason="pip install 'demospec[ros]'")
    kinds = foxglove()
    messages = [
        ("/tool", 50.0 + i / 10, poses_in_frame(kinds, 20.0 + i / 10, p)) for i, p in enumerate(WAY)
    ]
    result = read(protobuf_file(tmp_path / "a.mcap", messages))
    item = result.data.demonstrations[0]
    np.testing.assert_allclose(item.points[:, :3], WAY)
    assert item.t is not None
    np.testing.assert_allclose(item.t, 0.1 * np.arange(12), atol=1e-6)
    assert result.reading is not None
    assert result.reading.frame.name == "table"


def test_foxglove_paths_in_protobuf_are_told_apart(tmp_path: Path) -> None:
    pytest.importorskip("mcap_protobuf", reason="pip install 'demospec[ros]'")
    kinds = foxglove()
    messages = []
    for i, n in enumerate((12, 6)):
        made = kinds["PosesInFrame"](frame_id="map")
        for x, y, z in WAY[-n:]:
            pose = made.poses.add()
            pose.position.x, pose.position.y, pose.position.z = x, y, z
            pose.orientation.w = 1.0
        messages.append(("/plan", 1.0 + i, made))
    with pytest.raises(InputError, match=r"2 paths on /plan \(12, 6 points\)"):
        read(protobuf_file(tmp_path / "a.mcap", messages))


def test_a_protobuf_pose_that_was_never_set_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("mcap_protobuf", reason="pip install 'demospec[ros]'")
    kinds = foxglove()
    message = kinds["PoseInFrame"](frame_id="table")
    with pytest.raises(InputError, match="a pose, point"):
        read(protobuf_file(tmp_path / "a.mcap", [("/tool", 1.0, message)]))


def test_foxglove_poses_in_json(tmp_path: Path) -> None:
    from mcap.writer import Writer

    with open(tmp_path / "a.mcap", "wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("foxglove.PoseInFrame", "jsonschema", b"{}")
        channel = writer.register_channel("/tool", "json", schema)
        for i, (x, y, z) in enumerate(WAY):
            document = {
                "timestamp": {"sec": 20, "nsec": 100_000_000 * i}, "frame_id": "table",
                "pose": {"position": {"x": x, "y": y, "z": z},
                         "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}},
            }  # fmt: skip
            writer.add_message(channel, i, json.dumps(document).encode(), i)
        writer.finish()
    item = read(tmp_path / "a.mcap").data.demonstrations[0]
    np.testing.assert_allclose(item.points[:, :3], WAY)
    assert item.t is not None
    np.testing.assert_allclose(item.t, 0.1 * np.arange(12), atol=1e-9)
