"""A random part of a large set: the same one in however many pieces, and wherever, it is read.

A demonstration's rank is a random number that hangs on the seed and on its row in the file;
those of lowest rank are the sample. So pieces can be drawn from apart and put together.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._store import PARQUET, assemble
from demospec.demonstrations._trajectory import Demonstrations, joined
from demospec.demonstrations.large._partition import (
    PART_ROWS,
    count_rows,
    cut_rows,
    header_of,
    is_url,
    read_part,
)
from demospec.demonstrations.large._stream import BATCH_ROWS, iterate_batches
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.parallel import iterate_tasks
from demospec.progress import Progress, silent


@dataclass(frozen=True)
class _Draw:
    """Demonstrations drawn so far: each with its rank and its row in the file, both (n,)."""

    drawn: Demonstrations
    rank: FloatArray
    row: NDArray[np.int64]

    def lowest(self, per_type: int) -> _Draw:
        """The `per_type` of lowest rank of each type, in their order."""
        parts = []
        for name in set(self.drawn.type.tolist()):
            mine = np.flatnonzero(np.array([n == name for n in self.drawn.type], dtype=bool))
            parts.append(mine[np.argsort(self.rank[mine])[:per_type]])
        keep = np.sort(np.concatenate(parts)) if parts else np.zeros(0, dtype=np.int64)
        return _Draw(self.drawn.rows(keep), self.rank[keep], self.row[keep])

    def with_more(self, other: _Draw) -> _Draw:
        return _Draw(
            joined([self.drawn, other.drawn]),
            np.concatenate([self.rank, other.rank]),
            np.concatenate([self.row, other.row]),
        )


@dataclass(frozen=True)
class _Wish:
    store: str
    per_type: int
    inside: frozenset[str]  # scenes to draw from; none: all
    seed: int

    def of(self, some: Demonstrations, first_row: int) -> _Draw:
        """What is drawn from demonstrations that follow each other in the file."""
        wanted = some.valid >= 0
        if self.inside:
            wanted &= np.array([name in self.inside for name in some.scene_id], dtype=bool)
        chosen = np.flatnonzero(wanted)
        # Draw number r of the stream belongs to row r, whoever reads that row.
        rank = np.random.Generator(np.random.PCG64(self.seed).advance(first_row)).random(len(some))
        draw = _Draw(some.rows(chosen), rank[chosen], first_row + chosen)
        return draw.lowest(self.per_type)


def sample_set(
    store: str | os.PathLike[str],
    *,
    per_type: int,
    split: str | None = None,
    seed: int = 0,
    rows: int | None = None,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
) -> DemonstrationSet:
    """A random part of a large set: at most `per_type` labelled demonstrations of each type.

    Every demonstration of a type has the same chance; their order is kept. One pass, bounded
    memory. The sample is the same however many workers read.

    Args:
        store: A set's folder, or its URL; seen by every worker.
        split: Only from scenes of this split; where no scene is so marked, and for None, from
            all.
        seed: Of the draw.
        rows: Demonstrations read at a time.
        workers: Processes on this machine.
        cluster: Address of a Dask scheduler.

    Raises:
        InputError: As `iterate_batches` (a demonstration that is there twice is told where one
            process reads all); also where no demonstration is labelled.
    """
    name = os.fspath(store)
    root, header, _, scenes = header_of(name)
    inside = frozenset(s.scene_id for s in scenes if s.split == split)
    wish = _Wish(name, per_type, inside, seed)
    found: _Draw | None = None
    if workers == 1 and cluster is None and not is_url(name):
        pieces = _pieces(wish, rows or BATCH_ROWS, progress)
    else:
        pieces = iterate_tasks(
            partial(_drawn_from, wish), cut_rows(name, rows=rows or PART_ROWS), workers=workers,
            cluster=cluster, progress=progress, what="sample",
        )  # fmt: skip
    for piece in pieces:
        found = piece if found is None else found.with_more(piece).lowest(per_type)
    if found is None or not len(found.drawn):
        raise InputError(
            "demonstrations labelled valid or not", "none", file=root / PARQUET, field="valid"
        )
    used = set(found.drawn.scene_id)
    ordered = found.drawn.rows(np.argsort(found.row))
    return assemble(root, header, tuple(s for s in scenes if s.scene_id in used), ordered)


def _pieces(wish: _Wish, rows: int, progress: Progress) -> Iterator[_Draw]:
    total, first = count_rows(wish.store), 0
    for batch in iterate_batches(wish.store, rows=rows):
        yield wish.of(batch.demonstrations, first)
        first += len(batch.demonstrations)
        progress("sample", first, total)


def _drawn_from(wish: _Wish, rows: tuple[int, int]) -> _Draw:
    return wish.of(read_part(wish.store, *rows).demonstrations, rows[0])
