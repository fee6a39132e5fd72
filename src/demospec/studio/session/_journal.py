"""The studio's journal: an append-only log of what people did, in SQLite (WAL).

Every stroke is on the disk before it is answered. Nothing is ever changed or removed: undo and
redo are events too, so that several tabs and processes may write at once and a crash loses
nothing.
"""

from __future__ import annotations

import json
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from demospec.errors import InputError, OutputError

ACTIONS = (
    "add", "label", "edit", "delete", "many", "keep", "scene", "mark", "unmark", "object", "ends",
    "scale", "rename_scene", "drop_scene", "merge_scenes", "import",
)  # fmt: skip
"""What can be undone; ``undo`` and ``redo`` name one of these."""

_SCHEMA = """
CREATE TABLE IF NOT EXISTS meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS events (
  seq INTEGER PRIMARY KEY AUTOINCREMENT, at REAL NOT NULL, actor TEXT NOT NULL,
  kind TEXT NOT NULL, body TEXT NOT NULL, blob BLOB);
"""
_WAIT_S = 20.0  # for another process that is writing


@dataclass(frozen=True)
class Event:
    """One line of the journal.

    Args:
        seq: Its number, from 1.
        at: Seconds since 1970.
        actor: Who did it: a browser tab, or ``api``. Undo undoes one's own.
        kind: One of `ACTIONS`, ``undo`` or ``redo``.
        body: What was done.
        blob: A picture, for ``scene``; a packed set, for ``import``.
    """

    seq: int
    at: float
    actor: str
    kind: str
    body: Mapping[str, Any] = field(compare=False)
    blob: bytes | None = field(default=None, compare=False, repr=False)


class Journal:
    """The log in one file; any number of threads and processes may have it open.

    Raises:
        OutputError: The file cannot be made.
        InputError: It is not a journal, or one of another set.
    """

    def __init__(self, file: Path, about: str) -> None:
        self.file = file
        self._lock = threading.RLock()
        self._known: list[Event] = []
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            # Transactions are begun by hand: the library's own would begin them too late.
            self._base = sqlite3.connect(
                file, timeout=_WAIT_S, isolation_level=None, check_same_thread=False
            )
            self._base.execute("PRAGMA journal_mode=WAL")
            self._base.execute("PRAGMA synchronous=FULL")  # a power cut loses nothing either
            self._base.executescript(_SCHEMA)
        except sqlite3.DatabaseError as error:
            if isinstance(error, sqlite3.OperationalError):
                raise OutputError(f"{file}: cannot open the journal: {error}") from error
            raise InputError("a journal of the studio", str(error), file=file) from error
        except OSError as error:
            raise OutputError(f"{file}: cannot write: {error.strerror or error}") from error
        with self._writing():
            row = self._base.execute("SELECT value FROM meta WHERE key='about'").fetchone()
            if row is None:
                self._base.execute("INSERT INTO meta VALUES ('about', ?)", (about,))
        if row is not None and row[0] != about:
            self._base.close()
            raise InputError(
                "a journal about this set (choose another --out)", "one about another", file=file
            )

    def close(self) -> None:
        with self._lock:
            self._base.close()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """One transaction: nobody else writes meanwhile, and it happens whole or not at all."""
        with self._lock:
            try:
                self._base.execute("BEGIN IMMEDIATE")
                try:
                    yield
                except BaseException:
                    if self._base.in_transaction:  # a full disk has ended it already
                        self._base.execute("ROLLBACK")
                    raise
                self._base.execute("COMMIT")
            except sqlite3.Error as error:
                raise OutputError(f"{self.file}: nothing was kept: {error}") from error

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keeps every other writer, in this process and in others, out of the block.

        Whoever holds other locks too takes this one last.
        """
        with self._writing():
            yield

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Keeps who else asks for a turn, in this process and in others, out of the block.

        Apart from `alone`, and longer: the journal is read and written meanwhile.

        Raises:
            OutputError: Another process keeps its turn.
        """
        place = self.file.with_name(self.file.name + "-turn")
        base = sqlite3.connect(place, timeout=_WAIT_S, isolation_level=None)
        try:
            try:
                base.execute("BEGIN EXCLUSIVE")
            except sqlite3.OperationalError as error:
                raise OutputError(f"{place}: another studio is writing: {error}") from error
            yield
        finally:
            base.close()

    def events(self) -> Sequence[Event]:
        """All events, in order; only those that are new are read."""
        with self._lock:
            last = self._known[-1].seq if self._known else 0
            query = "SELECT seq, at, actor, kind, body, blob FROM events WHERE seq > ? ORDER BY seq"
            for seq, at, actor, kind, body, blob in self._base.execute(query, (last,)):
                self._known.append(Event(seq, at, actor, kind, self._body(seq, body), blob))
            return tuple(self._known)

    def _body(self, seq: int, text: str) -> Mapping[str, Any]:
        try:
            body = json.loads(text)
        except (ValueError, TypeError, RecursionError) as error:
            raise InputError("a JSON object", "another", file=self.file, row=seq) from error
        if not isinstance(body, dict):
            raise InputError("a JSON object", body, file=self.file, row=seq)
        return body

    def append(
        self, kind: str, body: Mapping[str, Any], *, actor: str, blob: bytes | None = None
    ) -> int:
        """Writes one event and returns its number; it is on the disk then."""
        with self._writing():
            return self.append_within(kind, body, actor=actor, blob=blob)

    def append_within(
        self, kind: str, body: Mapping[str, Any], *, actor: str, blob: bytes | None = None
    ) -> int:
        """`append` for who is in an `alone` block already."""
        text = json.dumps(body, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        return self._insert(kind, text, actor, blob)

    def _insert(self, kind: str, text: str, actor: str, blob: bytes | None = None) -> int:
        row = (time.time(), actor, kind, text, blob)
        found = self._base.execute(
            "INSERT INTO events (at, actor, kind, body, blob) VALUES (?, ?, ?, ?, ?)", row
        )
        assert found.lastrowid is not None
        return found.lastrowid

    def undo(self, actor: str) -> Event | None:
        """Takes back the actor's last action that stands; None where there is none."""
        return self._step(actor, "undo")

    def redo(self, actor: str) -> Event | None:
        """Does again what the actor took back last, unless they have acted since."""
        return self._step(actor, "redo")

    def _step(self, actor: str, kind: str) -> Event | None:
        with self._writing():
            done, undone = standing(self.events(), actor)
            pile = done if kind == "undo" else undone
            if not pile:
                return None
            self._insert(kind, json.dumps({"of": pile[-1].seq}), actor)
            return pile[-1]

    def can(self, actor: str) -> tuple[bool, bool]:
        """Whether the actor can undo, and redo."""
        done, undone = standing(self.events(), actor)
        return bool(done), bool(undone)


def standing(events: Sequence[Event], actor: str) -> tuple[list[Event], list[Event]]:
    """The actor's actions that stand and those they may do again, each the last one last."""
    done: list[Event] = []
    undone: list[Event] = []
    for event in events:
        if event.actor != actor:
            continue
        if event.kind == "undo" and done:
            undone.append(done.pop())
        elif event.kind == "redo" and undone:
            done.append(undone.pop())
        elif event.kind in ACTIONS:
            done.append(event)
            undone.clear()
    return done, undone


def effective(events: Sequence[Event]) -> list[Event]:
    """The actions that stand, whoever did them, in order."""
    off: set[int] = set()
    for event in events:
        if event.kind == "undo":
            off.add(int(event.body["of"]))
        elif event.kind == "redo":
            off.discard(int(event.body["of"]))
    return [e for e in events if e.kind in ACTIONS and e.seq not in off]
