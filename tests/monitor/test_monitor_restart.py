"""A monitor that is killed and started again: nothing is left, nothing is made up."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import IO

import pytest

from demospec.demonstrations import read_set, simulate_set, write_set
from demospec.monitor import Monitor
from demospec.rules import read_rules


def told(stream: IO[str], t: float, x: float, y: float) -> None:
    stream.write(json.dumps({"t": t, "x": x, "y": y}) + "\n")
    stream.flush()


@pytest.mark.slow
def test_killed_in_the_middle_and_started_again(tmp_path: Path) -> None:
    data, truth = simulate_set(train_scenes=1, test_scenes=0, demonstrations=1, seed=5)
    write_set(data, tmp_path / "set", documents={"truth.json": truth})
    before = {f: f.read_bytes() for f in sorted(tmp_path.rglob("*")) if f.is_file()}
    scene = data.scenes[0]
    command = [
        sys.executable, "-m", "demospec.cli", "monitor", str(tmp_path / "set" / "truth.json"),
        str(tmp_path / "set"), "--scene", scene.scene_id, "--type", "careful",
    ]  # fmt: skip

    def started() -> subprocess.Popen[str]:
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, cwd=tmp_path,
        )  # fmt: skip

    first = started()
    assert first.stdin is not None
    assert first.stdout is not None
    told(first.stdin, 0.0, *scene.start)
    assert json.loads(first.stdout.readline())["t"] == 0.0
    first.kill()
    first.communicate()
    assert first.returncode == -9

    second = started()
    # In an object at once: the violation is said of the first sample, without a piece between.
    centre = scene.listed_objects()[0].center
    out, err = second.communicate(json.dumps({"t": 0.1, "x": centre[0], "y": centre[1]}) + "\n")
    assert (second.returncode, err.count("Traceback")) == (0, 0), err
    reading = json.loads(out.splitlines()[0])
    rules = read_rules(tmp_path / "set" / "truth.json")
    fresh = Monitor(rules, read_set(tmp_path / "set").scenes[0], "careful").update(0.1, centre)
    assert (reading["verdict"], reading["object"]) == ("violation", fresh.object)
    assert reading["margin"] == pytest.approx(fresh.margin)
    after = {f: f.read_bytes() for f in sorted(tmp_path.rglob("*")) if f.is_file()}
    assert after == before
