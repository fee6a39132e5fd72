"""Files of other formats, written by other libraries: h5py, rosbags, mcap, pyarrow, PyAV."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np


def arc(n: int = 25, bulge: float = 0.0) -> np.ndarray:
    """(n, 3): a path in metres from (0.1, 0.1, 0.2) to (0.7, 0.5, 0.2)."""
    s = np.linspace(0, 1, n)
    x = 0.1 + 0.6 * s
    y = 0.1 + 0.4 * s + bulge * np.sin(np.pi * s)
    return np.stack([x, y, np.full(n, 0.2)], axis=1)


def picture(seed: int = 0, height: int = 48, width: int = 64) -> np.ndarray:
    """(h, w, 3) uint8, blocks of colour (so that video compression keeps them)."""
    rng = np.random.default_rng(seed)
    blocks = rng.integers(0, 255, (height // 16, width // 16, 3), dtype=np.uint8)
    return np.repeat(np.repeat(blocks, 16, axis=0), 16, axis=1)


def png(pixels: np.ndarray) -> bytes:
    """PNG bytes, by Pillow."""
    import PIL.Image

    data = io.BytesIO()
    PIL.Image.fromarray(pixels).save(data, format="PNG")
    return data.getvalue()


def write_robomimic(path: Path, demos: int = 4) -> list[np.ndarray]:
    """robomimic's documented structure: data/demo_i/obs/…, attributes, mask/…; by h5py."""
    import h5py

    paths = []
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["env_args"] = json.dumps({"env_name": "Lift", "type": 1, "env_kwargs": {}})
        total = 0
        for i in range(demos):
            points = arc(20 + i, bulge=0.02 * i)
            paths.append(points)
            group = data.create_group(f"demo_{i}")
            group.attrs["num_samples"] = len(points)
            group.attrs["model_file"] = "<mujoco/>"
            group.attrs["success"] = i % 2 == 0
            group.create_dataset("actions", data=np.zeros((len(points), 7)))
            group.create_dataset("states", data=np.zeros((len(points), 32)))
            rewards = np.zeros(len(points))
            rewards[-1] = i % 2 == 0
            group.create_dataset("rewards", data=rewards)
            group.create_dataset("dones", data=rewards.astype(np.int64))
            obs = group.create_group("obs")
            obs.create_dataset("robot0_eef_pos", data=points)
            obs.create_dataset("robot0_eef_quat", data=np.zeros((len(points), 4)))
            frames = np.stack([picture(i)] * len(points))
            obs.create_dataset("agentview_image", data=frames, compression="gzip")
            total += len(points)
        data.attrs["total"] = total
        mask = file.create_group("mask")
        mask.create_dataset("train", data=np.array([b"demo_0", b"demo_1", b"demo_2"]))
        mask.create_dataset("valid", data=np.array([b"demo_3"]))
    return paths


