"""Many independent tasks: in this process, in worker processes, or on a Dask cluster.

A task carries *references* (paths, row groups, settings, seeds), not data, and its function
gives the same answer wherever it runs. Results come in the order of the tasks, so that one
process, twelve processes and a cluster write the same bytes. Both ways of fanning out go
through joblib: ``loky`` on this machine, its Dask backend for a cluster that somebody (or one
of Dask's deployers: SLURM, Kubernetes, SSH) has started.

Workers that die: a cluster runs the task of a dead worker again by itself; here the tasks
without an answer are handed to new processes. A task that kills every worker it meets stops
the run after `DEATHS` deaths in a row, with the answers so far already given out.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from demospec.errors import DemospecError, InputError, MissingExtraError
from demospec.progress import Progress, silent

Task = TypeVar("Task")
Result = TypeVar("Result")

DEATHS = 3
"""Workers that may die in a row without one answer coming in between."""
CONNECT_S = 15.0
"""How long a scheduler, and the first worker of it, is waited for."""


def run_tasks(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    *,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
    what: str = "tasks",
    connect_s: float = CONNECT_S,
) -> list[Result]:
    """``[function(task) for task in tasks]``, spread over processes or machines.

    Args:
        function: Of a module (or anything cloudpickle takes); deterministic given its task.
        tasks: Small and picklable; a random task carries its own seed (`task_seed`).
        workers: Processes on this machine, ≥ 1; not used with `cluster`.
        cluster: Address of a Dask scheduler, such as ``tcp://10.0.0.5:8786``.
        progress: Told after every result, in the order of the tasks.
        what: Name of the stage for `progress`.
        connect_s: How long a scheduler, and its first worker, is waited for.

    Raises:
        InputError: `workers` below 1, or no scheduler or worker answers at `cluster`.
        MissingExtraError: `cluster` without Dask installed.
        DemospecError: One task killed `DEATHS` workers in a row.
    """
    return list(
        iterate_tasks(
            function,
            tasks,
            workers=workers,
            cluster=cluster,
            progress=progress,
            what=what,
            connect_s=connect_s,
        )
    )


def iterate_tasks(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    *,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
    what: str = "tasks",
    connect_s: float = CONNECT_S,
) -> Iterator[Result]:
    """As `run_tasks`, one result after the other: what was given out stays done.

    Stop early by closing the generator (or by Ctrl-C): the workers' tasks are dropped.
    """
    if workers < 1:
        raise InputError("at least 1", workers, field="workers")
    several = workers if len(tasks) > 1 or cluster else 1
    with _executor(several, cluster, connect_s) as some:
        for done, result in enumerate(some(function, tasks), start=1):
            progress(what, done, len(tasks))
            yield result


def task_seed(seed: int, index: int) -> int:
    """A 32-bit seed for task `index`: the same however many tasks or workers there are."""
    import numpy as np

    state = np.random.SeedSequence(entropy=seed, spawn_key=(index,)).generate_state(1)
    return int(state[0])


Runner = Callable[[Callable[[Any], Any], Sequence[Any]], Iterator[Any]]


@contextlib.contextmanager
def _executor(workers: int, cluster: str | None, connect_s: float) -> Iterator[Runner]:
    if cluster is not None:
        with _client(cluster, connect_s) as client:
            # Every task is told to the scheduler at once: an adaptive cluster grows by its queue.
            yield lambda function, tasks: _fan_out(
                function, tasks, {"backend": _cluster_backend(client), "n_jobs": -1}, "all"
            )
    elif workers == 1:
        yield lambda function, tasks: (function(task) for task in tasks)
    else:
        # Libraries in the workers compute on one thread each: the sums of a process with one
        # thread, and no more threads than cores.
        # loky replaces a worker that has grown by 300 MB (torch alone does) and warns of a leak;
        # no task is lost by it.
        warnings.filterwarnings("ignore", message="A worker stopped while some jobs")
        settings = {"backend": "loky", "n_jobs": workers, "inner_max_num_threads": 1}
        yield lambda function, tasks: _fan_out(function, tasks, settings)


def _fan_out(
    function: Callable[[Any], Any],
    tasks: Sequence[Any],
    settings: dict[str, Any],
    ahead: str = "3*n_jobs",
) -> Iterator[Any]:
    """Ordered results; starts again behind the last one given out when processes die."""
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    call = _Call(function)
    first, deaths = 0, 0
    # Before the first task: an interrupt drops the tasks while it is still on its way to here.
    hook = threading.excepthook
    threading.excepthook = _quiet_about_dropped_tasks
    while first < len(tasks):
        with parallel_config(**settings), _workers_deaf_to_ctrl_c():
            parallel = Parallel(return_as="generator", batch_size=1, pre_dispatch=ahead)
            results = parallel(delayed(call)(task) for task in tasks[first:])
        end_feeding = _end_of_feeding(parallel)
        try:
            for result in results:
                first, deaths = first + 1, 0
                yield result
        except TerminatedWorkerError:
            deaths += 1
            if deaths >= DEATHS:
                found = f"task {first} ended {deaths} worker processes (too little memory?)"
                raise DemospecError(found) from None
        except Exception as error:
            if type(error).__name__ != "KilledWorker":
                raise
            raise DemospecError(f"the cluster gave up on a task: {_one_line(error)}") from None
        finally:
            with warnings.catch_warnings():  # joblib counts the tasks that were dropped
                warnings.simplefilter("ignore")
                results.close()
            end_feeding()
    threading.excepthook = hook


@contextlib.contextmanager
def _workers_deaf_to_ctrl_c() -> Iterator[None]:
    """Processes started within never see Ctrl-C, not even while they import; it waits here.

    A blocked signal stays blocked in a child; later workers come from a thread started within.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # it unblocks the signal where it is started within
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_of_feeding(parallel: Any, seconds: float = 2.0) -> Callable[[], None]:
    """What ends the thread that feeds the workers of `parallel`, once its run was dropped.

    Otherwise that daemon thread ends when nothing points at its queue any more, and takes the last
    semaphores along. Where the process ends at that moment, one is unlinked and still listed:
    loky's tracker warns of a leak.
    """
    executor: Any = getattr(getattr(parallel, "_backend", None), "_workers", None)
    queue = getattr(executor, "_call_queue", None)

    def end() -> None:
        if queue is not None and executor._call_queue is None:  # dropped, not kept for reuse
            queue.close()
            feeder = getattr(queue, "_thread", None)
            if feeder is not None:
                feeder.join(seconds)

    return end


