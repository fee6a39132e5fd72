"""Pairs of demonstrations, one preferred to the other: ``pairs.parquet``, and the same as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from demospec.demonstrations._table import column_of, opened_parquet, parquet_faults
from demospec.errors import InputError
from demospec.files import read_bytes

PAIRS = "pairs.parquet"


@dataclass(frozen=True)
class Pair:
    """One demonstration preferred to another.

    Args:
        preferred, other: Ids of demonstrations; they may be without a label.
        type: The user type that prefers; None: the type of both demonstrations.
    """

    preferred: str
    other: str
    type: str | None = None


def checked_pairs(
    pairs: Sequence[Pair], type_of: Mapping[str, str | None], types: Sequence[str]
) -> tuple[Pair, ...]:
    """The pairs whose two demonstrations are both there: a part of a set has fewer.

    Args:
        type_of: Demonstration → its user type.
        types: Of the set.

    Raises:
        InputError: One demonstration twice, an unknown type, or none where the types of the two
            demonstrations differ; with the row.
    """
    kept = []
    for row, pair in enumerate(pairs):
        if pair.preferred == pair.other:
            found = f"{pair.other!r} twice"
            raise InputError("two demonstrations that differ", found, row=row, field="pairs.other")
        if pair.type is not None and pair.type not in types:
            expected = f"one of the set's types ({', '.join(types) or 'none'}) or null"
            raise InputError(expected, pair.type, row=row, field="pairs.type")
        if pair.preferred not in type_of or pair.other not in type_of:
            continue
        mine, theirs = type_of[pair.preferred], type_of[pair.other]
        if pair.type is None and mine != theirs:
            expected = "the type that prefers, as those of the two demonstrations differ"
            raise InputError(expected, f"{mine} and {theirs}", row=row, field="pairs.type")
        kept.append(pair)
    return tuple(kept)


def read_pairs(file: Path, known: Container[str]) -> tuple[Pair, ...]:
    """Reads ``pairs.parquet``: ``preferred``, ``other`` and, where it is there, ``type``.

    Args:
        known: Ids of the set's demonstrations.

    Returns:
        The pairs; none where there is no such file.

    Raises:
        InputError: Not Parquet, a column missing or of another type, a null id, or an id that
            the set does not have.
    """
    import pyarrow as pa

    if not file.exists():
        return ()
    text = pa.string()
    with opened_parquet(file) as parquet, parquet_faults(file):
        table = parquet.read()
        columns = {
            name: column_of(table, name, text, file, missing_refused=name != "type").to_pylist()
            for name in ("preferred", "other", "type")
        }
    pairs = []
    for row, (one, two, type_) in enumerate(zip(*columns.values(), strict=True)):
        for field, name in (("preferred", one), ("other", two)):
            if name not in known:
                found = "null" if name is None else name
                expected = "a demonstration of the set"
                raise InputError(expected, found, file=file, row=row, field=field)
        pairs.append(Pair(one, two, type_))
    return tuple(pairs)


def write_pairs(pairs: Sequence[Pair], file: Path) -> None:
    """Writes ``pairs.parquet`` (into a folder that the caller renames into place)."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns: Mapping[str, Any] = {
        "preferred": [p.preferred for p in pairs],
        "other": [p.other for p in pairs],
        "type": [p.type for p in pairs],
    }
    table = pa.table({name: pa.array(values, pa.string()) for name, values in columns.items()})
    pq.write_table(table, file, compression="zstd", write_page_checksum=True)


def read_pair_table(file: Path) -> tuple[Pair, ...]:
    """Pairs of a CSV file with the columns ``preferred``, ``other`` and, perhaps, ``type``.

    Raises:
        InputError: Not text, a column missing or unknown, an empty id; with the row.
    """
    try:
        text = read_bytes(file).decode("utf-8-sig")
        lines = list(csv.reader(io.StringIO(text, newline="")))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError("a CSV file in UTF-8", str(error), file=file) from error
    head = [name.strip() for name in lines[0]] if lines else []
    known = ("preferred", "other", "type")
    if sorted(head) not in (sorted(known), sorted(known[:2])):
        expected = "the columns preferred, other and, perhaps, type"
        raise InputError(expected, ", ".join(head) or "none", file=file)
    pairs = []
    for row, line in enumerate(lines[1:]):
        if not any(cell.strip() for cell in line):
            continue
        if len(line) != len(head):
            raise InputError(f"{len(head)} fields", len(line), file=file, row=row)
        cells = dict(zip(head, (cell.strip() for cell in line), strict=True))
        for field in known[:2]:
            if not cells[field]:
                raise InputError("a demonstration's id", "nothing", file=file, row=row, field=field)
        pairs.append(Pair(cells["preferred"], cells["other"], cells.get("type") or None))
    if not pairs:
        raise InputError("at least one pair", "none", file=file)
    return tuple(pairs)
