"""demonstrations.parquet ↔ `Demonstrations`, column by column without a loop over points."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations._migrate import FORMAT_VERSION, migrate_table
from demospec.demonstrations._trajectory import (
    MAX_COORDINATE,
    MAX_POINTS,
    BoolArray,
    Demonstrations,
)
from demospec.errors import InputError
from demospec.frames import FloatArray

if TYPE_CHECKING:
    import pyarrow as pa


def schema() -> pa.Schema:
    """The columns of ``demonstrations.parquet``."""
    import pyarrow as pa

    return pa.schema(
        [
            pa.field("demo_id", pa.string(), nullable=False),
            pa.field("scene_id", pa.string(), nullable=False),
            pa.field("type", pa.string()),
            pa.field("demonstrator", pa.string()),
            pa.field("valid", pa.bool_()),
            pa.field("points", pa.list_(pa.list_(pa.float64())), nullable=False),
            pa.field("t", pa.list_(pa.float64())),
            pa.field("score", pa.float64()),
        ]
    )


def read_table(file: Path, *, columns: int, version: int = FORMAT_VERSION) -> Demonstrations:
    """Reads ``demonstrations.parquet``; every point has `columns` numbers.

    Raises:
        InputError: Not Parquet, a column missing or of another type, a null where none may be,
            ragged points, a number that is not finite or too large.
    """
    with opened_parquet(file) as parquet, parquet_faults(file):
        table = parquet.read(columns=wanted_columns(parquet))
    return from_arrow(migrate_table(table, version), file=file, columns=columns)


@contextmanager
def opened_parquet(file: Path) -> Iterator[Any]:
    """A `pyarrow.parquet.ParquetFile` that is read in pieces; InputError where it is none."""
    import pyarrow.parquet as pq

    if not file.is_file():
        found = "no such file" if not file.exists() else "a folder or device"
        raise InputError("a Parquet file", found, file=file)
    with parquet_faults(file):
        # Without a buffer size, one row group's compressed columns are held at once.
        # Checksums are verified where the writer left some, as `write_table` does.
        parquet = pq.ParquetFile(
            file, buffer_size=1 << 20, pre_buffer=False, page_checksum_verification=True
        )
    try:
        yield parquet
    finally:
        parquet.close()


def wanted_columns(parquet: Any) -> list[str]:
    """The columns of the format that a file has (of any version); others are not read."""
    names = [field.name for field in schema()] + ["success"]
    return [name for name in parquet.schema_arrow.names if name in names]


@contextmanager
def parquet_faults(file: Path) -> Iterator[None]:
    """Turns what Arrow raises on a broken file into one line."""
    import pyarrow as pa

    try:
        yield
    except (pa.ArrowException, OSError, MemoryError, OverflowError, UnicodeError) as error:
        found = str(error).split("\n")[0] or type(error).__name__
        raise InputError("a Parquet file", found, file=file) from error


def from_arrow(table: pa.Table, *, file: Path, columns: int, first_row: int = 0) -> Demonstrations:
    """The demonstrations of an Arrow table (a whole file or one batch of it)."""
    import pyarrow as pa

    text = pa.string()
    demo_id = _column(table, "demo_id", text, file, required=True, first_row=first_row)
    scene_id = _column(table, "scene_id", text, file, required=True, first_row=first_row)
    type_ = _column(table, "type", text, file, first_row=first_row)
    demonstrator = _column(table, "demonstrator", text, file, first_row=first_row)
    valid = _column(table, "valid", pa.bool_(), file, first_row=first_row)
    nested = pa.list_(pa.list_(pa.float64()))
    points = _column(table, "points", nested, file, required=True, first_row=first_row)
    flat, offsets = _points(points, columns, file, first_row)
    stamps = _column(table, "t", pa.list_(pa.float64()), file, first_row=first_row)
    score = _scores(_column(table, "score", pa.float64(), file, first_row=first_row), file,
                    first_row)  # fmt: skip
    verdict = np.where(given(valid), to_numpy(valid), -1).astype(np.int8)
    if score is not None:
        cut = np.where(np.isnan(score), -1, score >= 0.5).astype(np.int8)
        verdict = np.where(verdict < 0, cut, verdict).astype(np.int8)
    return Demonstrations(
        demo_id=_text(demo_id, "demo_id", file),
        scene_id=_text(scene_id, "scene_id", file),
        type=_text(type_, "type", file),
        demonstrator=_text(demonstrator, "demonstrator", file),
        valid=verdict,
        flat=flat,
        offsets=offsets,
        t=_times(stamps, offsets, file, first_row),
        score=score,
    )


def _scores(column: Any, file: Path, first_row: int) -> FloatArray | None:
    """(n,) with NaN for null; None where all are null."""
    known = given(column)
    if not known.any():
        return None
    numbers = np.where(known, to_numpy(column), np.nan).astype(np.float64)
    wrong = known & ~((numbers >= 0.0) & (numbers <= 1.0))
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        raise InputError(
            "a score from 0 to 1", numbers[row], file=file, row=first_row + row, field="score"
        )
    return numbers


def _column(
    table: pa.Table,
    name: str,
    kind: pa.DataType,
    file: Path,
    *,
    required: bool = False,
    first_row: int = 0,
) -> Any:
    column = column_of(table, name, kind, file, missing_refused=required)
    if required and column.null_count:
        row = int(np.flatnonzero(~given(column))[0])
        raise InputError("a value", "null", file=file, row=first_row + row, field=name)
    return column


def column_of(
    table: pa.Table, name: str, kind: pa.DataType, file: Path, *, missing_refused: bool = False
) -> Any:
    """One column as one Arrow array of type `kind`; all null where it is missing and may be.

    Raises:
        InputError: Missing where it may not be, there twice, or of another type.
    """
    import pyarrow as pa

    if table.column_names.count(name) > 1:
        raise InputError("one column of that name", "several", file=file, field=name)
    if name not in table.column_names:
        if missing_refused:
            found = f"columns {', '.join(table.column_names) or 'none'}"
            raise InputError(f"a column {name}", found, file=file, field=name)
        return pa.nulls(len(table), kind)
    try:
        column = table[name].combine_chunks()
        if isinstance(column, pa.ChunkedArray):
            column = pa.concat_arrays(column.chunks) if column.chunks else pa.nulls(0, kind)
        if column.type != kind:
            if pa.types.is_boolean(kind) and not pa.types.is_null(column.type):
                raise pa.ArrowInvalid("not boolean")
            text = pa.types.is_string(kind) and not pa.types.is_null(column.type)
            if text and not _is_text(column.type):
                raise pa.ArrowInvalid("not text")
            column = column.cast(kind)
    except (pa.ArrowException, ValueError, TypeError, MemoryError) as error:
        raise InputError(str(kind), str(table[name].type), file=file, field=name) from error
    return column


def _is_text(kind: pa.DataType) -> bool:
    import pyarrow as pa

    t = pa.types
    if t.is_dictionary(kind):
        kind = kind.value_type
    return bool(t.is_string(kind) or t.is_large_string(kind) or t.is_string_view(kind))


def _text(column: Any, name: str, file: Path) -> np.ndarray:
    out = np.empty(len(column), dtype=object)
    try:
        out[:] = column.to_pylist()
    except UnicodeDecodeError as error:  # Parquet does not check what its writer called text
        raise InputError("UTF-8 text", "other bytes", file=file, field=name) from error
    return out


def to_numpy(array: Any) -> NDArray[Any]:
    """A flat Arrow array of numbers or truth values; where one is null, any value.

    Arrow's own ``to_numpy`` imports pandas wherever that is installed, which takes a quarter
    of a second, and its own ``is_null`` and ``cast`` bring `pyarrow.compute`, a twentieth;
    this and `given` read the array's memory.
    """
    import pyarrow as pa

    memory = array.buffers()[1]
    if pa.types.is_boolean(array.type):
        return _bits(memory, array)
    kind = np.dtype(array.type.to_pandas_dtype())
    if len(array) == 0:
        return np.empty(0, dtype=kind)
    return np.frombuffer(memory, kind, len(array), array.offset * kind.itemsize)


def given(array: Any) -> BoolArray:
    """Which entries of an Arrow array are not null."""
    validity = array.buffers()[0]
    if validity is None:
        return np.ones(len(array), dtype=bool)
    return _bits(validity, array)


def _bits(memory: Any, array: Any) -> BoolArray:
    if len(array) == 0:
        return np.empty(0, dtype=bool)
    first = array.offset // 8
    skipped = array.offset - 8 * first
    packed = np.frombuffer(memory, np.uint8, offset=first)
    bits = np.unpackbits(packed, count=skipped + len(array), bitorder="little")
    return bits[skipped:].view(bool)


def _points(column: Any, columns: int, file: Path, first_row: int) -> tuple[FloatArray, np.ndarray]:
    raw = to_numpy(column.offsets)
    inner = column.values.slice(raw[0], raw[-1] - raw[0]) if len(raw) else column.values
    offsets = (raw - raw[0]).astype(np.int64) if len(raw) else np.zeros(1, np.int64)

    def row_of(point: int) -> int:
        return first_row + int(np.searchsorted(offsets, point, side="right")) - 1

    lengths = np.diff(offsets)
    if (lengths == 0).any():
        row = first_row + int(np.flatnonzero(lengths == 0)[0])
        raise InputError("at least one point", "none", file=file, row=row, field="points")
    if (lengths > MAX_POINTS).any():
        row = int(np.flatnonzero(lengths > MAX_POINTS)[0])
        expected = f"at most {MAX_POINTS} points in one path (thin it out: convert --every N)"
        found = f"{lengths[row]} points"
        raise InputError(expected, found, file=file, row=first_row + row, field="points")
    if inner.null_count:
        point = int(np.flatnonzero(~given(inner))[0])
        raise InputError("numbers", "null", file=file, row=row_of(point), field="points")
    ends = to_numpy(inner.offsets)
    sizes = np.diff(ends)
    if (sizes != columns).any():
        point = int(np.flatnonzero(sizes != columns)[0])
        expected = f"{columns} numbers a point"
        raise InputError(expected, int(sizes[point]), file=file, row=row_of(point), field="points")
    numbers = inner.values.slice(ends[0], ends[-1] - ends[0]) if len(ends) else inner.values
    if numbers.null_count:
        at = int(np.flatnonzero(~given(numbers))[0])
        raise InputError("numbers", "null", file=file, row=row_of(at // columns), field="points")
    flat = to_numpy(numbers).reshape(-1, columns)
    wrong = ~(np.abs(flat) <= MAX_COORDINATE)
    if wrong.any():
        point, axis = np.argwhere(wrong)[0]
        expected = f"finite numbers of size at most {MAX_COORDINATE:.0e}"
        row = row_of(int(point))
        found = f"{flat[point, axis]} in point {int(point) - int(offsets[row - first_row])}"
        raise InputError(expected, found, file=file, row=row, field="points")
    return flat, offsets


def _times(column: Any, offsets: np.ndarray, file: Path, first_row: int) -> FloatArray | None:
    if column.null_count == len(column):
        return None
    raw = to_numpy(column.offsets).astype(np.int64)
    stamped = given(column)
    lengths, counts = np.diff(raw), np.diff(offsets)
    wrong = stamped & (lengths != counts)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        expected = f"{counts[i]} time stamps (one a point)"
        raise InputError(expected, int(lengths[i]), file=file, row=first_row + i, field="t")
    # The stamps of the given rows lie one after the other; null rows may leave gaps.
    lengths = np.where(stamped, lengths, 0)
    ends = np.cumsum(lengths)
    take = np.repeat(raw[:-1] - (ends - lengths), lengths) + np.arange(int(ends[-1]))
    known = given(column.values)[take]
    if not known.all():
        at = int(np.flatnonzero(~known)[0])
        row = first_row + int(np.searchsorted(ends, at, side="right"))
        raise InputError("numbers", "null", file=file, row=row, field="t")
    numbers = to_numpy(column.values)[take]
    if not np.isfinite(numbers).all():
        at = int(np.flatnonzero(~np.isfinite(numbers))[0])
        row = first_row + int(np.searchsorted(ends, at, side="right"))
        raise InputError("finite seconds", numbers[at], file=file, row=row, field="t")
    out = np.full(int(offsets[-1]), np.nan)
    out[np.repeat(stamped, counts)] = numbers
    return out


def to_arrow(data: Demonstrations) -> pa.Table:
    """The Arrow table of some demonstrations."""
    import pyarrow as pa

    count, columns = data.flat.shape
    inner = pa.ListArray.from_arrays(
        pa.array(np.arange(count + 1) * columns, pa.int32()),
        pa.array(np.ascontiguousarray(data.flat).ravel(), pa.float64()),
    )
    points = pa.ListArray.from_arrays(pa.array(data.offsets, pa.int32()), inner)
    stamps: Any = pa.nulls(len(data), pa.list_(pa.float64()))
    if data.t is not None:
        starts = data.offsets[:-1]
        missing = np.isnan(data.t[starts])
        ends = pa.array(data.offsets, pa.int32(), mask=np.append(missing, False))
        stamps = pa.ListArray.from_arrays(ends, pa.array(data.t, pa.float64()))
        if missing.any():
            rows = [None if m else data.t[a:b].tolist() for m, a, b in
                    zip(missing, data.offsets[:-1], data.offsets[1:], strict=True)]  # fmt: skip
            stamps = pa.array(rows, pa.list_(pa.float64()))
    valid = pa.array(data.valid == 1, pa.bool_(), mask=data.valid < 0)
    return pa.Table.from_arrays(
        [
            pa.array(data.demo_id, pa.string()),
            pa.array(data.scene_id, pa.string()),
            pa.array(data.type, pa.string()),
            pa.array(data.demonstrator, pa.string()),
            valid,
            points,
            stamps,
            *([] if data.score is None else [pa.array(data.score, mask=np.isnan(data.score))]),
        ],
        schema=schema() if data.score is not None else schema().remove(7),
    )


ROW_GROUP_POINTS = 2_000_000
"""Points in one row group: a reader that streams holds one group at a time."""


def write_table(data: Demonstrations, file: Path) -> None:
    """Writes ``demonstrations.parquet`` (into a folder that the caller renames into place)."""
    import pyarrow.parquet as pq

    rows = int(len(data) * ROW_GROUP_POINTS / max(1, len(data.flat)))
    # Coordinates of drawn or recorded paths hardly repeat: dictionaries cost time for nothing.
    text = ["scene_id", "type", "demonstrator"]
    pq.write_table(
        to_arrow(data),
        file,
        compression="zstd",
        row_group_size=min(max(rows, 1), 65_536),
        use_dictionary=text,
        write_page_checksum=True,
    )
