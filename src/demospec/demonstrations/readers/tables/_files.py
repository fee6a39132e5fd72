"""CSV and NumPy files: one file a demonstration, or one long table of many."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    Recording,
    Source,
    folders_between,
    path_array,
    shorten_names,
    wanted_files,
)
from demospec.demonstrations.readers.tables._cells import RowFields, Rows
from demospec.demonstrations.readers.tables._episodes import Episode, episodes_of
from demospec.demonstrations.readers.tables._layouts import layout_of
from demospec.demonstrations.readers.tables._numpy_file import load_npy, read_npz
from demospec.demonstrations.readers.tables._text_lines import read_text
from demospec.demonstrations.readers.tables._text_table import (
    TextTable,
    find_header,
    table_of,
)
from demospec.errors import InputError
from demospec.progress import Progress

SUFFIXES = (".csv", ".tsv", ".txt", ".npy", ".npz")


def read_tables(
    path: Path, mapping: Mapping, progress: Progress, left_out: tuple[Path, ...] = ()
) -> Source:
    """A folder of CSV and NumPy files, or one such file.

    CSV: a header line, or numbers only (columns ``0``, ``1``, …); comma, semicolon, tab or
    blanks between; also Motive's, DeepLabCut's, Tracker's and Kinovea's exports. NumPy: ``.npy``
    with one row a point (fields of a structured array are columns), ``.npz`` with such an array
    (named in the mapping as `path`, else ``points``, else the only one of that shape) and further
    arrays as fields.

    Args:
        path: File or folder.
        mapping: How to read it.
        progress: Told how far reading is.
        left_out: Files of the folder that hold no recordings (labels, objects).
    """
    source = Source("tables", name=path.stem)
    root = path if path.is_dir() else path.parent
    files = [path] if path.is_file() else wanted_files(path, SUFFIXES, mapping, left_out)
    for i, file in enumerate(files):
        source.recordings += _read_file(file, root, mapping, source)
        progress("read", i + 1, len(files))
    source.notes.insert(0, f"read: {len(source.recordings)} recordings from {len(files)} files")
    shorten_names(source)
    return source


def _read_file(file: Path, root: Path, mapping: Mapping, source: Source) -> list[Recording]:
    name = file.relative_to(root).with_suffix("").as_posix()
    folders = folders_between(root, file)
    if file.suffix.lower() == ".npy":
        array = load_npy(file)
        named = array.dtype.names
        if named is not None:
            array = np.stack([array[n] for n in named], axis=-1)
        points = path_array(array, file=file, name="points")
        columns = named or tuple(str(i) for i in range(points.shape[1]))
        return [Recording(name, points, columns, folders=folders, file=file, ordered=False)]
    if file.suffix.lower() == ".npz":
        return [read_npz(file, name, folders, mapping)]
    data = read_text(file, mapping.encoding)
    layout = layout_of(data, mapping, file)
    if layout is None:
        table = table_of(data, find_header(data, mapping, file), mapping, file)
        return [replace(r, grouped=True) for r in _recordings(table, name, folders, file, mapping)]
    source.notes += [f"{file.name}, {note}" for note in layout.notes]
    source.up = source.up or layout.up
    if layout.world_units is not None and mapping.units is None:
        expected = f"the unit of {layout.world_units}'s coordinates, which the file does not state"
        raise InputError(f"{expected} (--units px, m, cm or mm)", "none", file=file, field="units")
    out = []
    for part, table in layout.tables:
        whole = name if part is None else f"{name}-{part}"
        out += _recordings(table, whole, folders, file, mapping)
    return out


def _recordings(
    table: TextTable, name: str, folders: tuple[str, ...], file: Path, mapping: Mapping
) -> list[Recording]:
    if not len(table.cells):
        raise InputError("at least one line below the header", "none", file=file)
    units = dict(table.units)

    def of(key: str, rows: np.ndarray, row: str | None) -> Recording:
        return Recording(
            key, np.empty((len(rows), 0)), table.names, fields=RowFields(table.cells, rows),
            folders=folders, file=file, row=row, units=units, cells=Rows(table.cells, rows),
            ordered=False,
        )  # fmt: skip

    episodes: list[Episode] | None = episodes_of(table, mapping, file)
    if episodes is None:
        return [of(name, np.arange(len(table.cells)), None)]
    return [of(e.name, e.rows, f"demonstration {e.name}") for e in episodes]
