"""The lines of a text file: its encoding, its first lines, its delimiter."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from demospec.demonstrations.readers.tables._cells import as_number
from demospec.errors import InputError
from demospec.files import read_bytes

MAX_BYTES = 1 << 28
"""A table of text is held in memory, with its cells about three times its size."""

MAX_COLUMNS = 10_000
"""More columns are taken for a broken or hostile file."""

MAX_LINE = 1 << 20
"""Bytes of a line at the beginning; a longer one is taken for a broken or hostile file."""

HEAD_LINES = 24
"""Lines at the beginning that say how the rest is written."""

DELIMITERS = (";", "\t", "|", ",")


@dataclass(frozen=True)
class Line:
    """One line: its number in the file (from 1), its text, where the next one begins (bytes)."""

    number: int
    text: str
    end: int

    @property
    def blank(self) -> bool:
        return not self.text.strip(" \t;,|")


def read_text(file: Path, encoding: str | None) -> bytes:
    """The bytes of a text file as UTF-8 without a byte order mark.

    Args:
        file: The file.
        encoding: Its encoding; None finds UTF-8 and UTF-16.

    Raises:
        InputError: Not text in that encoding, or an encoding that nobody knows.
    """
    data = read_bytes(file, limit_bytes=MAX_BYTES)
    name = encoding or _encoding(data)
    if name == "utf-8" and not data.startswith(codecs.BOM_UTF8):
        text = data
    else:
        try:
            decoded = data.decode(name)
        except UnicodeDecodeError as error:
            found = f"byte {data[error.start]:#04x} at offset {error.start}"
            raise InputError(f"text in {name}", found, file=file) from error
        except (LookupError, ValueError) as error:
            raise InputError("an encoding that Python knows", name, field="encoding") from error
        if not isinstance(decoded, str):
            raise InputError("an encoding of text", name, field="encoding")
        text = decoded.removeprefix("\ufeff").encode("utf-8", errors="surrogatepass")
    if b"\0" in text:
        raise InputError("text", "a NUL character", file=file)
    try:
        text.decode("utf-8")
    except UnicodeDecodeError as error:
        found = f"byte {text[error.start]:#04x} at offset {error.start}"
        expected = "UTF-8 text (another encoding: --encoding latin-1)"
        raise InputError(expected, found, file=file) from error
    return text


def _encoding(data: bytes) -> str:
    """UTF-8, or UTF-16 by its byte order mark or by where the NUL bytes of its first 4 KB are."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    head = data[:4096]
    if len(head) >= 4 and 3 * head[1::2].count(0) > len(head) and not head[::2].count(0):
        return "utf-16-le"
    if len(head) >= 4 and 3 * head[::2].count(0) > len(head) and not head[1::2].count(0):
        return "utf-16-be"
    return "utf-8"


def lines_of(data: bytes, file: Path) -> Iterator[Line]:
    """The lines of UTF-8 text, one after the other.

    Raises:
        InputError: A line of more than `MAX_LINE` bytes.
    """
    start, number = 0, 0
    ends = re.finditer(rb"\r\n|\r|\n", data)
    while start < len(data):
        match = next(ends, None)
        stop, end = (len(data), len(data)) if match is None else match.span()
        number += 1
        if stop - start > MAX_LINE:
            found = f"{stop - start} bytes"
            raise InputError(f"lines of at most {MAX_LINE} bytes", found, file=file,
                             row=f"line {number}")  # fmt: skip
        yield Line(number, data[start:stop].decode("utf-8"), end)
        start = end


def head_of(data: bytes, file: Path, first: int = 0) -> list[Line]:
    """The first lines that are not blank, from line number `first` + 1 on; comments included.

    Raises:
        InputError: A line of more than `MAX_LINE` bytes.
    """
    out: list[Line] = []
    for line in lines_of(data, file):
        if line.number > first and not line.blank:
            out.append(line)
            if len(out) >= HEAD_LINES:
                break
    return out


def split(text: str, delimiter: str) -> list[str]:
    """The cells of one line."""
    if delimiter == " ":
        return text.split()
    try:
        row = next(csv.reader([text], delimiter=delimiter), [])
    except csv.Error:
        row = text.split(delimiter)
    return [cell.strip() for cell in row]


def delimiter_of(lines: list[Line], file: Path) -> str:
    """What stands between the cells: what splits most lines alike and into most numbers."""
    sample = [line.text for line in lines if not line.text.lstrip().startswith("#")][:20]
    if not sample:
        raise InputError("at least one line", "none", file=file)
    widest = max(max(text.count(d) for d in DELIMITERS) for text in sample)
    if widest >= MAX_COLUMNS:
        raise InputError(f"at most {MAX_COLUMNS} columns", widest + 1, file=file)
    best, best_score = ",", (0.0, 0.0)
    for delimiter in (*DELIMITERS, " "):
        rows = [split(text, delimiter) for text in sample]
        widths = [len(row) for row in rows]
        usual = max(set(widths), key=widths.count)
        if usual < 2:
            continue
        cells = [c for row in rows if len(row) == usual for c in row if c]
        numbers = sum(as_number(c, comma=delimiter != ",") is not None for c in cells)
        score = (widths.count(usual) / len(rows), numbers / max(1, len(cells)))
        if score > best_score:
            best, best_score = delimiter, score
    return best
