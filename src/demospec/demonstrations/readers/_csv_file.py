"""CSV in its dialects: columns of numbers, columns of words."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from demospec.errors import InputError
from demospec.files import read_bytes
from demospec.frames import FloatArray

MAX_CSV_BYTES = 1 << 28
"""A CSV file is held in memory as text cells, some thirty times its size."""


class CsvTable:
    """Columns of a CSV file: those of numbers, and those of words; (rows,) each."""

    def __init__(self, numbers: dict[str, FloatArray], words: dict[str, np.ndarray]) -> None:
        self.numbers = numbers
        self.words = words

    def rows(self, chosen: np.ndarray) -> CsvTable:
        """Some rows of every column."""
        return CsvTable(
            {k: v[chosen] for k, v in self.numbers.items()},
            {k: v[chosen] for k, v in self.words.items()},
        )


def read_csv(file: Path) -> CsvTable:
    """Reads a CSV file; an empty cell of a column of numbers becomes NaN.

    Raises:
        InputError: Not UTF-8, a line of another length, no line, or a repeated column name.
    """
    data = read_bytes(file, limit_bytes=MAX_CSV_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        found = f"byte {data[error.start]:#04x} at offset {error.start}"
        raise InputError("UTF-8 text", found, file=file) from error
    if "\x00" in text:
        raise InputError("text", "a NUL character", file=file)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if not lines:
        raise InputError("at least one line", "none", file=file)
    delimiter = _delimiter(lines[0])
    try:
        rows = (
            [line.split() for line in lines]
            if delimiter == " "
            else [[c.strip() for c in row] for row in csv.reader(lines, delimiter=delimiter)]
        )
    except csv.Error as error:
        raise InputError("a CSV file", str(error), file=file) from error
    comma = delimiter != ","
    header = [str(i) for i in range(len(rows[0]))]
    first = 0
    if any(_number(cell, comma) is None for cell in rows[0] if cell):
        header, first = rows[0], 1
    for name in header:
        if header.count(name) > 1:
            raise InputError("each column name once", f"{name} twice", file=file, row=0)
    for i, row in enumerate(rows):
        if len(row) != len(header):
            raise InputError(f"{len(header)} cells", len(row), file=file, row=i)
    return _typed(header, rows[first:], comma)


def _typed(header: list[str], rows: list[list[str]], comma: bool) -> CsvTable:
    numbers: dict[str, FloatArray] = {}
    words: dict[str, np.ndarray] = {}
    for j, name in enumerate(header):
        cells = [row[j] for row in rows]
        values = [_number(cell, comma) if cell else np.nan for cell in cells]
        if all(v is not None for v in values) and any(cell for cell in cells):
            numbers[name] = np.array(values, dtype=np.float64)
        else:
            words[name] = np.array(cells, dtype=object)
    return CsvTable(numbers, words)


def _delimiter(line: str) -> str:
    counts = {d: line.count(d) for d in (";", "\t", ",")}
    best = max(counts, key=lambda d: counts[d])
    if counts[best]:
        return ";" if counts[";"] else best  # with semicolons, commas are decimal points
    return " " if len(line.split()) > 1 else ","


def _number(cell: str, comma: bool) -> float | None:
    """The number in a cell, or None. NaN and infinities are numbers here; they are refused
    (or left out) where the point is used."""
    if comma and re.fullmatch(r"[-+]?\d*,\d+([eE][-+]?\d+)?", cell):
        cell = cell.replace(",", ".")
    try:
        return float(cell) if "_" not in cell else None
    except ValueError:
        return None
