"""A set in batches: a million demonstrations within bounded memory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np

from demospec.demonstrations._migrate import migrate_table
from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._store import (
    PARQUET,
    assemble,
    read_header,
    read_scenes,
    set_folder,
)
from demospec.demonstrations._table import (
    from_arrow,
    opened_parquet,
    parquet_faults,
    wanted_columns,
)
from demospec.errors import InputError

BATCH_ROWS = 20_000


def iterate_batches(
    folder: str | os.PathLike[str], *, rows: int = BATCH_ROWS
) -> Iterator[DemonstrationSet]:
    """The set at `folder` as sets of at most `rows` demonstrations each, in file order.

    Each batch holds the scenes that its demonstrations use, in the order of the set; pictures
    stay in their files. All scenes are parsed once and kept; of the demonstrations one row
    group of the file is held, at most (`demospec` writes groups of two million points).

    Args:
        folder: A demonstration set.
        rows: Demonstrations in a batch, ≥ 1.

    Raises:
        InputError: As `read_set`; a fault far down the file is raised when it is reached.
    """
    if rows < 1:
        raise InputError("at least 1", rows, field="rows")
    root = set_folder(folder)
    header, version = read_header(root)
    scenes = read_scenes(root, version)
    place: dict[str, int] = {}
    for i, scene in enumerate(scenes):
        if scene.scene_id in place:
            raise InputError(
                "each scene once",
                scene.scene_id,
                file=root / "scenes" / "metadata.jsonl",
                row=i,
                field="scene_id",
            )
        place[scene.scene_id] = i
    file = root / PARQUET
    seen: set[int] = set()
    first_row = 0
    for table in arrow_batches(root, version, rows=rows):
        part = from_arrow(table, file=file, columns=len(header.columns), first_row=first_row)
        used = sorted({place[name] for name in part.scene_id if name in place})
        # A batch without one known scene must still name the unknown one.
        kept = tuple(scenes[i] for i in used) or scenes[:1]
        try:
            batch = assemble(root, header, kept, part)
        except InputError as error:
            raise _shifted(error, first_row, str(file)) from error
        _refuse_repeats(part.demo_id, seen, str(file), first_row)
        yield batch
        first_row += len(part)
    if first_row == 0:
        raise InputError("at least one demonstration", "none", file=file, field="demonstrations")


def arrow_batches(root: Any, version: int, *, rows: int) -> Iterator[Any]:
    """The Arrow tables of ``demonstrations.parquet``, at most `rows` rows each."""
    import pyarrow as pa

    file = root / PARQUET
    with opened_parquet(file) as parquet:
        batches = parquet.iter_batches(batch_size=rows, columns=wanted_columns(parquet))
        while True:
            with parquet_faults(file):
                batch = next(batches, None)
            if batch is None:
                return
            if batch.num_rows:
                yield migrate_table(pa.Table.from_batches([batch]), version)


def _shifted(error: InputError, first_row: int, file: str) -> InputError:
    """The same complaint with the row in the file in place of the row in the batch."""
    row = error.row
    if error.file != file or not isinstance(row, int):
        return error
    return InputError(
        error.expected, error.found, file=file, row=first_row + row, field=error.field
    )


def _refuse_repeats(names: np.ndarray, seen: set[int], file: str, first_row: int) -> None:
    # 64-bit hashes: a million of them repeat by chance once in forty million sets.
    for row, name in enumerate(names):
        key = hash(name)
        if key in seen:
            raise InputError(
                "each demonstration once", name, file=file, row=first_row + row, field="demo_id"
            )
        seen.add(key)
