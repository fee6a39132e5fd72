"""Cells of text as numbers: missing values, decimal commas, dates; never a silent loss."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray

MISSING = frozenset(["", "-", "--", "nan", "na", "n/a", "#n/a", "null", "none"])
"""Cells, in lower case, that stand for a value that is not there."""

_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")
_DOT = re.compile(r"[-+]?(\d+\.\d*|\.\d+)([eE][-+]?\d+)?")


def as_number(cell: str, *, comma: bool) -> float | None:
    """The number in a cell, or None. NaN and infinities are numbers here; they are refused
    (or left out) where the point is used."""
    if comma and _COMMA.fullmatch(cell):
        cell = cell.replace(",", ".")
    if "_" in cell or not cell.isascii():
        return None
    try:
        return float(cell)
    except ValueError:
        return None


class TextColumns:
    """The columns of one file as Arrow arrays of text; numbers are made where they are asked for.

    Args:
        columns: One Arrow array of strings a column.
        names: Their names.
        file: For messages.
        comma: Whether decimal commas may occur (they cannot where commas part the cells).
        decimal: ``.`` or ``,`` where the user said which; None finds it.
        line: Row → number of its line in the file.
    """

    def __init__(
        self,
        columns: list[Any],
        names: tuple[str, ...],
        *,
        file: Path,
        comma: bool,
        decimal: str | None,
        line: Callable[[int], int],
    ) -> None:
        self.columns = columns
        self.names = names
        self.file = file
        self.line = line
        self.decimal_commas = comma if decimal is None else decimal == ","
        self.decimal = decimal
        self._mark: tuple[str, int] | None = None
        self._numbers: dict[int, FloatArray] = {}
        self._seconds: dict[int, FloatArray] = {}
        self._words: dict[int, bool] = {}

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    def texts(self, j: int) -> list[str]:
        """The cells of a column, without the blanks around them."""
        import pyarrow.compute as pc

        return list(pc.utf8_trim_whitespace(self.columns[j]).to_pylist())

    def numbers(self, j: int) -> FloatArray:
        """(n,) numbers, NaN where a cell is missing.

        Raises:
            InputError: A cell that is no number, with its line, column and text.
        """
        if j not in self._numbers:
            self._numbers[j] = self._made(j)
        return self._numbers[j]

    def _made(self, j: int) -> FloatArray:
        import pyarrow as pa
        import pyarrow.compute as pc

        column = pc.utf8_trim_whitespace(self.columns[j])
        mark = self._mark_of(column)
        if mark in ("", ".", ",") and (self._mark is None or mark in ("", self._mark[0])):
            try:
                plain = pc.replace_substring(column, ",", ".") if mark == "," else column
                values = pc.cast(plain, pa.float64()).to_numpy(zero_copy_only=False)
                if mark:
                    self._note_mark(mark, column, j)
                return np.asarray(values, dtype=np.float64)
            except pa.ArrowInvalid:
                pass  # a missing cell or text: one by one, so that the cell can be named
        return np.array([self._number(cell, i, j) for i, cell in enumerate(self.texts(j))])

    def _mark_of(self, column: Any) -> str:
        """The decimal marks that occur in a column: ``""``, ``.``, ``,`` or ``,.``."""
        import pyarrow.compute as pc

        if not self.decimal_commas:
            return ""
        marks = [m for m in ",." if pc.any(pc.match_substring(column, m)).as_py()]
        return "".join(marks)

    def _note_mark(self, mark: str, column: Any, j: int) -> None:
        import pyarrow.compute as pc

        if self._mark is None:
            first = pc.index(pc.match_substring(column, mark), True).as_py()
            self._number(column[first].as_py(), first, j)

    def _number(self, cell: str, i: int, j: int) -> float:
        if cell.lower() in MISSING:
            return np.nan
        value = as_number(cell, comma=self.decimal_commas)
        if value is None:
            raise self._fault(j, i, "a number" + self._hint(cell), cell)
        if self.decimal_commas and self.decimal is None:
            mark = "," if "," in cell else "." if _DOT.fullmatch(cell) else None
            if mark is not None and self._mark is None:
                if mark == "," and not self._has_decimal_commas():
                    expected = "a number of which it is clear whether its comma is a decimal comma "
                    expected += "(--decimal , or --decimal .)"
                    raise self._fault(j, i, expected, cell)
                self._mark = (mark, i)
            if mark is not None and self._mark is not None and mark != self._mark[0]:
                expected = f"one decimal mark (line {self.line(self._mark[1])} has "
                expected += f"{self._mark[0]!r}; --decimal , or --decimal .)"
                raise self._fault(j, i, expected, cell)
        return value

    def _hint(self, cell: str) -> str:
        if cell.isascii() and re.fullmatch(r"[-+]?\d{1,3}([.,' ]\d{3})*([.,]\d+)?", cell):
            return " without thousands separators (decimal commas: --decimal ,)"
        return ""

    def _has_decimal_commas(self) -> bool:
        """Whether a cell of the file has a comma that cannot part thousands."""
        import pyarrow.compute as pc

        surely = r"^\s*[-+]?(0\d*|\d{4,}|),\d+\s*$|^\s*[-+]?\d*,(\d{1,2}|\d{4,})(e[-+]?\d+)?\s*$"
        return any(
            bool(pc.any(pc.match_substring_regex(c, surely, ignore_case=True)).as_py())
            for c in self.columns
        )

    def _fault(self, j: int, i: int, expected: str, cell: str) -> InputError:
        return InputError(
            expected, repr(cell), file=self.file, row=f"line {self.line(i)}", field=self.names[j]
        )

    def seconds(self, j: int) -> FloatArray:
        """(n,) numbers as they stand, or seconds of dates with a time of day (ISO 8601).

        Raises:
            InputError: A cell that is neither.
        """
        if j not in self._seconds:
            texts = self.texts(j)
            first = next((t for t in texts if t.lower() not in MISSING), "")
            if as_number(first, comma=self.decimal_commas) is not None or not first:
                self._seconds[j] = self.numbers(j)
            else:
                self._seconds[j] = np.array([self._date(t, i, j) for i, t in enumerate(texts)])
        return self._seconds[j]

    def _date(self, cell: str, i: int, j: int) -> float:
        if cell.lower() in MISSING:
            return np.nan
        try:
            when = datetime.fromisoformat(cell if "-" in cell else f"1970-01-01T{cell}")
            return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()
        except (ValueError, OverflowError, OSError) as error:
            expected = "a number or a date and time of ISO 8601 (--time none reads no time)"
            raise self._fault(j, i, expected, cell) from error

    def are_words(self, j: int) -> bool:
        """Whether no cell of the column is a number."""
        if j not in self._words:
            self._words[j] = all(
                as_number(t, comma=self.decimal_commas) is None
                for t in dict.fromkeys(self.texts(j))
                if t.lower() not in MISSING
            )
        return self._words[j]


class Rows:
    """Some rows of a file's columns: the `Cells` of one recording."""

    def __init__(self, table: TextColumns, rows: np.ndarray) -> None:
        self.table = table
        self.rows = rows

    def __len__(self) -> int:
        return len(self.rows)

    def numbers(self, j: int) -> FloatArray:
        """Column `j` of these rows as numbers."""
        return np.asarray(self.table.numbers(j)[self.rows])

    def seconds(self, j: int) -> FloatArray:
        """Column `j` of these rows as numbers or seconds."""
        return np.asarray(self.table.seconds(j)[self.rows])

    def are_words(self, j: int) -> bool:
        """Whether no cell of the whole column is a number."""
        return self.table.are_words(j)

    def place(self, j: int, i: int) -> tuple[str, str]:
        """The line of row `i`, and the text in column `j`."""
        row = int(self.rows[i])
        return f"line {self.table.line(row)}", repr(str(self.table.columns[j][row].as_py()))


class RowFields(Mapping[str, np.ndarray]):
    """The fields of one recording in a table of text: name → (n,) words, made when asked for."""

    def __init__(self, table: TextColumns, rows: np.ndarray) -> None:
        self._table = table
        self._rows = rows

    def __iter__(self) -> Iterator[str]:
        return iter(self._table.names)

    def __len__(self) -> int:
        return len(self._table.names)

    def __contains__(self, name: object) -> bool:
        return name in self._table.names

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._table.names:
            raise KeyError(name)
        column = self._table.columns[self._table.names.index(name)]
        return np.array([str(c).strip() for c in column.take(self._rows).to_pylist()], dtype=object)
