"""One table of text: where its header is, what its columns are called, its cells as text."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from demospec.demonstrations.readers._column_names import column_name, is_unit
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers.tables._cells import MISSING, TextColumns, as_number
from demospec.demonstrations.readers.tables._text_lines import (
    MAX_COLUMNS,
    Line,
    delimiter_of,
    head_of,
    lines_of,
    read_text,
    split,
)
from demospec.errors import InputError


@dataclass(frozen=True)
class TextTable:
    """A table of text.

    Args:
        names: Names of the columns, each once; ``"0"``, ``"1"``, … where there is no header.
        cells: The columns.
        units: Unit of a column where a line under the header (or the format) states it.
    """

    names: tuple[str, ...]
    cells: TextColumns
    units: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Header:
    """What the first lines say.

    Args:
        names: Names of the columns as written.
        body: Where the first row begins, bytes.
        units: Unit of a column, by place.
        delimiter: What stands between the cells.
    """

    names: list[str]
    body: int
    delimiter: str
    units: dict[int, str] = field(default_factory=dict)


def read_csv(file: Path, mapping: Mapping | None = None) -> TextTable:
    """Reads a table of text with one header line, or none.

    Args:
        file: Comma, semicolon, tab, bar or blanks between the cells; lines that begin with ``#``
            are comments (the last one before the rows is the header where it names x and y).
        mapping: Encoding, lines to skip, the header's line and the decimal mark, where they are
            not to be found.

    Raises:
        InputError: Not text, a line of another length, no line, or a repeated column name.
    """
    how = mapping or Mapping()
    data = read_text(file, how.encoding)
    return table_of(data, find_header(data, how, file), how, file)


def find_header(data: bytes, how: Mapping, file: Path) -> Header:
    """Where the rows begin, and what their columns are called."""
    head = head_of(data, file, how.skip_rows)
    if isinstance(how.header_row, int):
        head = [line for line in head if line.number >= how.header_row]
        if not head or head[0].number != how.header_row:
            found = "a blank line or the end of the file"
            raise InputError(f"a header in line {how.header_row}", found, file=file,
                             field="header_row")  # fmt: skip
        text = head[0].text.lstrip().lstrip("#")
        delimiter = delimiter_of([*head[1:]] or head, file)
        return _with_units(split(text, delimiter), head[0].end, delimiter, head[1:])
    comments = [line for line in head if line.text.lstrip().startswith("#")]
    rows = [line for line in head if not line.text.lstrip().startswith("#")]
    delimiter = delimiter_of(rows, file)
    first = split(rows[0].text, delimiter)
    start = rows[0].end - len(rows[0].text.encode()) - _ending(data, rows[0].end)
    if how.header_row == "none":
        return Header([str(i) for i in range(len(first))], start, delimiter)
    if any(_is_name(cell, delimiter) for cell in first):
        return _with_units(first, rows[0].end, delimiter, rows[1:])
    before = [c for c in comments if c.number < rows[0].number]
    named = _header_in_comment(before, len(first), delimiter)
    if named is not None:
        return Header(named, start, delimiter)
    if _counts(first):
        _refuse_unclear(rows, delimiter, file)
        return Header(first, rows[0].end, delimiter)
    return Header([str(i) for i in range(len(first))], start, delimiter)


def _ending(data: bytes, end: int) -> int:
    """The length of the line break that ends at byte `end`."""
    if data[end - 2 : end] == b"\r\n":
        return 2
    return 1 if data[end - 1 : end] in (b"\r", b"\n") else 0


def _is_name(cell: str, delimiter: str) -> bool:
    missing = cell.lower() in MISSING
    return not missing and as_number(cell, comma=delimiter != ",") is None


def _with_units(names: list[str], body: int, delimiter: str, rest: list[Line]) -> Header:
    """The header, and a second line of units below it where there is one."""
    if rest:
        cells = split(rest[0].text, delimiter)
        said = [c for c in cells if c.strip("()[] -")]
        if len(cells) == len(names) and said and all(is_unit(c) for c in said):
            units = {i: c.strip("()[] ") for i, c in enumerate(cells) if c.strip("()[] -")}
            return Header(names, rest[0].end, delimiter, units)
    return Header(names, body, delimiter)


def _header_in_comment(comments: list[Line], width: int, delimiter: str) -> list[str] | None:
    """The names in the last comment before the rows, where they fit and name x and y."""
    if not comments:
        return None
    text = comments[-1].text.lstrip().lstrip("#").strip()
    for names in (split(text, delimiter), text.split()):
        axes = {c.axis for c in map(column_name, names) if c.quantity == "position"}
        if len(names) == width and {"x", "y"} <= axes:
            return names
    return None


def _counts(cells: list[str]) -> bool:
    """Whether cells read 0, 1, 2, …, perhaps after an empty one: pandas' names of no names."""
    own = cells[1:] if cells and not cells[0] else cells
    return len(own) >= 2 and own == [str(i) for i in range(len(own))]


