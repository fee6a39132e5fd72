"""`demospec studio` at a shell: what it refuses in one line, what it says when it answers."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from studio_tabs import PATIENCE_S

pytest.importorskip("nicegui", reason="pip install 'demospec[studio]'")

COMMAND = [sys.executable, "-m", "demospec", "studio", "--no-browser"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--run", "nowhere"], "nowhere: expected a run folder"),
        (["--model", "nowhere.json"], "nowhere.json: expected a model folder or rule file"),
        (["nowhere"], "nowhere: expected a demonstration set"),
        (["--host", "0.0.0.0"], "0.0.0.0: expected a token (--token)"),
    ],
)
def test_bad_input_is_refused_at_once_in_one_line(
    arguments: list[str], said: str, tmp_path: Path
) -> None:
    done = subprocess.run(
        [*COMMAND, *arguments], capture_output=True, text=True, timeout=PATIENCE_S, cwd=tmp_path
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"demospec: {said}")
    assert done.stderr.count("\n") == 1


def test_a_taken_port_is_refused_at_once_in_one_line(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = subprocess.run(
            [*COMMAND, "--port", str(port)],
            capture_output=True, text=True, timeout=PATIENCE_S, cwd=tmp_path,
        )  # fmt: skip
    assert done.returncode == 2
    assert f"--port: expected an address and port that are free, found 127.0.0.1:{port}" in (
        done.stderr
    )
    assert done.stderr.count("\n") == 1


def test_the_document_says_where_the_studio_answers(small_set: Path, tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    process = subprocess.Popen(
        [*COMMAND, str(small_set), "--out", str(tmp_path / "out"), "--json",
         "--host", "0.0.0.0", "--port", str(port), "--token", "a b"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        lines: list[str] = []
        while lines[-1:] != ["}\n"]:
            lines.append(process.stdout.readline())
            assert lines[-1], "ended without a document"
        said = json.loads("".join(lines))
        assert said == {
            "address": f"http://0.0.0.0:{port}/teach?token=a%20b",
            "set": str(tmp_path / "out"),
            "pid": process.pid,
        }
        # At once: it was said when the studio answered.
        with urllib.request.urlopen(said["address"], timeout=PATIENCE_S) as answer:
            assert answer.status == 200
        with pytest.raises(urllib.error.HTTPError, match="401") as refused:
            urllib.request.urlopen(said["address"].split("?")[0], timeout=PATIENCE_S)
        refused.value.close()
    finally:
        process.terminate()
        out, told = process.communicate(timeout=PATIENCE_S)
    assert out == ""
    assert said["address"] in told
