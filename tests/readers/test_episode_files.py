"""HDF5 with an episode a file, and LeRobot's layouts: what belongs together, and which camera."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foreign_files import arc, picture, png, write_lerobot, write_robomimic, write_video

from demospec.demonstrations.readers import Mapping, guess_format, read_source
from demospec.errors import InputError


def read(source: Path, **how: Any) -> Any:
    return read_source(source, mapping=Mapping.model_validate(how))


# HDF5


def aloha(
    file: Path, n: int = 12, *, bulge: float = 0.0, jpeg: bool = False, **attributes: Any
) -> np.ndarray:
    """An episode as ALOHA records it, with the tool's place beside the joints."""
    import h5py
    import PIL.Image

    points = arc(n, bulge)
    file.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(file, "w") as made:
        made.attrs["sim"] = True
        made.attrs.update(attributes)
        observations = made.create_group("observations")
        observations["qpos"] = np.zeros((n, 14))
        observations["qvel"] = np.zeros((n, 14))
        observations["ee_pos"] = points
        made["action"] = np.zeros((n, 14))
        images = observations.create_group("images")
        for k, camera in enumerate(("top", "wrist")):
            frame = picture(k)
            if jpeg:
                import io

                data = io.BytesIO()
                PIL.Image.fromarray(frame).save(data, format="JPEG", quality=95)
                packed = np.frombuffer(data.getvalue(), np.uint8)
                padded = np.pad(packed, (0, 7))
                images[camera] = np.stack([padded] * n)
            else:
                images[camera] = np.stack([frame] * n)
    return points


