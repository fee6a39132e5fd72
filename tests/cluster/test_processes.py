"""Tasks in processes of this machine: same bits, order, faults, deaths, Ctrl-C."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest
import work_for_tests as work

from demospec.errors import DemospecError, InputError, MissingExtraError
from demospec.parallel import iterate_tasks, run_tasks, task_seed

HERE = Path(__file__).parent


def test_same_bytes_in_order_however_many_processes():
    tasks = [(5, i) for i in range(12)]
    told: list[tuple[str, float, float]] = []
    alone = run_tasks(work.draw, tasks)
    spread = run_tasks(
        work.draw, tasks, workers=2, what="drawing", progress=lambda *step: told.append(step)
    )
    assert spread == alone
    assert told == [("drawing", i + 1, 12) for i in range(12)]


def test_processes_are_really_others():
    found = set(run_tasks(work.where, range(6), workers=2))
    assert os.getpid() not in found
    assert len(found) == 2
    assert set(run_tasks(work.where, range(2))) == {os.getpid()}


def test_seed_of_a_task_depends_on_nothing_else():
    assert task_seed(0, 7) == task_seed(0, 7)
    assert len({task_seed(s, i) for s in range(5) for i in range(200)}) == 1000


@pytest.mark.parametrize("workers", [1, 2])
def test_a_fault_in_a_task_arrives_whole(workers):
    with pytest.raises(InputError) as caught:
        run_tasks(work.refuse, range(5), workers=workers)
    assert str(caught.value) == "set/dataset.json, row 7, n: expected an even task, found 3"
    assert caught.value.row == 7


def test_every_error_of_ours_survives_pickling():
    for error in (
        InputError("a", 3, file="f", row=1, field="x"),
        MissingExtraError("dask", "distributed", "a cluster"),
        DemospecError("plain"),
    ):
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error)
        assert str(again) == str(error)
        assert again.__dict__ == error.__dict__


def test_a_killed_process_loses_nothing(tmp_path):
    tasks = [(str(tmp_path), i) for i in range(10)]
    assert run_tasks(work.die_once, tasks, workers=2) == [i * i for i in range(10)]
    assert (tmp_path / "died").exists()


def test_what_was_given_out_is_not_computed_again(tmp_path):
    tasks = [(str(tmp_path), i) for i in range(10)]
    list(iterate_tasks(work.die_once, tasks, workers=2))
    ran = (tmp_path / "ran").read_text().split()
    assert ran.count("0") == 1  # given out long before task 4 died
    assert ran.count("4") == 2


def test_a_task_that_kills_every_worker_is_named():
    with pytest.raises(DemospecError, match="task 2 ended 3 worker processes"):
        run_tasks(work.die_always, range(4), workers=2)


def test_no_workers_and_no_scheduler_are_input_errors():
    with pytest.raises(InputError, match="at least 1"):
        run_tasks(work.where, [1], workers=0)
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match="running Dask scheduler"):
        run_tasks(work.where, [1, 2], cluster="tcp://127.0.0.1:9", connect_s=0.5)


def test_workers_end_with_a_parent_that_was_killed(tmp_path):
    """kill -9 on the parent alone: no worker goes on, none is left."""
    script = tmp_path / "long.py"
    script.write_text(
        textwrap.dedent(
            f"""
            import sys
            sys.path.insert(0, {str(HERE)!r})
            import work_for_tests as work
            from demospec.parallel import run_tasks
            run_tasks(work.slow_and_named, [({str(tmp_path)!r}, i) for i in range(200)], workers=2)
            """
        )
    )
    process = subprocess.Popen([sys.executable, str(script)], start_new_session=True)
    deadline = time.monotonic() + 30
    while len(list(tmp_path.glob("pid-*"))) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    workers = [int(p.name.removeprefix("pid-")) for p in tmp_path.glob("pid-*")]
    assert len(workers) == 2
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    while any(map(alive, workers)) and time.monotonic() < deadline + 30:
        time.sleep(0.05)
    assert not any(map(alive, workers))


def alive(pid: int) -> bool:
    """Whether it runs: a process that has ended and that nobody has asked for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_ctrl_c_stops_parent_and_workers_without_a_traceback(tmp_path):
    """As a terminal does it: SIGINT to the whole process group."""
    script = tmp_path / "long.py"
    script.write_text(
        textwrap.dedent(
            f"""
            import sys
            sys.path.insert(0, {str(HERE)!r})
            import work_for_tests as work
            from demospec.parallel import run_tasks
            try:
                run_tasks(work.slow, [({str(tmp_path)!r}, i) for i in range(200)], workers=2)
            except KeyboardInterrupt:
                print("stopped", file=sys.stderr)
                raise SystemExit(130)
            """
        )
    )
    process = subprocess.Popen(
        [sys.executable, str(script)], stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    deadline = time.monotonic() + 30
    while not (tmp_path / "ran").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert (tmp_path / "ran").exists()
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors == "stopped\n"
    time.sleep(0.5)
    ran = (tmp_path / "ran").read_text()
    time.sleep(0.8)
    assert (tmp_path / "ran").read_text() == ran  # no worker goes on
