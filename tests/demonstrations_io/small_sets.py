"""Ways to break a small valid set on disk (`demospec.testing.write_small_set`)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


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
