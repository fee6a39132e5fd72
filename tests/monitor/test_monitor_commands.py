"""`demospec monitor` and `demospec check-run`: streams, recordings, files, faults."""

from __future__ import annotations

import io
import json
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import read_set, simulate_set, write_set
from demospec.frames import FloatArray
from demospec.monitor import Monitor, MonitorSettings, RobotFrame, readings_of_lines
from demospec.planning import check_plan
from demospec.rules import read_rules


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("monitor")
    data, truth = simulate_set(train_scenes=2, test_scenes=1, demonstrations=4, seed=5)
    write_set(data, made / "set", documents={"truth.json": truth})
    return made


def run(capsys: pytest.CaptureFixture[str], *arguments: object, status: int = 0) -> tuple[str, str]:
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    said = capsys.readouterr()
    assert stop.value.code == status, said.err
    return said.out, said.err


def lines_of(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def rules_and_set(folder: Path) -> tuple[Path, Path]:
    return folder / "set" / "truth.json", folder / "set"


def bag_of(
    file: Path, metres: FloatArray, t: FloatArray, plan: FloatArray | None = None,
    objects: list[FloatArray] | None = None,
) -> None:  # fmt: skip
    """An MCAP file of PoseStamped, with a Path and a PoseArray beside it, by `mcap`."""
    pytest.importorskip("mcap", reason="pip install 'demospec[ros]'")
    from mcap.writer import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    made = store.types

    def stamp(s: float) -> Any:
        return made["builtin_interfaces/msg/Time"](sec=int(s), nanosec=round(s % 1 * 1e9))

    def header(s: float) -> Any:
        return made["std_msgs/msg/Header"](stamp=stamp(s), frame_id="map")

    def pose(x: float, y: float) -> Any:
        return made["geometry_msgs/msg/Pose"](
            position=made["geometry_msgs/msg/Point"](x=float(x), y=float(y), z=0.1),
            orientation=made["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
        )

    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")

        def channel(topic: str, kind: str) -> Any:
            text, _ = store.generate_msgdef(kind, ros_version=2)
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            number = writer.register_channel(topic, "cdr", schema)

            def add(s: float, message: Any) -> None:
                data = bytes(store.serialize_cdr(message, kind))
                n = round(s * 1e9)
                writer.add_message(number, log_time=n, data=data, publish_time=n)

            return add

        stamped = made["geometry_msgs/msg/PoseStamped"]
        add = channel("/tool", "geometry_msgs/msg/PoseStamped")
        if plan is not None:
            poses = [stamped(header=header(t[0]), pose=pose(*p)) for p in plan]
            message = made["nav_msgs/msg/Path"](header=header(t[0]), poses=poses)
            channel("/plan", "nav_msgs/msg/Path")(t[0], message)
        if objects is not None:
            tell = channel("/things", "geometry_msgs/msg/PoseArray")
            array = made["geometry_msgs/msg/PoseArray"]
            for s, centers in zip(t, objects, strict=True):
                tell(s, array(header=header(s), poses=[pose(*c) for c in centers]))
        for s, point in zip(t, metres, strict=True):
            add(s, stamped(header=header(s), pose=pose(*point)))
        writer.finish()  # type: ignore[no-untyped-call]


def test_a_replayed_set_breaks_the_rule_where_its_labels_say(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules, data_folder = rules_and_set(folder)
    data = read_set(data_folder)
    scene = data.scenes[0].scene_id
    out, _ = run(capsys, "monitor", rules, data_folder, "--scene", scene, "--type", "careful",
                 "--replay", data_folder)  # fmt: skip
    readings = lines_of(out)
    rows = data.demonstrations
    here = [i for i in range(len(rows)) if rows.scene_id[i] == scene and rows.type[i] == "careful"]
    assert here
    for i in here:
        mine = [r for r in readings if r["run"] == rows.demo_id[i]]
        assert len(mine) == len(rows.points(i))
        assert any(r["verdict"] == "violation" for r in mine) == (rows.valid[i] == 0)
    keys = {"t", "verdict", "margin", "constraint", "object", "time_to_violation_s"}
    assert all(keys <= r.keys() for r in readings)


def test_json_lines_in_set_units_and_in_metres(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rules, data_folder = rules_and_set(folder)
    data = read_set(data_folder)
    scene = data.scenes[0]
    frame = RobotFrame.of(data, scene)
    glass = next(o for o in scene.listed_objects() if o.symbol == "glass")
    path = np.linspace([5.0, 5.0], glass.center, 50)
    metres = frame.to_metres(path)
    assert np.abs(frame.to_units(metres) - path).max() < 1e-9
    told = []
    for points, options in ((path, ()), (metres, ("--metres",))):
        text = "".join(
            json.dumps({"t": 0.05 * i, "x": x, "y": y}) + "\n"
            for i, (x, y) in enumerate(points.tolist())
        )
        text += "not JSON\n[1]\n" + json.dumps({"t": 2.6, "x": None, "y": 1.0}) + "\n\n"
        monkeypatch.setattr("sys.stdin", io.StringIO(text))
        out, _ = run(capsys, "monitor", rules, data_folder, "--scene", scene.scene_id, "--type",
                     "careful", *options)  # fmt: skip
        told.append(lines_of(out))
    for a, b in zip(*told, strict=True):
        assert a["verdict"] == b["verdict"]
        assert (a["margin"] is None) == (b["margin"] is None)
        assert a["margin"] is None or a["margin"] == pytest.approx(b["margin"], abs=1e-6)
    assert told[0][49]["verdict"] == "violation"
    assert [r["verdict"] for r in told[0][50:]] == ["unknown"] * 3
    assert all(r["why"] for r in told[0][50:])


def test_lines_that_move_objects(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rules, data_folder = rules_and_set(folder)
    scene = read_set(data_folder).scenes[0]
    x, y = 50.0, 50.0
    lines: list[dict[str, Any]] = [
        *({"object": o.id, "removed": True} for o in scene.listed_objects()),
        {"t": 0.0, "point": [x, y]},
        {"object": "new", "symbol": "glass", "center": [x + 2.0, y]},
        {"t": 0.01, "point": [x, y]},
        {"object": "new", "center": [x + 30.0, y], "heading_deg": 90.0},
        {"t": 0.02, "point": [x, y]},
        {"object": "new", "center": "there"},
        {"object": "absent", "removed": True},
    ]
    text = "".join(json.dumps(line) + "\n" for line in lines)
    monkeypatch.setattr("sys.stdin", io.StringIO(text))
    out, _ = run(capsys, "monitor", rules, data_folder, "--scene", scene.scene_id, "--type",
                 "careful", "--stdin")  # fmt: skip
    verdicts = [r["verdict"] for r in lines_of(out)]
    assert verdicts == ["ok", "violation", "warn", "unknown", "unknown"]  # the warning stands


def test_a_scene_of_its_own_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rule = {"types": {"me": {"clearance": {"value": {"cup": 0.04}}}}, "units": "m"}
    table = {"objects": [{"id": "cup", "symbol": "cup", "center": [0.5, 0.5], "radius": 0.05}]}
    (tmp_path / "rule.json").write_text(json.dumps(rule))
    (tmp_path / "table.json").write_text(json.dumps(table))
    monkeypatch.setattr("sys.stdin", io.StringIO('{"t": 0, "x": 0.4, "y": 0.5}\n'))
    out, _ = run(capsys, "monitor", tmp_path / "rule.json", "--scene", tmp_path / "table.json",
                 "--metres")  # fmt: skip
    (reading,) = lines_of(out)
    assert reading["verdict"] == "ok"
    assert reading["margin"] == pytest.approx(0.01)
    assert reading["unit"] == "m"


def test_a_silent_pipe_is_said_while_it_is_silent(folder: Path) -> None:
    rules, data_folder = rules_and_set(folder)
    data = read_set(data_folder)
    monitor = Monitor(read_rules(rules), data.scenes[0], "careful",
                      settings=MonitorSettings(stale_s=0.05))  # fmt: skip

    class Pipe:
        """One line, silence until the consumer has heard of it, another line."""

        heard = threading.Event()

        def __iter__(self) -> Any:
            yield '{"t": 7.0, "x": 5, "y": 5}\n'
            assert self.heard.wait(20)
            yield '{"t": 7.01, "x": 5, "y": 5}\n'

    verdicts = []
    pipe = Pipe()
    for reading in readings_of_lines(monitor, pipe):  # type: ignore[arg-type]
        verdicts.append(reading.verdict)
        if reading.verdict == "unknown":
            assert reading.t > 7.05
            pipe.heard.set()
    assert verdicts[0] == "ok"
    assert "unknown" in verdicts
    assert verdicts[-1] == "ok"


def test_a_bag_with_moving_objects_and_what_is_written(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mcap_ros2", reason="pip install mcap-ros2-support")
    rules, data_folder = rules_and_set(folder)
    data = read_set(data_folder)
    scene = data.scenes[0]
    frame = RobotFrame.of(data, scene)
    t = 1000.0 + 0.02 * np.arange(60)
    t[40:] += 2.0  # the sensor is silent for two seconds
    still = np.repeat(frame.to_metres([[5.0, 5.0]]), 60, axis=0)
    centers = np.array([o.center for o in scene.listed_objects()])
    things = []
    for i in range(60):  # the first object slides to the robot
        moved = centers.copy()
        moved[0] = centers[0] + min(1.0, i / 30) * (np.array([5.0, 5.0]) - centers[0])
        things.append(frame.to_metres(moved))
    bag_of(tmp_path / "run.mcap", still, t, objects=things)
    out, _ = run(capsys, "monitor", rules, data_folder, "--scene", scene.scene_id, "--type",
                 "careful", "--replay", tmp_path / "run.mcap", "--objects", "/things", "--topic",
                 "/tool", "--out", tmp_path / "out.mcap")  # fmt: skip
    readings = lines_of(out)
    verdicts = [r["verdict"] for r in readings]
    assert verdicts[0] == "ok"
    assert verdicts[35] == "violation"
    assert readings[35]["object"] == scene.listed_objects()[0].id
    assert "warn" in verdicts[:30]
    (silent,) = [r for r in readings if "no sample for" in r.get("why", "") and r["margin"] is None]
    assert silent["t"] == pytest.approx(t[39] + 0.3, abs=1e-4)
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    levels: list[int] = []
    shown = 0
    with open(tmp_path / "out.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        topics = ["/demospec/diagnostics", "/demospec/markers"]
        for _, channel, _, message in reader.iter_decoded_messages(topics=topics):
            if channel.topic == topics[0]:
                levels.append(message.status[0].level)
                continue
            shown += 1
            assert len(message.markers) == len(scene.listed_objects())
            assert message.markers[0].header.frame_id == "map"
    numbers = {"ok": 0, "warn": 1, "violation": 2, "unknown": 3}
    assert levels == [numbers[v] for v in verdicts]
    assert 3 <= shown < len(verdicts)
    _, error = run(capsys, "monitor", rules, data_folder, "--scene", scene.scene_id, "--type",
                   "careful", "--replay", data_folder, "--out", tmp_path / "out.mcap",
                   status=2)  # fmt: skip
    assert len(error.strip().splitlines()) == 1


def test_check_run_says_where_when_and_by_how_much(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules, data_folder = rules_and_set(folder)
    data = read_set(data_folder)
    scene = data.scenes[0]
    frame = RobotFrame.of(data, scene)
    glass = next(o for o in scene.listed_objects() if o.symbol == "glass")
    out, _ = run(capsys, "plan", rules, data_folder, "--scene", scene.scene_id, "--type",
                 "careful", "--json", "--out", tmp_path / "plan.json")  # fmt: skip
    plan = np.array(json.loads(out)["points"])
    steps = np.hypot(*np.diff(plan, axis=0).T)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    t = 0.02 * np.arange(300)
    at = np.linspace(0.0, s[-1], 300)
    good = np.stack([np.interp(at, s, plan[:, k]) for k in (0, 1)], axis=1)
    bag_of(tmp_path / "good.mcap", frame.to_metres(good), t, plan=frame.to_metres(plan))
    common = ("check-run", rules, data_folder, "--scene", scene.scene_id, "--type", "careful")
    out, _ = run(capsys, *common, "--run", tmp_path / "good.mcap", "--json")
    document = json.loads(out)
    assert (document["keeps_rule"], document["follows_plan"]) == (True, True)
    assert document["violations"] == []
    assert document["samples"] == 300
    bad = good.copy()
    bad[140:160] = glass.center  # leaps into the glass
    bag_of(tmp_path / "bad.mcap", frame.to_metres(bad), t)
    out, _ = run(capsys, *common, "--run", tmp_path / "bad.mcap", "--plan", tmp_path / "plan.json",
                 "--picture", tmp_path / "run.png", "--json")  # fmt: skip
    document = json.loads(out)
    assert (document["keeps_rule"], document["follows_plan"]) == (False, False)
    worst = min(document["violations"], key=lambda v: v["margin"])
    rule = read_rules(rules)
    alone = check_plan(rule, scene, [glass.center], "careful").margin
    assert worst["margin"] == pytest.approx(alone, abs=1e-6)
    assert worst["by"] == pytest.approx(-alone, abs=1e-6)
    assert worst["object"] == glass.id
    assert worst["from_s"] <= t[141]
    assert worst["to_s"] >= t[159]
    assert worst["at"] == pytest.approx(list(glass.center), abs=1e-6)
    assert document["deviation"]["max"] > 1.0
    assert (tmp_path / "run.png").read_bytes()[:4] == b"\x89PNG"
    run(capsys, *common, "--run", tmp_path / "bad.mcap")  # in words
    silent = np.concatenate([t[:150], t[150:] + 5.0])
    bag_of(tmp_path / "silent.mcap", frame.to_metres(good), silent)
    out, _ = run(capsys, *common, "--run", tmp_path / "silent.mcap", "--json")
    document = json.loads(out)
    assert document["keeps_rule"] is None
    assert "no sample for 5" in document["unknown"][0]["why"]


def test_faults_are_one_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules, data_folder = rules_and_set(folder)
    scene = read_set(data_folder).scenes[0].scene_id
    (tmp_path / "no.json").write_text("{}")
    where = (rules, data_folder, "--scene", scene, "--type", "careful")
    for arguments in (
        ("monitor", rules, data_folder),
        ("monitor", rules, data_folder, "--scene", "none", "--type", "careful"),
        ("monitor", *where[:4]),
        ("monitor", *where, "--replay", data_folder, "--stdin"),
        ("monitor", *where, "--replay", tmp_path / "absent.mcap"),
        ("monitor", *where, "--replay", data_folder, "--out", tmp_path / "x.txt"),
        ("monitor", rules, "--scene", tmp_path / "no.json"),
        ("check-run", *where, "--run", tmp_path / "absent.mcap"),
        ("check-run", *where, "--run", data_folder),  # several runs
        ("check-run", *where, "--run", data_folder, "--plan", tmp_path / "no.json"),
    ):
        out, error = run(capsys, *arguments, status=2)
        assert out == ""
        assert len(error.strip().splitlines()) == 1, arguments
