"""The story as arrays and messages, and changes of datasets, features and messages."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from story import NAMES, VALID, Source, story, write_lerobot

Write = Callable[[Path], Source]


def _points(k: int) -> np.ndarray:
    table = {c.means: c.values for c in story()[k]}
    return np.array([table["x"], table["y"], table["z"]]).T


def _times(k: int) -> np.ndarray:
    return np.array(next(c.values for c in story()[k] if c.means == "t"))


def hdf5_changes() -> Iterator[tuple[str, Write]]:
    """HDF5, changed: datasets and attributes of each demonstration."""

    def case(
        what: str, change: Callable[[dict[str, Any], dict[str, Any]], object]
    ) -> tuple[str, Write]:
        def write(folder: Path) -> Source:
            import h5py

            with h5py.File(folder / "a.hdf5", "w") as file:
                for k, name in enumerate(NAMES):
                    arrays = {"obs/eef_pos": _points(k), "obs/t": _times(k)}
                    said: dict[str, Any] = {
                        "success": VALID[k],
                        "user_type": ("careful", "normal")[k % 2],
                    }
                    change(arrays, said)
                    group = file.create_group(f"data/{name}")
                    for key, value in arrays.items():
                        group[key] = value
                    for key, value in said.items():
                        group.attrs[key] = value
            return Source(folder / "a.hdf5")

        return what, write

    def renamed(old: str, new: str) -> tuple[str, Write]:
        return case(f"{old} is called {new}", lambda a, s: a.update({new: a.pop(old)}))

    def mapped(what: str, how: Callable[[np.ndarray], Any]) -> tuple[str, Write]:
        return case(f"path {what}", lambda a, s: a.update({"obs/eef_pos": how(a["obs/eef_pos"])}))

    yield case("as it is", lambda a, s: None)
    for new in ("obs/foo", "obs/eef_vel", "obs/ee_pos", "eef_pos", "path", "obs/joint_pos", "t"):
        yield renamed("obs/eef_pos", new)
    for new in ("obs/time", "time", "obs/timestamp", "obs/foo", "obs/frame"):
        yield renamed("obs/t", new)
    for new in (
        "obs/ee_pos",
        "obs/robot0_eef_pos",
        "points",
        "obs/eef_vel",
        "actions",
        "obs/object",
    ):
        yield case(
            f"other numbers as {new}",
            lambda a, s, new=new: a.update({new: a["obs/eef_pos"] + 0.25}),
        )
    yield mapped("transposed", lambda p: p.T)
    yield mapped("as float32", lambda p: p.astype(np.float32))
    yield mapped("as integers", lambda p: np.full(p.shape, 2**31 - 1, dtype=np.int32))
    yield mapped("as text", lambda p: p.astype("S8"))
    yield mapped("as truth values in a list", lambda p: (p > 9)[:, 0])
    yield mapped("with an axis more", lambda p: p[:, :, None])
    yield mapped("flat", lambda p: p.ravel())
    yield mapped("with a column of time before", lambda p: np.column_stack([np.arange(len(p)), p]))
    yield mapped(
        "with quaternions after",
        lambda p: np.column_stack([p, np.tile([0, 0, 0, 1.0], (len(p), 1))]),
    )
    yield mapped("with no number", lambda p: np.where(np.arange(len(p))[:, None] == 2, np.nan, p))
    yield mapped("with infinity", lambda p: np.where(np.arange(len(p))[:, None] == 2, np.inf, p))
    yield mapped("empty", lambda p: p[:0])
    yield mapped("one column", lambda p: p[:, :1])
    for what, how in (
        ("int", int), ("float", float), ("text", str), ("list", lambda v: [v]),
        ("array", lambda v: np.array([int(v)])), ("word", lambda v: "success" if v else "failure"),
        ("two", lambda v: [v, v]),
    ):  # fmt: skip
        yield case(
            f"success as {what}", lambda a, s, how=how: s.update({"success": how(s["success"])})
        )
    for less in (0, 1, 2):

        def flags(a: dict[str, Any], s: dict[str, Any], less: int = less) -> None:
            flag = np.zeros(len(a["obs/eef_pos"]) - less, dtype=np.int64)
            flag[-1] = s.pop("success")
            a["success"] = flag

        yield case(f"success as flags, {less} less", flags)
    yield case("success renamed", lambda a, s: s.update({"verdict": s.pop("success")}))
    for what, factor in (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        yield case(f"time in {what}", lambda a, s, f=factor: a.update({"obs/t": a["obs/t"] * f}))
    yield case("time of another length", lambda a, s: a.update({"obs/t": a["obs/t"][:-2]}))
    yield case("time as text", lambda a, s: a.update({"obs/t": a["obs/t"].astype("S8")}))


def lerobot_changes() -> Iterator[tuple[str, Write]]:
    """LeRobot, changed: features and what describes them."""

    def case(what: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, Write]:
        def write(folder: Path) -> Source:
            source = write_lerobot(folder, story())
            file = folder / "meta" / "info.json"
            info = json.loads(file.read_text())
            change(info)
            file.write_text(json.dumps(info))
            return source

        return what, write

    state = "observation.state"

    def feature(what: str, **given: Any) -> tuple[str, Write]:
        return case(what, lambda i: i["features"][state].update(given))

    yield case("as it is", lambda i: None)
    yield feature("names of motors", names={"motors": ["x", "y", "z"]})
    yield feature("no names", names=None)
    yield feature("too few names", names=["x", "y"])
    yield feature("too many names", names=["x", "y", "z", "gripper"])
    yield feature("a name twice", names=["x", "x", "z"])
    yield feature("names of other things", names=["joint_1", "joint_2", "joint_3"])
    yield feature("velocities", names=["vx", "vy", "vz"])
    yield feature("names that are no text", names=[1, 2, 3])
    yield feature("another shape", shape=[4])
    yield feature("no shape", shape=None)
    yield feature("millimetres", names=["x (mm)", "y", "z"])
    yield case("state renamed", lambda i: i["features"].update({"state": i["features"].pop(state)}))
    yield case("no features", lambda i: i.pop("features"))
    yield case("features as a list", lambda i: i.update({"features": list(i["features"])}))
    yield case("fps as text", lambda i: i.update({"fps": "20"}))
    yield case("fps below 0", lambda i: i.update({"fps": -20}))
    yield case("another version", lambda i: i.update({"codebase_version": "v9.9"}))
    yield case("splits", lambda i: i.update({"splits": {"train": "0:2", "test": "2:3"}}))
    yield case("no data path", lambda i: i.pop("data_path"))
    yield case(
        "a data path outside", lambda i: i.update({"data_path": "../{chunk_index}{file_index}"})
    )


def mcap_changes() -> Iterator[tuple[str, Write]]:
    """MCAP with JSON messages of poses, changed."""

    def case(
        what: str,
        change: Callable[[dict[str, Any], int], object] = lambda m, i: None,
        *,
        topics: tuple[str, ...] = ("/tool",),
        kind: str = "geometry_msgs/msg/PoseStamped",
        **how: Any,
    ) -> tuple[str, Write]:
        def write(folder: Path) -> Source:
            from mcap.writer import Writer

            for k, name in enumerate(NAMES):
                with open(folder / f"{name}.mcap", "wb") as stream:
                    writer = Writer(stream)
                    writer.start(profile="", library="test")
                    schema = writer.register_schema(kind, "jsonschema", b"{}")
                    last = 0
                    for n, topic in enumerate(topics):
                        channel = writer.register_channel(topic, "json", schema)
                        for i, (p, t) in enumerate(
                            zip(_points(k).tolist(), _times(k), strict=True)
                        ):
                            last = int(1e9 * t) + 10**9
                            place = dict(zip("xyz", [v + 0.25 * n for v in p], strict=True))
                            message: dict[str, Any] = {
                                "header": {"frame_id": "table"},
                                "pose": {"position": place,
                                         "orientation": {"x": 0, "y": 0, "z": 0, "w": 0}},
                            }  # fmt: skip
                            change(message, i)
                            data = json.dumps(message).encode()
                            writer.add_message(channel, log_time=last, publish_time=last, data=data)
                    flag = writer.register_schema("std_msgs/msg/Bool", "jsonschema", b"{}")
                    channel = writer.register_channel("/success", "json", flag)
                    data = json.dumps({"data": VALID[k]}).encode()
                    writer.add_message(channel, log_time=last + 1, publish_time=last + 1, data=data)
                    writer.finish()
            return Source(folder, {"valid": "/success", **how})

        return what, write

    yield case("as it is")
    yield case("another topic with other numbers", topics=("/tool", "/left"))
    yield case("the same, one chosen", topics=("/tool", "/left"), path="/tool")
    yield case("two frames", lambda m, i: m["header"].update({"frame_id": f"f{i % 2}"}))
    yield case("a frame with a slash", lambda m, i: m["header"].update({"frame_id": "/table"}))
    yield case("no header", lambda m, i: m.pop("header"))

    def place(message: dict[str, Any]) -> dict[str, Any]:
        found: dict[str, Any] = message["pose"]["position"]
        return found

    for axis in "xyz":
        yield case(
            f"{axis} renamed", lambda m, i, a=axis: place(m).update({a + "_": place(m).pop(a)})
        )
        for value in (None, "1", True, [1], float("nan"), 1e400):
            yield case(
                f"{axis} once {value!r}",
                lambda m, i, a=axis, v=value: place(m).update({a: v} if i == 3 else {}),
            )
    yield case(
        "position as a list",
        lambda m, i: m["pose"].update({"position": list(m["pose"]["position"].values())}),
    )
    yield case("keys in another order", lambda m, i: m.update(
        {"pose": {"orientation": m["pose"]["orientation"],
                  "position": dict(reversed(m["pose"]["position"].items()))}}))  # fmt: skip
    yield case(
        "velocity beside", lambda m, i: m.update({"twist": {"linear": {"x": 9, "y": 9, "z": 9}}})
    )
    yield case("a message without a pose", lambda m, i: m.pop("pose") if i == 4 else None)
    for kind in (
        "geometry_msgs/msg/TwistStamped",
        "std_msgs/msg/String",
        "my_msgs/msg/Thing",
        "geometry_msgs/msg/PointStamped",
        "geometry_msgs/PoseStamped",
    ):
        yield case(f"type {kind}", kind=kind)
