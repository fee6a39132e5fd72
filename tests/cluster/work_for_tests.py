"""Tasks that the tests hand to worker processes, which import this module by its file name."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np

from demospec.errors import InputError
from demospec.parallel import task_seed


def draw(task: tuple[int, int]) -> bytes:
    """The bytes of a sum of products that rounds: the same bits or different bytes."""
    seed, index = task
    rng = np.random.default_rng(task_seed(seed, index))
    a = rng.normal(size=(40, 40))
    time.sleep(0.002 * (index % 5))  # later tasks end before earlier ones
    return np.linalg.solve(a, a @ a.T).tobytes()


def where(task: int) -> int:
    time.sleep(0.05)
    return os.getpid()


def refuse(task: int) -> int:
    if task == 3:
        raise InputError("an even task", task, file="set/dataset.json", row=7, field="n")
    return task


def die_once(task: tuple[str, int]) -> int:
    """Task 4 kills its worker the first time somebody runs it; every run leaves a line."""
    folder, index = Path(task[0]), task[1]
    with open(folder / "ran", "a", encoding="utf-8") as file:
        file.write(f"{index}\n")
    marker = folder / "died"
    if index == 4 and not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.02)
    return index * index


def die_always(task: int) -> int:
    if task == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return task


def slow_and_named(task: tuple[str, int]) -> int:
    (Path(task[0]) / f"pid-{os.getpid()}").touch()
    return slow(task)


def slow(task: tuple[str, int]) -> int:
    time.sleep(0.3)
    with open(Path(task[0]) / "ran", "a", encoding="utf-8") as file:
        file.write(f"{task[1]}\n")
    return task[1]
