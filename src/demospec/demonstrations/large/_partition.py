"""Parts of a set for workers elsewhere: rows of its Parquet file, on disk or behind a URL.

A part is named by rows, not by row groups, so that the same set is cut the same way however it
was written. A worker reads the row groups that overlap its part and nothing else of the paths;
header, scene list and pictures of a set behind a URL are copied once for each worker process.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

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
from demospec.errors import InputError, MissingExtraError

PART_ROWS = 100_000


def cut_rows(store: str, *, rows: int = PART_ROWS) -> list[tuple[int, int]]:
    """First row and end of every part of at most `rows` demonstrations, in file order.

    Args:
        store: A set's folder, or its URL (``s3://bucket/set``, ``file:///…``: any store that
            fsspec knows).

    Raises:
        InputError: No such set, or no demonstrations in it.
    """
    total = count_rows(store)
    if total == 0:
        raise InputError("at least one demonstration", "none", file=f"{store}/{PARQUET}")
    return [(first, min(first + rows, total)) for first in range(0, total, rows)]


def count_rows(store: str | os.PathLike[str]) -> int:
    """How many demonstrations the file of a set (a folder, or a URL) says that it holds."""
    with _parquet(os.fspath(store)) as parquet:
        return int(parquet.metadata.num_rows)


def read_part(store: str, first: int, end: int) -> DemonstrationSet:
    """Demonstrations `first` to `end` (not included) of a set, with the scenes they use.

    Raises:
        InputError: As `read_set`, with the row in the whole file.
    """
    import pyarrow as pa

    root, header, version, scenes = _kept_header(store)
    with _parquet(store) as parquet, parquet_faults(root / PARQUET):
        groups, offset, skipped = [], 0, 0
        for group in range(parquet.metadata.num_row_groups):
            count = parquet.metadata.row_group(group).num_rows
            if offset + count <= first:
                skipped = offset + count
            elif offset < end:
                groups.append(group)
            offset += count
        table = parquet.read_row_groups(groups, columns=wanted_columns(parquet))
        table = table.slice(first - skipped, end - first)
        table = pa.concat_tables([table]).combine_chunks()
    columns = len(header.columns)
    rows = from_arrow(
        migrate_table(table, version), file=root / PARQUET, columns=columns, first_row=first
    )
    wanted = set(rows.scene_id)
    used = tuple(scene for scene in scenes if scene.scene_id in wanted)
    return assemble(root, header, used or scenes[:1], rows)


def is_url(store: str) -> bool:
    """Whether a store is to be reached through fsspec."""
    return "://" in store


def header_of(store: str) -> Any:
    """(folder, header, version, scenes) of a set; pictures of one behind a URL are copied."""
    root = _mirror(store) if is_url(store) else set_folder(store)
    header, version = read_header(root)
    return root, header, version, read_scenes(root, version)


_kept_header = lru_cache(maxsize=4)(header_of)  # a worker reads many parts of one set


def _mirror(url: str) -> Path:
    """A local folder with all of a set but its paths; removed when the process ends."""
    folder = Path(tempfile.mkdtemp(prefix="demospec-set-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    system, path = _opened(url)
    try:
        system.get_file(f"{path}/dataset.json", str(folder / "dataset.json"))
        (folder / "scenes").mkdir()
        for name in system.ls(f"{path}/scenes", detail=False):
            system.get_file(name, str(folder / "scenes" / name.rsplit("/", 1)[-1]))
    except (OSError, ValueError) as error:
        raise InputError("a demonstration set", str(error), file=url) from error
    return folder


def _opened(url: str) -> tuple[Any, str]:
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise MissingExtraError("fsspec", "distributed", "a set behind a URL") from error
    try:
        system, path = url_to_fs(url)
    except (ImportError, ValueError, OSError) as error:
        raise InputError("the URL of a store that fsspec knows", str(error), file=url) from error
    return system, str(path).rstrip("/")


@contextmanager
def _parquet(store: str) -> Iterator[Any]:
    if not is_url(store):
        with opened_parquet(set_folder(store) / PARQUET) as parquet:
            yield parquet
        return
    import pyarrow.parquet as pq

    system, path = _opened(store)
    with parquet_faults(Path(PARQUET)):
        file = system.open(f"{path}/{PARQUET}", "rb")
        with file, pq.ParquetFile(file) as parquet:
            yield parquet
