"""CSV and NumPy files: one file a demonstration, or one long table of many."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._csv_file import CsvTable, read_csv
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._numpy_file import TIME_NAMES, load_npy, read_npz
from demospec.demonstrations.readers._recording import (
    Recording,
    Source,
    files_below,
    folders_between,
    path_array,
)
from demospec.demonstrations.readers._values import truth
from demospec.errors import InputError
from demospec.progress import Progress

SUFFIXES = (".csv", ".tsv", ".txt", ".npy", ".npz")
LABELS = ("labels.csv", "metadata.csv", "index.csv")
"""Names of the table of labels that are looked for beside the recordings."""
_LONG = ("demo_id", "demonstration", "demo", "episode", "episode_id", "episode_index",
         "trajectory", "trajectory_id", "traj_id")  # fmt: skip
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
        points = path_array(load_npy(file), file=file, name="points")
        columns = tuple(str(i) for i in range(points.shape[1]))
        return [Recording(name, points, columns, folders=folders, file=file)]
    if file.suffix.lower() == ".npz":
        return [read_npz(file, name, folders, mapping)]
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
    named_time = next((c for c in table.numbers if c.lower() in TIME_NAMES), None)
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
