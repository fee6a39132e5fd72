"""A small valid set on disk, and ways to break it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, write_set
from demospec.scene import Disc, Picture, Scene, SceneObject


def path(bulge: float, n: int = 9) -> np.ndarray:
    """(n, 2) from (10, 90) to (90, 10)."""
    s = np.linspace(0, 1, n)
    x = 10 + 80 * s + bulge * np.sin(np.pi * s)
    return np.stack([x, 90 - 80 * s + bulge * np.sin(np.pi * s)], axis=1)


def small_set(n: int = 6, *, pictures: bool = True, t: bool = False) -> DemonstrationSet:
    """Two scenes with a glass each, n demonstrations, two types."""
    scenes = tuple(
        Scene(
            f"s{i}",
            (10.0, 90.0),
            (90.0, 10.0),
            (SceneObject("glass-0", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 6.0)),),
            Picture(array=np.full((100, 100, 3), 40 * i, np.uint8)) if pictures else None,
        )
        for i in range(2)
    )
    items = [
        Demonstration(
            f"d{i}",
            f"s{i % 2}",
            path(3.0 * i % 40 - 5 + i / 1000),
            ("careful", "normal")[i % 2],
            None,
            i % 3 != 0,
            np.arange(9) / 10 if t else None,
        )
        for i in range(n)
    ]
    return DemonstrationSet(
        scenes, Demonstrations.of(items), symbols=("glass",), types=("careful", "normal")
    )


def write_small(folder: Path, n: int = 6, **kinds: Any) -> Path:
    """`small_set` on disk."""
    return write_set(small_set(n, **kinds), folder)


def rewrite_table(folder: Path, change: Any) -> None:
    """Rewrites demonstrations.parquet: `change` gets and returns a list of rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    file = folder / "demonstrations.parquet"
    table = pq.read_table(file)
    pq.write_table(pa.Table.from_pylist(change(table.to_pylist()), schema=table.schema), file)


def change_json(file: Path, change: Any) -> None:
    """Rewrites a JSON document: `change` gets and changes it."""
    document = json.loads(file.read_text())
    change(document)
    file.write_text(json.dumps(document))


def change_line(folder: Path, row: int, change: Any) -> None:
    """Rewrites one line of metadata.jsonl."""
    file = folder / "scenes" / "metadata.jsonl"
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    change(lines[row])
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))


def digest(folder: Path) -> dict[str, bytes]:
    """Every file below a folder with its bytes."""
    return {
        p.relative_to(folder).as_posix(): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file()
    }
