"""Answers about the table as it stands that may take long: found once, beside the work."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Generic, TypeVar

Answer = TypeVar("Answer")

SOON_S = 0.15
"""How long a page waits for what may take long before it is told that it is not known yet."""


class Later(Generic[Answer]):
    """One answer for each state of the table, for many threads; never one of an older state.

    One is sought at a time: while the table changes under it, the next begins when that ends.

    Args:
        version: The state of the table now.
        find: The answer; may take long.
    """

    def __init__(self, version: Callable[[], int], find: Callable[[], Answer]) -> None:
        self._version = version
        self._find = find
        self._lock = threading.Lock()
        self._sought: tuple[int, Future[Answer]] | None = None

    def now(self, wait_s: float | None = None) -> Answer | None:
        """The answer of now; None where it is not known within `wait_s` seconds (None: for ever).

        Raises:
            Exception: What `find` raised.
        """
        end = None if wait_s is None else time.monotonic() + wait_s
        while True:
            wanted, (version, future) = self._version(), self._begun()
            left = None if end is None else max(0.0, end - time.monotonic())
            if not _done(future, left):
                return None
            if version == wanted:
                return future.result()

    def _begun(self) -> tuple[int, Future[Answer]]:
        with self._lock:
            now = self._version()
            old = self._sought
            if old is not None and (not old[1].done() or (old[0] == now and _good(old[1]))):
                return old
            future: Future[Answer] = Future()
            self._sought = (now, future)
        # Nothing waits for it at the end: what it finds is about a table that is closed.
        threading.Thread(target=self._seek, args=(future,), daemon=True).start()
        return now, future

    def _seek(self, future: Future[Answer]) -> None:
        try:
            future.set_result(self._find())
        except BaseException as error:  # whoever asks is told
            future.set_exception(error)


def _done(future: Future[Answer], left: float | None) -> bool:
    try:
        future.exception(left)
    except TimeoutError:
        return False
    return True


def _good(future: Future[Answer]) -> bool:
    return future.exception() is None
