"""CSV and NumPy files: one file a demonstration, or one long table of many."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    MAX_NUMBERS,
    Recording,
    Source,
    files_below,
    folders_between,
    numeric,
    path_array,
)
from demospec.demonstrations.readers._values import truth
from demospec.errors import InputError
from demospec.files import read_bytes
from demospec.frames import FloatArray
from demospec.progress import Progress

SUFFIXES = (".csv", ".tsv", ".txt", ".npy", ".npz")
MAX_CSV_BYTES = 1 << 28
"""A CSV file is held in memory as text cells, some thirty times its size."""
LABELS = ("labels.csv", "metadata.csv", "index.csv")
"""Names of the table of labels that are looked for beside the recordings."""
_LONG = ("demo_id", "demonstration", "demo", "episode", "episode_id", "episode_index",
         "trajectory", "trajectory_id", "traj_id")  # fmt: skip
_TIME = ("t", "time", "timestamp", "time_s", "seconds", "stamp", "t_s")
_KEY = ("file", "file_name", "filename", "name", "demo_id", "demonstration", "recording", "path")


def read_tables(path: Path, mapping: Mapping, progress: Progress) -> Source:
    """A folder of CSV and NumPy files, or one such file.

    CSV: a header line, or numbers only (columns ``0``, ``1``, …); comma, semicolon, tab or
    blanks between. NumPy: ``.npy`` with one row a point, ``.npz`` with such an array (named in
    the mapping as `path`, else ``points``, else the only one of that shape) and further arrays
    as fields.
    """
    source = Source("tables", name=path.stem)
    root = path if path.is_dir() else path.parent
    files = [path] if path.is_file() else list(files_below(path, SUFFIXES))
    labels_file = _labels_file(root, path, mapping)
    files = [f for f in files if labels_file is None or f != labels_file]
    for i, file in enumerate(files):
        source.recordings += _read_file(file, root, mapping)
        progress("read", i + 1, len(files))
    source.notes.append(f"read: {len(source.recordings)} recordings from {len(files)} files")
    if labels_file is not None:
        _add_labels(source, labels_file, root)
    _shorten_names(source)
    return source


def _labels_file(root: Path, path: Path, mapping: Mapping) -> Path | None:
    if mapping.labels is not None:
        return root / mapping.labels
    if path.is_file():
        return None
    return next((root / name for name in LABELS if (root / name).is_file()), None)


def _read_file(file: Path, root: Path, mapping: Mapping) -> list[Recording]:
    name = file.relative_to(root).with_suffix("").as_posix()
    folders = folders_between(root, file)
    if file.suffix.lower() == ".npy":
        points = path_array(_load_npy(file), file=file, name="points")
        columns = tuple(str(i) for i in range(points.shape[1]))
        return [Recording(name, points, columns, folders=folders, file=file)]
    if file.suffix.lower() == ".npz":
        return [_read_npz(file, name, folders, mapping)]
    table = read_csv(file)
    parts = _split_long(table, mapping, file)
    if parts is None:
        return [_recording(table, name, folders, file, None, mapping)]
    return [
        _recording(part, key, folders, file, f"demonstration {key}", mapping) for key, part in parts
    ]


def _recording(
    table: CsvTable, name: str, folders: tuple[str, ...], file: Path, row: str | None,
    mapping: Mapping,
) -> Recording:  # fmt: skip
    named_time = next((c for c in table.numbers if c.lower() in _TIME), None)
    columns = [c for c in table.numbers if c != named_time or mapping.time is not None]
    if not columns:
        raise InputError("columns of numbers", "none", file=file)
    points = np.stack([table.numbers[c] for c in columns], axis=1)
    if not len(points):
        raise InputError("at least one point", "none", file=file, row=row)
    fields: dict[str, Any] = {**table.numbers, **table.words}
    t = None if named_time is None or mapping.time is not None else table.numbers[named_time]
    if t is not None and np.isnan(t).all():
        t = None
    return Recording(
        name, points, tuple(columns), t=t, fields=fields, folders=folders, file=file, row=row
    )


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


def _split_long(table: CsvTable, mapping: Mapping, file: Path) -> list[tuple[str, CsvTable]] | None:
    """A long table by demonstration, or None where it holds one."""
    name = mapping.demonstration
    every = [*table.numbers, *table.words]
    if name is None:
        name = next((c for c in every if c.lower() in _LONG), None)
        if name is None:
            return None
    elif name not in every:
        raise InputError(f"a column {name}", ", ".join(every), file=file, field="demonstration")
    if name in table.numbers:
        keys = [f"{v:g}" if np.isfinite(v) else "" for v in table.numbers[name]]
    else:
        keys = [str(v) for v in table.words[name]]
    if "" in keys:
        raise InputError("a name", "an empty cell", file=file, row=keys.index(""), field=name)
    rows: dict[str, list[int]] = {}
    for i, key in enumerate(keys):
        rows.setdefault(key, []).append(i)
    return [(key, table.rows(np.array(places))) for key, places in rows.items()]


def _add_labels(source: Source, file: Path, root: Path) -> None:
    """Adds the fields of a table of labels to the recordings it names."""
    table = read_csv(file)
    every: dict[str, np.ndarray] = {**table.words, **table.numbers}
    order = [c for c in every if c.lower() in _KEY]
    if not order:
        expected = f"a column that names the recording ({', '.join(_KEY)})"
        raise InputError(expected, ", ".join(every) or "none", file=file)
    key = order[0]
    rows = {_plain_name(str(v)): i for i, v in enumerate(every[key])}
    missing = 0
    recordings = []
    for recording in source.recordings:
        names = [recording.name, recording.name.rsplit("/", 1)[-1]]
        row = next((rows[n] for n in names if n in rows), None)
        missing += row is None
        extra = {} if row is None else {c: every[c][row] for c in every if c != key}
        none = {c: None for c in every if c != key} if row is None else {}
        recordings.append(
            Recording(
                recording.name, recording.points, recording.columns, recording.t,
                {**recording.fields, **none, **extra}, recording.folders, recording.scene,
                recording.file, recording.row,
            )
        )  # fmt: skip
    source.recordings = recordings
    word = f", {missing} recordings not in it" if missing else ""
    source.notes.append(f"labels: {file.relative_to(root)}{word}")


def _plain_name(name: str) -> str:
    return re.sub(r"\.(csv|tsv|txt|npy|npz)$", "", name.replace("\\", "/"), flags=re.IGNORECASE)


def _shorten_names(source: Source) -> None:
    """Without the folders where the last part of every name is unique."""
    short = [r.name.rsplit("/", 1)[-1] for r in source.recordings]
    if len(set(short)) == len(short):
        source.recordings = [
            Recording(s, r.points, r.columns, r.t, r.fields, r.folders, r.scene, r.file, r.row)
            for s, r in zip(short, source.recordings, strict=True)
        ]


def _load_npy(file: Path) -> np.ndarray:
    data = io.BytesIO(read_bytes(file))
    return _load_array(data, file)


def _load_array(data: io.BytesIO, file: Path) -> np.ndarray:
    """One ``.npy`` array; its header is judged before anything is allocated, pickles refused."""
    try:
        version = np.lib.format.read_magic(data)
        reader = (
            np.lib.format.read_array_header_1_0
            if version == (1, 0)
            else np.lib.format.read_array_header_2_0
        )
        shape, _, dtype = reader(data)
    except Exception as error:
        # NumPy parses the header as Python text and lets whatever the tokenizer raises through.
        raise InputError("a NumPy file", str(error), file=file) from error
    if dtype.hasobject:
        raise InputError(
            "an array of numbers", "an object array (a pickle), which is never loaded", file=file
        )
    count = 1
    for n in shape:
        count *= int(n)
    if count > MAX_NUMBERS:
        raise InputError(f"at most {MAX_NUMBERS} numbers", f"shape {shape}", file=file)
    if count * dtype.itemsize > len(data.getbuffer()) - data.tell():
        found = f"fewer than shape {shape} needs"
        raise InputError("all of the array's bytes", found, file=file)
    data.seek(0)
    try:
        return np.asarray(np.load(data, allow_pickle=False))
    except (ValueError, OSError, EOFError, MemoryError) as error:
        raise InputError("a NumPy file", str(error), file=file) from error


def _read_npz(file: Path, name: str, folders: tuple[str, ...], mapping: Mapping) -> Recording:
    arrays: dict[str, np.ndarray] = {}
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(file))) as archive:
            for item in archive.infolist():
                if item.file_size > 8 * MAX_NUMBERS:
                    expected = f"at most {8 * MAX_NUMBERS} bytes in an array"
                    raise InputError(expected, item.file_size, file=file, field=item.filename)
                data = io.BytesIO(archive.read(item))
                arrays[item.filename.removesuffix(".npy")] = _load_array(data, file)
    except (zipfile.BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError, ValueError,
            MemoryError) as error:  # fmt: skip
        raise InputError("a NumPy archive (.npz)", str(error), file=file) from error
    key = _path_key(arrays, mapping, file)
    points = path_array(arrays[key], file=file, name=key)
    fields: dict[str, Any] = {}
    t = None
    for other, array in arrays.items():
        if other == key:
            continue
        if array.ndim == 0:
            fields[other] = array.item()
        elif array.ndim == 1 and len(array) == len(points) and array.dtype.kind in "biuf":
            fields[other] = numeric(array, file=file, name=other)
            if other.lower() in _TIME and t is None:
                t = array.astype(np.float64)
        elif array.size == 1:
            fields[other] = array.reshape(-1)[0].item()
    columns = tuple(str(i) for i in range(points.shape[1]))
    return Recording(name, points, columns, t=t, fields=fields, folders=folders, file=file)


def _path_key(arrays: dict[str, np.ndarray], mapping: Mapping, file: Path) -> str:
    if mapping.path is not None:
        if mapping.path not in arrays:
            known = ", ".join(arrays) or "none"
            raise InputError(f"an array {mapping.path}", known, file=file, field="path")
        return mapping.path
    if "points" in arrays:
        return "points"
    flat = [k for k, a in arrays.items() if a.ndim == 2 and a.shape[1] in (2, 3)]
    if len(flat) != 1:
        expected = "one array of points; say which: --path NAME"
        raise InputError(expected, ", ".join(arrays) or "none", file=file, field="path")
    return flat[0]


def read_label_table(file: Path) -> dict[str, dict[str, Any]]:
    """A CSV with a column of names and any of ``valid``, ``type``, ``demonstrator``.

    Returns:
        Demonstration → the values given for it (an empty cell of ``valid`` means no label).
    """
    table = read_csv(file)
    every: dict[str, np.ndarray] = {**table.words, **table.numbers}
    key = next((c for c in every if c.lower() in _KEY), None)
    wanted = [c for c in ("valid", "type", "demonstrator") if c in every]
    if key is None or not wanted:
        expected = "columns demo_id and valid, type or demonstrator"
        raise InputError(expected, ", ".join(every) or "none", file=file)
    out: dict[str, dict[str, Any]] = {}
    for row, name in enumerate(every[key]):
        text = f"{name:g}" if isinstance(name, float) else str(name)
        values: dict[str, Any] = {}
        for column in wanted:
            cell = every[column][row]
            if column == "valid":
                found = truth(cell, {})
                if found is not None and not isinstance(found, bool):
                    raise InputError("a truth value", cell, file=file, row=row, field="valid")
                values[column] = found
            else:
                values[column] = str(cell) or None
        out[text] = values
    return out
