"""A long table of many demonstrations: which rows belong to which."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from demospec.demonstrations.readers._column_names import ColumnName, column_name
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._values import AUTO
from demospec.demonstrations.readers.tables._text_table import TextTable
from demospec.errors import InputError
from demospec.frames import FloatArray

NAMES = ("demo_id", "demonstration", "demonstration_id", "demo", "episode", "episode_id",
         "episode_index", "trajectory", "trajectory_id", "traj_id")  # fmt: skip
"""Names of the column that says to which demonstration a row belongs, in order of preference."""

_PERHAPS = ("traj", "rollout", "rollout_id", "trial", "trial_id", "run", "run_id", "recording",
            "recording_id", "track", "track_id", "id")  # fmt: skip
"""Names that mean it only where the column has several values, each in several rows."""


@dataclass(frozen=True)
class Episode:
    """The rows of one demonstration, and its name as it is written."""

    name: str
    rows: np.ndarray


def episodes_of(table: TextTable, mapping: Mapping, file: Path) -> list[Episode] | None:
    """The demonstrations of a table, in order of their first rows; None where it holds one.

    Raises:
        InputError: An empty name; two columns that would part the rows differently; rows of one
            name in several places whose time starts again; rows that look like several
            demonstrations without a column that is known to tell them apart.
    """
    name = mapping.demonstration
    if name == "none":
        return None
    if name is not None and name not in table.names:
        raise InputError(
            f"a column {name}", ", ".join(table.names), file=file, field="demonstration"
        )
    if name is None:
        name = _found(table, file)
        if name is None:
            _refuse_hidden(table, file)
            return None
    j = table.names.index(name)
    texts = table.cells.texts(j)
    if "" in texts:
        row = f"line {table.cells.line(texts.index(''))}"
        raise InputError("a name", "an empty cell", file=file, row=row, field=name)
    episodes = _by_name(texts)
    _refuse_reused(episodes, table, name, file)
    return episodes


def _by_name(texts: list[str]) -> list[Episode]:
    rows: dict[str, list[int]] = {}
    for i, text in enumerate(texts):
        rows.setdefault(text, []).append(i)
    return [Episode(text, np.array(places)) for text, places in rows.items()]


def _found(table: TextTable, file: Path) -> str | None:
    """The column that tells demonstrations apart, by its name."""
    lower = {n.lower(): n for n in reversed(table.names)}
    found = [lower[n] for n in (*NAMES, *_PERHAPS) if n in lower]
    parts = {n: _by_name(table.cells.texts(table.names.index(n))) for n in found}
    rows = len(table.cells)
    found = [n for n in found if n.lower() in NAMES or 1 < len(parts[n]) < rows]
    if not found:
        return None
    split = {n: [tuple(e.rows.tolist()) for e in parts[n]] for n in found}
    for other in found[1:]:
        if split[other] != split[found[0]] and len(split[other]) > 1:
            expected = "one column that tells demonstrations apart (--demonstration NAME)"
            raise InputError(expected, f"{found[0]}, {other}", file=file, field="demonstration")
    return found[0]


def _columns(table: TextTable) -> list[ColumnName]:
    return [column_name(n, table.units.get(n)) for n in table.names]


def _clock(table: TextTable) -> FloatArray | None:
    """The time column as it stands, or None."""
    times = [(c.rank, j) for j, c in enumerate(_columns(table)) if c.quantity == "time"]
    if not times:
        return None
    try:
        return table.cells.seconds(min(times)[1])
    except InputError:
        return None  # named when it is read


def _refuse_reused(episodes: list[Episode], table: TextTable, name: str, file: Path) -> None:
    """InputError where a name comes back after others and its rows do not go on in time."""
    clock = _clock(table)
    for episode in episodes:
        gaps = np.flatnonzero(np.diff(episode.rows) != 1)
        if not len(gaps):
            continue
        t = None if clock is None else clock[episode.rows]
        if t is None or not (np.diff(t) > 0).all():
            at = table.cells.line(int(episode.rows[gaps[0] + 1]))
            raise InputError(
                "the rows of a demonstration together, or in order of time",
                f"{episode.name} again", file=file, row=f"line {at}", field=name,
            )  # fmt: skip


def _refuse_hidden(table: TextTable, file: Path) -> None:
    """InputError where one table looks like several demonstrations.

    It does where a column that is not known otherwise holds one value after the other, each in
    one stretch of rows, and the path leaps wherever it changes; or where the clock starts again.
    """
    clock = _clock(table)
    if clock is not None and len(clock) > 2:
        back = np.flatnonzero((np.diff(clock) < 0) & (clock[1:] <= clock[0]))
        if len(back):
            expected = "a column that tells demonstrations apart, as the clock starts again "
            expected += "(--demonstration NAME, or --demonstration none for one path)"
            row = f"line {table.cells.line(int(back[0]) + 1)}"
            raise InputError(expected, "none", file=file, row=row, field="demonstration")
    steps = _steps(table)
    if steps is None or len(steps) < 4:
        return
    known = {n for names in AUTO.values() for n in names}
    for j, column in enumerate(_columns(table)):
        if column.quantity not in ("other", "index") or column.written.lower() in known:
            continue
        texts = np.array(table.cells.texts(j), dtype=object)
        changes = np.flatnonzero(texts[1:] != texts[:-1])
        if (
            not len(changes)
            or len(changes) + 1 != len(set(texts))
            or 2 * len(changes) >= len(texts)
        ):
            continue
        inside = np.delete(steps, changes)
        if len(inside) and (steps[changes] > 3 * np.quantile(inside, 0.95)).all():
            expected = "a column that is known to tell demonstrations apart "
            expected += f"(--demonstration {column.written}, or --demonstration none for one path)"
            found = f"{column.written} with {len(changes) + 1} values, each in one stretch of rows"
            raise InputError(expected, found, file=file, field="demonstration")


def _steps(table: TextTable) -> FloatArray | None:
    """(n - 1,) lengths of the steps of the path, or None where no columns are its positions."""
    places = [j for j, c in enumerate(_columns(table)) if c.quantity == "position"]
    if len(places) < 2:
        return None
    try:
        points = np.stack([table.cells.numbers(j) for j in places], axis=1)
    except InputError:
        return None  # named when it is read
    with np.errstate(
        over="ignore", invalid="ignore"
    ):  # numbers that are refused where they are read
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.asarray(np.nan_to_num(steps))