def test_a_folder_of_episodes_is_one_demonstration_a_file(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    ways = [aloha(tmp_path / f"episode_{i}.hdf5", 10 + i, bulge=0.05 * i, success=i != 1)
            for i in range(3)]  # fmt: skip
    assert guess_format(tmp_path) == "hdf5"
    data = read(tmp_path).data
    assert [d.demo_id for d in data.demonstrations] == ["episode_0", "episode_1", "episode_2"]
    assert [d.valid for d in data.demonstrations] == [True, False, True]
    for item, way in zip(data.demonstrations, ways, strict=True):
        np.testing.assert_allclose(item.points, way)


def test_an_episode_alone_is_named_after_its_file(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    way = aloha(tmp_path / "episode_7.hdf5")
    (item,) = read(tmp_path / "episode_7.hdf5").data.demonstrations
    assert item.demo_id == "episode_7"
    np.testing.assert_allclose(item.points, way)
    (item,) = read(tmp_path / "episode_7.hdf5", path="observations/ee_pos").data.demonstrations
    assert item.demo_id == "episode_7"


def test_folders_and_files_of_one_name_stay_apart(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    aloha(tmp_path / "success" / "episode_0.hdf5")
    aloha(tmp_path / "failure" / "episode_0.hdf5", bulge=0.1)
    data = read(tmp_path).data
    found = {d.demo_id: d.valid for d in data.demonstrations}
    assert found == {"failure/episode_0": False, "success/episode_0": True}


def test_files_with_several_demonstrations_in_a_folder(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    for name in ("a", "b"):
        write_robomimic(tmp_path / f"{name}.hdf5", demos=2)
    names = [d.demo_id for d in read(tmp_path).data.demonstrations]
    assert names == ["a-demo_0", "a-demo_1", "b-demo_0", "b-demo_1"]


def test_files_of_a_folder_are_chosen_by_pattern(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    for i in range(3):
        aloha(tmp_path / f"episode_{i}.hdf5")
    assert len(read(tmp_path, exclude=["*_1.hdf5"]).data.demonstrations) == 2
    with pytest.raises(InputError, match="files that the patterns leave"):
        read(tmp_path, include=["nothing*"])


@pytest.mark.parametrize("jpeg", [False, True])
@pytest.mark.parametrize("name", ["observations/images/wrist", "wrist"])
def test_a_camera_is_chosen_by_its_name(tmp_path: Path, jpeg: bool, name: str) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    aloha(tmp_path / "episode_0.hdf5", jpeg=jpeg)
    data = read(tmp_path, picture=name, metres_per_unit=0.01).data
    gap = np.abs(data.scenes[0].pixels().astype(int) - picture(1).astype(int)).mean()
    assert gap < (8 if jpeg else 1e-9)
    with pytest.raises(InputError, match=r"observations/images/top, observations/images/wrist"):
        read(tmp_path, picture="side", metres_per_unit=0.01)


def test_a_damaged_file_of_a_folder_is_named(tmp_path: Path) -> None:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    aloha(tmp_path / "episode_0.hdf5")
    (tmp_path / "episode_1.hdf5").write_bytes((tmp_path / "episode_0.hdf5").read_bytes()[:700])
    with pytest.raises(InputError, match=r"episode_1\.hdf5"):
        read(tmp_path)


def test_the_orientation_of_robosuite_comes_with_its_place(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    write_robomimic(tmp_path / "a.hdf5", demos=1)
    with h5py.File(tmp_path / "a.hdf5", "a") as file:
        file["data/demo_0/obs/robot0_eef_quat"][...] = [0.6, 0, 0, 0.8]
    data = read(tmp_path / "a.hdf5").data
    assert data.columns == ("x", "y", "z", "qx", "qy", "qz", "qw")
    np.testing.assert_allclose(data.demonstrations[0].points[:, 3:], [[0.6, 0, 0, 0.8]] * 20)


# LeRobot


def version_2(root: Path, episodes: int = 3, *, camera: str | None = None) -> list[np.ndarray]:
    """The documented layout of LeRobotDataset v2.1: a file (and a video) an episode."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    features: dict[str, Any] = {
        "observation.state": {"dtype": "float32", "shape": [3], "names": {"axes": ["x", "y", "z"]}},
        "next.success": {"dtype": "bool", "shape": [1], "names": None},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
        "episode_index": {"dtype": "int64", "shape": [1], "names": None},
    }
    cameras = ["observation.images.top", "observation.images.wrist"] if camera else []
    for key in cameras:
        features[key] = {"dtype": camera, "shape": [48, 64, 3], "names": None}
    ways, lines = [], []
    for e in range(episodes):
        way = arc(8 + e, 0.05 * e)
        ways.append(way)
        columns: dict[str, Any] = {
            "observation.state": pa.array(way.tolist(), pa.list_(pa.float32(), 3)),
            "next.success": [e != 1 and i == len(way) - 1 for i in range(len(way))],
            "timestamp": pa.array(np.arange(len(way)) / 10, pa.float32()),
            "episode_index": [e] * len(way),
        }
        for k, key in enumerate(cameras):
            frames = [picture(10 * k + e)] * len(way)
            if camera == "image":
                columns[key] = [{"bytes": png(f), "path": ""} for f in frames]
            else:
                name = f"videos/chunk-{e // 2:03d}/{key}/episode_{e:06d}.mp4"
                write_video(root / name, frames, 10)
        folder = root / f"data/chunk-{e // 2:03d}"
        folder.mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.table(columns), folder / f"episode_{e:06d}.parquet")
        lines.append(json.dumps({"episode_index": e, "tasks": ["reach"], "length": len(way)}))
    (root / "meta").mkdir()
    (root / "meta/episodes.jsonl").write_text("\n".join(lines) + "\n")
    info = {
        "codebase_version": "v2.1", "fps": 10, "total_episodes": episodes, "chunks_size": 2,
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": "videos/chunk-{episode_chunk:03d}/{video_key}/"
        "episode_{episode_index:06d}.mp4",
        "splits": {"train": "0:2", "test": "2:3"}, "features": features,
    }  # fmt: skip
    (root / "meta/info.json").write_text(json.dumps(info))
    return ways


@pytest.mark.parametrize("version", ["v2.0", "v2.1"])
def test_a_file_an_episode(tmp_path: Path, version: str) -> None:
    ways = version_2(tmp_path / "set")
    file = tmp_path / "set/meta/info.json"
    file.write_text(file.read_text().replace("v2.1", version))
    assert guess_format(tmp_path / "set") == "lerobot"
    data = read(tmp_path / "set").data
    assert [d.demo_id for d in data.demonstrations] == [f"episode-{i}" for i in range(3)]
    assert [d.valid for d in data.demonstrations] == [True, False, True]
    for item, way in zip(data.demonstrations, ways, strict=True):
        np.testing.assert_allclose(item.points, way, atol=1e-6)


def test_pictures_of_a_file_an_episode(tmp_path: Path) -> None:
    version_2(tmp_path / "set", camera="image")
    data = read(tmp_path / "set", picture="wrist", metres_per_unit=0.01).data
    assert [s.split for s in data.scenes] == ["train", "train", "test"]
    for e, scene in enumerate(data.scenes):
        assert np.array_equal(scene.pixels(), picture(10 + e))
    with pytest.raises(InputError, match=r"observation\.images\.top, observation\.images\.wrist"):
        read(tmp_path / "set", picture="side", metres_per_unit=0.01)


def test_videos_of_a_file_an_episode(tmp_path: Path) -> None:
    pytest.importorskip("av", reason="pip install 'demospec[video]'")
    version_2(tmp_path / "set", camera="video")
    data = read(tmp_path / "set", picture="observation.images.top", metres_per_unit=0.01).data
    for e, scene in enumerate(data.scenes):
        gaps = [np.abs(scene.pixels().astype(int) - picture(k).astype(int)).mean()
                for k in range(3)]  # fmt: skip
        assert int(np.argmin(gaps)) == e


def test_two_cameras_of_one_short_name_need_the_whole(tmp_path: Path) -> None:
    version_2(tmp_path / "set", camera="image")
    file = tmp_path / "set/meta/info.json"
    file.write_text(file.read_text().replace('"observation.images.wrist"', '"left.top"'))
    with pytest.raises(InputError, match="one camera; say its whole name"):
        read(tmp_path / "set", picture="top", metres_per_unit=0.01)


def with_language(root: Path) -> list[np.ndarray]:
    """A v3.1 dataset: columns of language beside the numbers."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    ways = write_lerobot(root)
    file = root / "meta/info.json"
    info = json.loads(file.read_text())
    info["codebase_version"] = "v3.1"
    names = ("language_persistent", "language_events")
    for name in names:
        info["features"][name] = {"dtype": "language", "shape": [1], "names": None}
    file.write_text(json.dumps(info))
    table = root / "data/chunk-000/file-000.parquet"
    rows = pq.read_table(table)
    said = [[{"role": "user", "content": "reach", "timestamp": 0.0}]] * len(rows)
    for name in names:
        rows = rows.append_column(name, pa.array(said))
    pq.write_table(rows, table)
    return ways


def test_columns_of_language_are_not_read(tmp_path: Path) -> None:
    ways = with_language(tmp_path / "set")
    data = read(tmp_path / "set").data
    for item, way in zip(data.demonstrations, ways, strict=True):
        np.testing.assert_allclose(item.points[:, :3], way, atol=1e-6)
    with pytest.raises(InputError, match="numbers"):
        read(tmp_path / "set", path="language_events")


@pytest.mark.parametrize("version", ["v1.6", "v4.0", "2.1", None])
def test_other_versions_are_refused(tmp_path: Path, version: str | None) -> None:
    version_2(tmp_path / "set")
    file = tmp_path / "set/meta/info.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "codebase_version": version}))
    with pytest.raises(InputError, match=r"v2\.x or v3\.x"):
        read(tmp_path / "set")


@pytest.mark.parametrize(
    ("file", "text", "match"),
    [
        ("meta/episodes.jsonl", "", "at least one episode"),
        ("meta/episodes.jsonl", '{"episode_index": "a"}', "a whole number"),
        ("meta/episodes.jsonl", '{"episode_index": 0, "length": 3}', "3 frames"),
        ("meta/episodes.jsonl", '{"episode_index": 9}', "episode_000009"),
    ],
)
def test_broken_metadata_is_named(tmp_path: Path, file: str, text: str, match: str) -> None:
    version_2(tmp_path / "set")
    (tmp_path / "set" / file).write_text(text)
    with pytest.raises(InputError, match=match):
        read(tmp_path / "set")
