"""What takes long is found once for each state of the table, and never for an older one."""

from __future__ import annotations

import threading

import pytest

from demospec.studio.session._later import Later


def test_who_cannot_wait_is_told_and_nothing_is_found_twice() -> None:
    may_end, found = threading.Event(), list[int]()

    def find() -> int:
        may_end.wait(60)
        found.append(1)
        return len(found)

    later = Later(lambda: 7, find)
    assert later.now(0.0) is None
    assert later.now(0.01) is None
    may_end.set()
    assert later.now() == 1
    assert later.now(0.0) == 1
    assert found == [1]


def test_what_was_found_for_an_older_table_is_never_told() -> None:
    table, steps = [1], {1: threading.Event(), 2: threading.Event()}

    def find() -> int:
        mine = table[0]
        steps[mine].wait(60)
        return mine

    later = Later(lambda: table[0], find)
    assert later.now(0.0) is None
    table[0] = 2
    steps[1].set()
    assert later.now(0.05) is None  # the first may have ended; it is of another table
    steps[2].set()
    assert later.now() == 2


def test_a_fault_is_told_and_sought_again() -> None:
    tries = list[int]()

    def find() -> str:
        tries.append(1)
        if len(tries) == 1:
            raise ValueError("once")
        return "found"

    later = Later(lambda: 1, find)
    with pytest.raises(ValueError, match="once"):
        later.now()
    assert later.now() == "found"