_report_of_threads = threading.excepthook


def _quiet_about_dropped_tasks(about: threading.ExceptHookArgs) -> None:
    """Says nothing of a task that loky's own thread misses after its tasks were dropped.

    The thread may be handing out a task at the moment in which stopping early takes all tasks
    away from it; it then ends with a KeyError, which is what stopping means. It may do so after
    the run has ended, so this stays in place when a run was stopped.
    """
    name = "" if about.thread is None else about.thread.name
    if not (name == "ExecutorManagerThread" and about.exc_type is KeyError):
        _report_of_threads(about)


class _Call:
    """A function as a worker runs it: Ctrl-C is the parent's to handle."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self.function = function
        self.parent = os.getpid()

    def __call__(self, task: Any) -> Any:
        elsewhere = os.getpid() != self.parent
        if elsewhere and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        if os.getppid() == self.parent:  # a worker of this machine, not one of a cluster
            _die_with(self.parent)
        if elsewhere and "torch" in sys.modules:
            sys.modules["torch"].set_num_threads(1)
        return self.function(task)


_watched: set[int] = set()


def _die_with(parent: int) -> None:
    """Ends this process soon after its parent is gone, by whatever death.

    A killed parent cannot stop its workers: they would finish their tasks beside those of the
    run that goes on, and then keep their memory waiting for a lock that nobody gives back.
    """
    if parent in _watched:
        return
    _watched.add(parent)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, name="follow the parent", daemon=True).start()


def _cluster_backend(client: Any) -> Any:
    """joblib's Dask backend, which never computes in this process.

    joblib computes by itself where a cluster has one core (or has lost all but one just now),
    and never hears of a task that the scheduler gave up (its callback comes on success only).
    """
    from joblib._dask import DaskDistributedBackend

    class GivenUp:
        def __init__(self, error: BaseException) -> None:
            self.error = error

    class Cluster(DaskDistributedBackend):  # type: ignore[misc]
        def effective_n_jobs(self, n_jobs: int = 1) -> int:
            return max(2, int(super().effective_n_jobs(n_jobs)))

        def submit(self, func: Any, callback: Any = None) -> Any:
            def heard(future: Any) -> None:
                if future.exception() is not None:
                    callback(GivenUp(future.exception()))

            future = super().submit(func, callback)
            future.add_done_callback(heard)
            return future

        def retrieve_result_callback(self, out: Any) -> Any:
            if isinstance(out, GivenUp):
                raise out.error
            return super().retrieve_result_callback(out)

        def __reduce__(self) -> tuple[Any, ...]:
            return DaskDistributedBackend, ()

    return Cluster(client=client)


@contextlib.contextmanager
def _client(address: str, connect_s: float) -> Iterator[Any]:
    """A client of the scheduler at `address`; its tasks are dropped when the block ends."""
    try:
        import distributed
    except ImportError as error:
        raise MissingExtraError("dask", "distributed", "a cluster") from error
    connect: Any = distributed.Client
    try:
        client = connect(address, timeout=connect_s, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        expected = "the address of a running Dask scheduler"
        raise InputError(expected, address, field="cluster") from error
    try:
        try:
            client.wait_for_workers(1, timeout=connect_s)
        except TimeoutError as error:
            raise InputError("a cluster with workers", "none", field="cluster") from error
        yield client
    finally:
        client.close()


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())[:300]