def _refuse_unclear(rows: list[Line], delimiter: str, file: Path) -> None:
    """InputError where the line ``0,1`` could be the first point of the path as well."""
    cells = [split(line.text, delimiter) for line in rows]
    if not cells[0][0]:
        return  # an unnamed index before the names
    values = [[as_number(c, comma=delimiter != ",") for c in row] for row in cells]
    if any("." in c or "," in c or "e" in c.lower() for row in cells[1:] for c in row):
        return  # the others are written as fractions
    known = [row for row in values[1:] if len(row) == len(values[0]) and None not in row]
    steps = [
        max(abs(float(a or 0) - float(b or 0)) for a, b in zip(p, q, strict=True))
        for p, q in zip([values[0], *known], known, strict=False)
    ]
    if len(steps) >= 3 and steps[0] > 10 * sorted(steps[1:])[len(steps[1:]) // 2]:
        return  # the path would begin with a leap
    raise InputError(
        f"a clear first line: --header-row {rows[0].number} where it names the columns, "
        "--header-row none where it is a point",
        rows[0].text, file=file, row=f"line {rows[0].number}",
    )  # fmt: skip


def table_of(data: bytes, header: Header, how: Mapping, file: Path) -> TextTable:
    """The table below a header."""
    body = _without_comments(data[header.body :])
    first_line = data.count(b"\n", 0, header.body) or data.count(b"\r", 0, header.body)
    line = _line_numbers(body, first_line, file)
    columns = _columns(body, header, line, file)
    names, columns, units = _named(header, columns, file)
    cells = TextColumns(
        columns, names, file=file, comma=header.delimiter != ",", decimal=how.decimal, line=line
    )
    return TextTable(names, cells, units)


def _without_comments(body: bytes) -> bytes:
    if b"#" not in body:
        return body
    return re.sub(rb"(?m)^[ \t]*#[^\r\n]*", b"", body)


def _line_numbers(body: bytes, first_line: int, file: Path) -> Callable[[int], int]:
    """Row → number of its line in the file (blank lines are no rows)."""
    known: list[int] = []

    def line(row: int) -> int:
        if not known:
            known.extend(x.number + first_line for x in lines_of(body, file) if x.text.strip())
        return known[row] if row < len(known) else first_line + row + 1

    return line


def _columns(body: bytes, header: Header, line: Callable[[int], int], file: Path) -> list[Any]:
    """The cells below the header by column, as Arrow arrays of text."""
    import pyarrow as pa
    import pyarrow.csv as pa_csv

    delimiter = header.delimiter
    if delimiter == " ":
        body = re.sub(rb"(?m)^[ \t]+|[ \t]+$", b"", body)
        body, delimiter = re.sub(rb"[ \t]+", b"\t", body), "\t"
    width = len(header.names)
    if width > MAX_COLUMNS:
        raise InputError(f"at most {MAX_COLUMNS} columns", width, file=file)
    wrong: list[tuple[int, int]] = []

    def refuse(row: Any) -> str:
        if row.text.strip():
            wrong.append((row.actual_columns, row.number or 0))
            return "error"
        return "skip"

    def parsed(width: int) -> Any:
        names = [str(i) for i in range(width)]
        return pa_csv.read_csv(
            pa.BufferReader(body),
            read_options=pa_csv.ReadOptions(
                column_names=names, use_threads=False, block_size=max(len(body) + 1, 1 << 16)
            ),
            parse_options=pa_csv.ParseOptions(
                delimiter=delimiter, invalid_row_handler=refuse, newlines_in_values=False
            ),
            convert_options=pa_csv.ConvertOptions(
                column_types=dict.fromkeys(names, pa.string()), strings_can_be_null=False
            ),
        )

    _refuse_open_quotes(body, delimiter, line, file)
    if not body.strip():
        return [pa.array([], pa.string())] * width
    try:
        table = parsed(width)
    except pa.ArrowInvalid as error:
        table = _with_trailing_blank(parsed, width) if wrong and wrong[0][0] == width + 1 else None
        if table is None:
            if wrong:
                row = f"line {line(max(0, wrong[0][1] - 1))}"
                expected = f"{width} cells (lines above the table: --skip-rows N)"
                raise InputError(expected, wrong[0][0], file=file, row=row) from error
            raise InputError("a table of text", str(error), file=file) from error
    columns = [c.combine_chunks() for c in table.columns]
    columns = [pa.concat_arrays(c.chunks) if isinstance(c, pa.ChunkedArray) else c for c in columns]
    return _without_last_blanks(columns)


def _refuse_open_quotes(
    body: bytes, delimiter: str, line: Callable[[int], int], file: Path
) -> None:
    """InputError where a cell goes on after its closing quote (readers differ in what it says)."""
    if b'"' not in body:
        return
    mark = re.escape(delimiter.encode())
    pattern = rb'(?m)(?:^|%s)[ \t]*"(?:[^"\r\n]|"")*"[ \t]*[^%s\s"]' % (mark, mark)
    found = re.search(pattern, body)
    if found is not None:
        above = body[
            : max(body.rfind(b"\n", 0, found.start()), body.rfind(b"\r", 0, found.start()), 0)
        ]
        row = len([x for x in above.splitlines() if x.strip()])
        text = found[0].decode("utf-8").strip(delimiter)
        raise InputError("a cell that ends with its closing quote", text, file=file,
                         row=f"line {line(row)}")  # fmt: skip


def _with_trailing_blank(parsed: Callable[[int], Any], width: int) -> Any:
    """The table where every row ends with one more, empty cell; None where that is not so."""
    import pyarrow as pa
    import pyarrow.compute as pc

    try:
        table = parsed(width + 1)
    except pa.ArrowInvalid:
        return None
    last = table.column(width)
    if pc.any(pc.not_equal(pc.utf8_trim_whitespace(last), "")).as_py():
        return None
    return table.remove_column(width)


def _without_last_blanks(columns: list[Any]) -> list[Any]:
    """Without rows at the end that have only empty cells (as spreadsheets write them)."""
    n = len(columns[0])
    while n and all(not c[n - 1].as_py().strip() for c in columns):
        n -= 1
    return [c.slice(0, n) for c in columns]


def _named(
    header: Header, columns: list[Any], file: Path
) -> tuple[tuple[str, ...], list[Any], dict[str, str]]:
    """Names that are there once each; empty columns without a name are left out."""
    import pyarrow.compute as pc

    names: list[str] = []
    kept: list[Any] = []
    units: dict[str, str] = {}
    for j, (name, column) in enumerate(zip(header.names, columns, strict=True)):
        if not name and not pc.any(pc.not_equal(pc.utf8_trim_whitespace(column), "")).as_py():
            continue
        name = name or ("" if "" not in names else f" {j}")
        if name in names:
            raise InputError("each column name once", f"{name} twice", file=file)
        names.append(name)
        kept.append(column)
        if j in header.units:
            units[name] = header.units[j]
    return tuple(names), kept, units
