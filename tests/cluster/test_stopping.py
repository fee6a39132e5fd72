"""Long commands stopped in the middle: one line, exit status 130, nothing half-written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from demospec.demonstrations import read_set, simulate_set, write_set
from demospec.files import write_json


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stopping")
    data, truth = simulate_set(train_scenes=6, test_scenes=2, demonstrations=30, seed=3)
    write_set(data, folder / "set")
    write_json(folder / "truth.json", truth)
    return folder


def long_command(name: str, place: Path, out: Path) -> list[str]:
    data = str(place / "set")
    return {
        "simulate": ["simulate", "--train-scenes", "4000", "--out", str(out)],
        "fit": ["fit", data, "--model", "paper", "--out", str(out)],
        "causes": ["causes", str(place / "truth.json"), data, "--out", str(out)],
    }[name]


def stopped(command: list[str], signal_: int, after_s: float) -> tuple[int, str, str]:
    """Exit status and output of a command that got a signal, as from a terminal."""
    code = "from demospec.cli import main; print('up', flush=True); main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "up\n"
    time.sleep(after_s)
    assert process.poll() is None, process.stderr.read() if process.stderr else ""
    os.killpg(process.pid, signal_)
    out, errors = process.communicate(timeout=30)
    return process.returncode, out, errors


@pytest.mark.parametrize("name", ["simulate", "fit", "causes"])
def test_ctrl_c_is_one_line_and_leaves_nothing(name, place, tmp_path):
    if name == "fit":
        pytest.importorskip("torch")
    command = long_command(name, place, tmp_path / "out")
    status, out, errors = stopped(command, signal.SIGINT, 2.0)
    assert status == 130
    assert out == ""
    assert "Traceback" not in errors
    assert errors.rstrip().splitlines()[-1] == "demospec: stopped"
    assert list(tmp_path.iterdir()) == []  # not even a temporary name


def test_ctrl_c_before_the_work_has_begun(place, tmp_path):
    status, _, errors = stopped(
        long_command("simulate", place, tmp_path / "out"), signal.SIGINT, 0.05
    )
    assert status == 130
    assert errors.rstrip().splitlines()[-1] == "demospec: stopped"


def test_kill_9_leaves_no_half_set_and_the_command_starts_again(place, tmp_path):
    out = tmp_path / "out"
    status, _, _ = stopped(long_command("simulate", place, out), signal.SIGKILL, 2.0)
    assert status == -signal.SIGKILL
    assert not out.exists()
    again = ["simulate", "--train-scenes", "2", "--demonstrations", "2", "--out", str(out)]
    subprocess.run([sys.executable, "-m", "demospec", *again], check=True, capture_output=True)
    assert len(read_set(out).demonstrations) > 0


def test_kill_9_keeps_the_older_answer_whole(place, tmp_path):
    """An answer that is being replaced stays readable until the new one has its name."""
    out = tmp_path / "answer.json"
    out.write_text("{}\n")
    stopped([*long_command("causes", place, out), "--force"], signal.SIGKILL, 1.5)
    assert out.read_text() == "{}\n"
