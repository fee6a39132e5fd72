"""A real scheduler and real worker processes on loopback: the numbers of one process."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import work_for_tests as work

from demospec.errors import DemospecError, InputError
from demospec.parallel import run_tasks

distributed = pytest.importorskip("distributed", reason="pip install 'demospec[distributed]'")

# A client leaves sockets and loops to the garbage collector, whenever that comes.
pytestmark = pytest.mark.filterwarnings("default::ResourceWarning")


def started(command: list[str], log: Path, says: str, count: int = 1) -> Any:
    """The process, once its log says what it should `count` times."""
    with open(log, "w", encoding="utf-8") as file:
        process = subprocess.Popen(command, stdout=file, stderr=file, start_new_session=True)
    deadline = time.monotonic() + 60
    while len(re.findall(says, log.read_text())) < count:
        assert process.poll() is None, log.read_text()
        assert time.monotonic() < deadline, log.read_text()
        time.sleep(0.1)
    return process


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a scheduler with two workers, all started as a person would start them."""
    folder = tmp_path_factory.mktemp("cluster")
    dask = [sys.executable, "-m", "dask"]
    loopback = ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0"]
    running = []
    try:
        log = folder / "scheduler.log"
        running.append(
            started([*dask, "scheduler", *loopback, "--port", "0"], log, r"Scheduler at: +tcp")
        )
        found = re.search(r"Scheduler at: +(tcp://127\.0\.0\.1:\d+)", log.read_text())
        assert found is not None
        address = found.group(1)
        many = ["--nworkers", "2", "--nthreads", "1", "--local-directory", str(folder)]
        log = folder / "workers.log"
        running.append(
            started([*dask, "worker", address, *loopback, *many], log, r"Registered to:", 2)
        )
        yield address
    finally:
        for process in reversed(running):
            os.killpg(process.pid, signal.SIGTERM)
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)


def test_same_bytes_as_one_process(cluster):
    tasks = [(9, i) for i in range(12)]
    told: list[float] = []
    spread = run_tasks(
        work.draw, tasks, cluster=cluster, progress=lambda what, done, total: told.append(done)
    )
    assert spread == run_tasks(work.draw, tasks)
    assert told == list(range(1, 13))


def test_a_worker_killed_in_the_middle_loses_nothing(cluster, tmp_path):
    tasks = [(str(tmp_path), i) for i in range(10)]
    assert run_tasks(work.die_once, tasks, cluster=cluster) == [i * i for i in range(10)]
    assert (tmp_path / "died").exists()


def test_a_fault_in_a_task_arrives_whole(cluster):
    with pytest.raises(InputError, match=r"set/dataset\.json, row 7, n: expected an even task"):
        run_tasks(work.refuse, range(5), cluster=cluster)


def test_tasks_run_elsewhere_and_listen_on_loopback_only(cluster):
    import psutil

    found = set(run_tasks(work.where, range(8), cluster=cluster))
    assert os.getpid() not in found
    for pid in found:
        for connection in psutil.Process(pid).net_connections(kind="inet"):
            assert connection.laddr.ip in ("127.0.0.1", "::1")


def test_a_task_that_kills_every_worker_is_named(cluster):
    with pytest.raises(DemospecError, match="the cluster gave up on a task"):
        run_tasks(work.die_always, range(4), cluster=cluster)


def test_a_causal_analysis_on_the_cluster_is_that_of_one_process(cluster, tmp_path):
    from functools import partial

    import numpy as np

    from demospec.causal import Settings, trials_of_set, trials_of_stored
    from demospec.demonstrations import read_set, simulate_set, write_set
    from demospec.files import write_json
    from demospec.rules import read_rules

    data, truth = simulate_set(train_scenes=5, test_scenes=0, demonstrations=1, seed=4)
    write_set(data, tmp_path / "set")
    write_json(tmp_path / "truth.json", truth)
    load = partial(read_rules, tmp_path / "truth.json")
    quick = Settings(draws=6, placements=1)
    there = trials_of_stored(load, tmp_path / "set", settings=quick, cluster=cluster)
    here = trials_of_set(load(), read_set(tmp_path / "set"), settings=quick)
    assert there.scene_ids == here.scene_ids
    assert len(there.trials) == len(here.trials)
    for one, other in zip(there.trials, here.trials, strict=True):
        assert (one.scene, one.symbol) == (other.scene, other.symbol)
        assert np.array_equal(one.after, other.after)


def test_rules_learned_with_the_cluster_are_those_of_one_process(cluster, tmp_path):
    from demospec.demonstrations import sample_set, simulate_set, write_set
    from demospec.rules import learn_rules, rules_document

    data, _ = simulate_set(train_scenes=5, test_scenes=0, demonstrations=4, seed=4)
    store = str(write_set(data, tmp_path / "set"))
    here = sample_set(store, per_type=9, seed=2)
    assert sample_set(store, per_type=9, seed=2, rows=13, cluster=cluster) == here
    one = rules_document(learn_rules(here, influence=False))
    assert rules_document(learn_rules(here, influence=False, cluster=cluster)) == one
