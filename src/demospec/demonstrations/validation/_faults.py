"""Every fault of some rows of ``demonstrations.parquet``, where reading stops at the first.

Shares the column types with `_table` and nothing else, so that each tests the other.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.demonstrations._table import column_of, schema
from demospec.demonstrations._trajectory import MAX_COORDINATE, MAX_POINTS, BoolArray, IntArray
from demospec.errors import InputError

if TYPE_CHECKING:
    import pyarrow as pa


def table_faults(
    table: pa.Table, *, file: Path, columns: int, first_row: int
) -> tuple[list[InputError], BoolArray, bool]:
    """The faults of a table, at most one per row and column.

    Returns:
        The faults, ordered by row; which rows have none, shape (rows,); whether the columns are
        there and of the right types (if not, no row is good and one look is enough).
    """
    whole: list[InputError] = []
    data: dict[str, Any] = {}
    for field in schema():
        try:
            data[field.name] = column_of(
                table, field.name, field.type, file, missing_refused=not field.nullable
            )
        except InputError as error:
            whole.append(error)
    if whole:
        return whole, np.zeros(len(table), dtype=bool), False
    found: list[tuple[int, str, str, object]] = []
    for name in ("demo_id", "scene_id"):
        null = data[name].is_null().to_numpy(zero_copy_only=False)
        found += [(int(i), name, "a value", "null") for i in np.flatnonzero(null)]
    found += _path_faults(data["points"], columns)
    found += _time_faults(data["t"], data["points"])
    found += _score_faults(data["score"])
    good = np.ones(len(table), dtype=bool)
    good[[row for row, *_ in found]] = False
    found.sort(key=lambda fault: fault[0])
    faults = [
        InputError(expected, value, file=file, row=first_row + row, field=name)
        for row, name, expected, value in found
    ]
    return faults, good, True


def _score_faults(column: Any) -> list[tuple[int, str, str, object]]:
    """(row, field, expected, found) of scores that are none."""
    numbers = column.to_numpy(zero_copy_only=False).astype(np.float64)
    known = ~column.is_null().to_numpy(zero_copy_only=False)
    wrong = known & ~((numbers >= 0.0) & (numbers <= 1.0))
    return [(int(i), "score", "a score from 0 to 1", numbers[i]) for i in np.flatnonzero(wrong)]


def _path_faults(column: Any, columns: int) -> list[tuple[int, str, str, object]]:
    """(row, field, expected, found) of each path's first fault."""
    faults: dict[int, tuple[str, object]] = {}
    null = column.is_null().to_numpy(zero_copy_only=False)
    for row in np.flatnonzero(null):
        faults[int(row)] = ("a value", "null")
    lengths = _lengths(column)
    for row in np.flatnonzero(~null & (lengths == 0)):
        faults[int(row)] = ("at least one point", "none")
    for row in np.flatnonzero(lengths > MAX_POINTS):
        faults[int(row)] = (
            f"at most {MAX_POINTS} points in one path (thin it out: convert --every N)",
            f"{lengths[row]} points",
        )
    points = column.flatten()  # skips what lies under null rows
    row_of_point = np.repeat(np.arange(len(lengths)), lengths)
    sizes = _lengths(points)
    hole = points.is_null().to_numpy(zero_copy_only=False)
    expected = f"{columns} numbers a point"
    for point in _first_each(np.flatnonzero(hole | (sizes != columns)), row_of_point):
        found: object = "null" if hole[point] else int(sizes[point])
        faults.setdefault(int(row_of_point[point]), (expected, found))
    numbers = points.flatten()
    row_of_number = np.repeat(row_of_point, sizes)
    values = np.asarray(numbers.to_numpy(zero_copy_only=False), dtype=np.float64)  # null → NaN
    missing = numbers.is_null().to_numpy(zero_copy_only=False)
    expected = f"finite numbers of size at most {MAX_COORDINATE:.0e}"
    for at in _first_each(np.flatnonzero(~(np.abs(values) <= MAX_COORDINATE)), row_of_number):
        found = "null" if missing[at] else float(values[at])
        faults.setdefault(int(row_of_number[at]), (expected, found))
    return [(row, "points", expected, found) for row, (expected, found) in faults.items()]


def _time_faults(column: Any, points: Any) -> list[tuple[int, str, str, object]]:
    faults: dict[int, tuple[str, object]] = {}
    given = column.is_valid().to_numpy(zero_copy_only=False)
    lengths, counts = _lengths(column), _lengths(points)
    for row in np.flatnonzero(given & (lengths != counts)):
        faults[int(row)] = (f"{counts[row]} time stamps (one a point)", int(lengths[row]))
    numbers = column.flatten()
    row_of = np.repeat(np.arange(len(lengths)), lengths)
    values = np.asarray(numbers.to_numpy(zero_copy_only=False), dtype=np.float64)
    for at in _first_each(np.flatnonzero(~np.isfinite(values)), row_of):
        faults.setdefault(int(row_of[at]), ("finite seconds", float(values[at])))
    return [(row, "t", expected, found) for row, (expected, found) in faults.items()]


def _lengths(column: Any) -> IntArray:
    """Items of each list, 0 for null; (rows,)."""
    lengths = column.value_lengths().fill_null(0)
    return np.asarray(lengths.to_numpy(zero_copy_only=False), dtype=np.int64)


def _first_each(chosen: IntArray, row_of: IntArray) -> IntArray:
    """Of the chosen places the first of each row."""
    _, first = np.unique(row_of[chosen], return_index=True)
    return chosen[first]