def write_lerobot(root: Path, episodes: int = 3, camera: str | None = "image") -> list[np.ndarray]:
    """The documented layout of LeRobotDataset v3.0, by pyarrow (and PyAV for a video)."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    fps = 10
    features: dict[str, Any] = {
        "observation.state": {
            "dtype": "float32", "shape": [4], "names": {"motors": ["x", "y", "z", "gripper"]},
        },
        "action": {"dtype": "float32", "shape": [2], "names": None},
        "next.success": {"dtype": "bool", "shape": [1], "names": None},
    }  # fmt: skip
    whole = ("frame_index", "episode_index", "index", "task_index")
    for name, kind in (("timestamp", "float32"), *((n, "int64") for n in whole)):
        features[name] = {"dtype": kind, "shape": [1], "names": None}
    key = "observation.images.top"
    if camera is not None:
        features[key] = {"dtype": camera, "shape": [48, 64, 3],
                         "names": ["height", "width", "channels"]}  # fmt: skip
    rows: dict[str, list[Any]] = {name: [] for name in features}
    meta: list[dict[str, Any]] = []
    paths, frames = [], []
    for e in range(episodes):
        points = arc(10 + e, bulge=0.03 * e)
        paths.append(points)
        begin = len(rows["index"])
        for f, point in enumerate(points):
            rows["observation.state"].append([*point.tolist(), 0.0])
            rows["action"].append([0.0, 0.0])
            rows["next.success"].append(e != 1 and f == len(points) - 1)
            rows["timestamp"].append(f / fps)
            rows["frame_index"].append(f)
            rows["episode_index"].append(e)
            rows["index"].append(len(rows["index"]))
            rows["task_index"].append(0)
            frames.append(picture(e))
            if camera == "image":
                rows[key].append({"bytes": png(picture(e)), "path": f"frame-{f:06d}.png"})
        entry: dict[str, Any] = {
            "episode_index": e, "tasks": ["reach the glass"], "length": len(points),
            "data/chunk_index": 0, "data/file_index": 0, "dataset_from_index": begin,
            "dataset_to_index": begin + len(points), "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0, "stats/action/min": [0.0, 0.0],
        }  # fmt: skip
        if camera == "video":
            entry |= {f"videos/{key}/chunk_index": 0, f"videos/{key}/file_index": 0,
                      f"videos/{key}/from_timestamp": begin / fps,
                      f"videos/{key}/to_timestamp": (begin + len(points)) / fps}  # fmt: skip
        meta.append(entry)
    columns: dict[str, Any] = {}
    for name, values in rows.items():
        if name in ("observation.state", "action"):
            columns[name] = pa.array(values, pa.list_(pa.float32(), len(values[0])))
        elif name == "timestamp":
            columns[name] = pa.array(values, pa.float32())
        elif features[name]["dtype"] != "video":
            columns[name] = pa.array(values)
    for folder in ("data/chunk-000", "meta/episodes/chunk-000"):
        (root / folder).mkdir(parents=True)
    pq.write_table(pa.table(columns), root / "data/chunk-000/file-000.parquet")
    pq.write_table(pa.Table.from_pylist(meta), root / "meta/episodes/chunk-000/file-000.parquet")
    pq.write_table(
        pa.table({"task_index": [0], "__index_level_0__": ["reach the glass"]}),
        root / "meta/tasks.parquet",
    )
    info = {
        "codebase_version": "v3.0", "robot_type": "so100", "total_episodes": episodes,
        "total_frames": len(frames), "total_tasks": 1, "chunks_size": 1000,
        "data_files_size_in_mb": 100, "video_files_size_in_mb": 200, "fps": fps,
        "splits": {"train": f"0:{episodes - 1}", "test": f"{episodes - 1}:{episodes}"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
        if camera == "video"
        else None,
        "features": features,
    }  # fmt: skip
    (root / "meta/info.json").write_text(json.dumps(info, indent=4))
    if camera == "video":
        write_video(root / f"videos/{key}/chunk-000/file-000.mp4", frames, fps)
    return paths


def write_video(file: Path, frames: list[np.ndarray], fps: int) -> None:
    """An H.264 (or MPEG-4) video, by PyAV."""
    import av

    file.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(file), "w") as container:
        stream = container.add_stream("libx264" if "libx264" in av.codecs_available else "mpeg4",
                                      rate=fps)  # fmt: skip
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        for pixels in frames:
            for packet in stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)


def _store() -> Any:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_HUMBLE)


def _messages(store: Any, points: np.ndarray, verdict: bool) -> list[tuple[str, str, int, Any]]:
    """(topic, type, nanoseconds, message) of one recording."""
    t = store.types
    out: list[tuple[str, str, int, Any]] = []

    def header(nanoseconds: int) -> Any:
        stamp = t["builtin_interfaces/msg/Time"](
            sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9
        )
        return t["std_msgs/msg/Header"](stamp=stamp, frame_id="table")

    start = 1_700_000_000 * 10**9
    pixels = picture(3)
    image = t["sensor_msgs/msg/Image"](
        header=header(start), height=48, width=64, encoding="bgr8", is_bigendian=0, step=64 * 3,
        data=np.ascontiguousarray(pixels[:, :, ::-1]).reshape(-1),
    )  # fmt: skip
    out.append(("/camera", "sensor_msgs/msg/Image", start, image))
    for i, (x, y, z) in enumerate(points):
        now = start + i * 100_000_000
        pose = t["geometry_msgs/msg/Pose"](
            position=t["geometry_msgs/msg/Point"](x=float(x), y=float(y), z=float(z)),
            orientation=t["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
        )
        stamped = t["geometry_msgs/msg/PoseStamped"](header=header(now), pose=pose)
        out.append(("/tool_pose", "geometry_msgs/msg/PoseStamped", now, stamped))
        joints = t["sensor_msgs/msg/JointState"](
            header=header(now), name=["gantry_x", "gantry_y", "lift"],
            position=np.array([x, y, z]), velocity=np.zeros(0), effort=np.zeros(0),
        )  # fmt: skip
        out.append(("/joint_states", "sensor_msgs/msg/JointState", now, joints))
    end = start + len(points) * 100_000_000
    out.append(("/success", "std_msgs/msg/Bool", end, t["std_msgs/msg/Bool"](data=verdict)))
    word = t["std_msgs/msg/String"](data="careful")
    out.append(("/user", "std_msgs/msg/String", end, word))
    return out


def write_bag(folder: Path, points: np.ndarray, verdict: bool, *, mcap: bool = False) -> None:
    """A ROS 2 bag (SQLite or MCAP storage), by rosbags."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = _store()
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, now, message in _messages(store, points, verdict):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], now, store.serialize_cdr(message, kind))


def write_mcap(file: Path, points: np.ndarray, verdict: bool) -> None:
    """A bare MCAP file with ROS 2 messages, by mcap's own writer."""
    from mcap.writer import Writer

    store = _store()
    with open(file, "wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        channels: dict[str, int] = {}
        for topic, kind, now, message in _messages(store, points, verdict):
            if topic not in channels:
                text, _ = store.generate_msgdef(kind, ros_version=2)
                schema = writer.register_schema(name=kind, encoding="ros2msg", data=text.encode())
                channels[topic] = writer.register_channel(
                    topic=topic, message_encoding="cdr", schema_id=schema
                )
            data = bytes(store.serialize_cdr(message, kind))
            writer.add_message(channels[topic], log_time=now, publish_time=now, data=data)
        writer.finish()


def write_ros1(file: Path, points: np.ndarray) -> None:
    """A ROS 1 bag with one pose topic, by rosbags."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    t = store.types
    kind = "geometry_msgs/msg/PoseStamped"
    with Writer(file) as writer:
        connection = writer.add_connection("/tool_pose", kind, typestore=store)
        for i, (x, y, z) in enumerate(points.tolist()):
            header = t["std_msgs/msg/Header"](
                seq=i, stamp=t["builtin_interfaces/msg/Time"](sec=100 + i, nanosec=0), frame_id="t"
            )
            pose = t["geometry_msgs/msg/Pose"](
                position=t["geometry_msgs/msg/Point"](x=x, y=y, z=z),
                orientation=t["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
            )
            data = store.serialize_ros1(t[kind](header=header, pose=pose), kind)
            writer.write(connection, (100 + i) * 10**9, data)
