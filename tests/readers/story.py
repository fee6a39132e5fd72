"""Three demonstrations as columns, and the files in which readers find them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet


@dataclass
class Column:
    """One column of one demonstration.

    Args:
        name: As the file writes it.
        values: One a row: numbers or words.
        means: What the story says it is: ``x``, ``y``, ``z``, ``t``, ``id``, ``valid``, ``type``,
            or ``""`` for anything that is none of these.
    """

    name: str
    values: list[Any]
    means: str = ""


Table = list[Column]
"""The columns of one demonstration."""

PIXELS = 512.0
"""Pixels a metre, where a story is told in pixels (exact in a few bits)."""

NAMES = ("a7", "b7", "c7")
VALID = (True, False, True)
TYPES = ("careful", "normal", "careful")


def story(solid: bool = True) -> list[Table]:
    """Three demonstrations in metres: ends far apart, no column that only rises but the time."""
    out = []
    for k, name in enumerate(NAMES):
        n = 9 + k
        s = np.linspace(0, 1, n)
        x = 0.1 + 0.5 * s + 0.07 * np.sin(9 * s + k)
        y = 0.2 + 0.1 * k + 0.3 * s * (1 - s) + 0.05 * np.cos(8 * s)
        z = 0.3 + 0.05 * np.sin(7 * s + k)
        t = 0.05 * np.arange(n) + 0.004 * np.sin(np.arange(n))
        rows = [np.round(v, 6).tolist() for v in (t, x, y, z)]
        out.append(
            [
                Column("demo_id", [name] * n, "id"),
                Column("t", rows[0], "t"),
                Column("x", rows[1], "x"),
                Column("y", rows[2], "y"),
                *([Column("z", rows[3], "z")] if solid else []),
                Column("success", [int(VALID[k])] * n, "valid"),
                Column("user_type", [TYPES[k]] * n, "type"),
            ]
        )
    return out


@dataclass
class Source:
    """A file or folder, and how it is to be read."""

    path: Path
    how: dict[str, Any] = field(default_factory=dict)


def of_path(table: Table, *, once: bool = False) -> Table:
    """Without the columns that say the same in every row.

    Args:
        table: All columns.
        once: The format holds each name once: ValueError for a second one.
    """
    path = [c for c in table if c.means not in ("id", "valid", "type")]
    if once and len({c.name for c in path}) < len(path):
        raise ValueError("a name twice")
    return path


def said(table: Table) -> dict[str, Any]:
    """What the columns that say the same in every row say, by their names."""
    return {c.name: c.values[0] for c in table if c.means in ("valid", "type")}


def text_of(columns: Table, delimiter: str = ",", decimal: str = ".") -> str:
    """A table of text."""

    def cell(value: Any) -> str:
        text = value if isinstance(value, str) else repr(value)
        text = text.replace(".", decimal) if isinstance(value, float) else text
        return f'"{text}"' if delimiter in text else text

    lines = [delimiter.join(c.name for c in columns)]
    lines += [
        delimiter.join(map(cell, row)) for row in zip(*(c.values for c in columns), strict=True)
    ]
    return "\n".join(lines) + "\n"


def write_long(folder: Path, tables: list[Table]) -> Source:
    """One CSV file with a column of names."""
    joined = [
        Column(c.name, [v for t in tables for v in t[j].values], c.means)
        for j, c in enumerate(tables[0])
    ]
    (folder / "all.csv").write_text(text_of(joined))
    return Source(folder / "all.csv", {"units": "m"})


def write_files(folder: Path, tables: list[Table]) -> Source:
    """A CSV file a demonstration, and a table of labels."""
    for name, table in zip(NAMES, tables, strict=True):
        (folder / f"{name}.csv").write_text(text_of(of_path(table)))
    keys = list(said(tables[0]))
    rows = [[n, *map(str, said(t).values())] for n, t in zip(NAMES, tables, strict=True)]
    (folder / "labels.csv").write_text("\n".join(map(",".join, [["file", *keys], *rows])) + "\n")
    return Source(folder, {"units": "m"})


def write_npz(folder: Path, tables: list[Table]) -> Source:
    """An archive of lists a demonstration."""
    for name, table in zip(NAMES, tables, strict=True):
        arrays = {c.name: np.array(c.values) for c in of_path(table, once=True)}
        arrays |= {k: np.array(v) for k, v in said(table).items()}
        np.savez(folder / f"{name}.npz", **arrays)
    return Source(folder, {"units": "m"})


def write_npy(folder: Path, tables: list[Table]) -> Source:
    """A structured array a demonstration."""
    for name, table in zip(NAMES, tables, strict=True):
        columns = of_path(table)
        array = np.zeros(len(columns[0].values), dtype=[(c.name, "f8") for c in columns])
        for c in columns:
            array[c.name] = c.values
        np.save(folder / f"{name}.npy", array)
    return Source(folder, {"units": "m"})


def write_lists(folder: Path, tables: list[Table]) -> Source:
    """JSON: each path an object of lists."""
    items = [
        {"id": name, "path": {c.name: c.values for c in of_path(table, once=True)}, **said(table)}
        for name, table in zip(NAMES, tables, strict=True)
    ]
    (folder / "all.json").write_text(json.dumps({"demonstrations": items}))
    return Source(folder / "all.json", {"units": "m"})


def write_steps(folder: Path, tables: list[Table]) -> Source:
    """JSON: a file a demonstration, an object a step."""
    for name, table in zip(NAMES, tables, strict=True):
        columns = of_path(table, once=True)
        steps = [dict(zip([c.name for c in columns], row, strict=True))
                 for row in zip(*(c.values for c in columns), strict=True)]  # fmt: skip
        (folder / f"{name}.json").write_text(json.dumps({**said(table), "steps": steps}))
    return Source(folder, {"units": "m"})


def write_lerobot(folder: Path, tables: list[Table]) -> Source:
    """LeRobot v3: the numbers of the path in one feature with names."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = [c for c in of_path(tables[0]) if c.means != "t"]
    words = [c.name for c in columns]
    features = {"observation.state": {"dtype": "float32", "shape": [len(words)], "names": words}}
    one = {"shape": [1], "names": None}
    features |= {n: {"dtype": "int64", **one} for n in ("frame_index", "episode_index")}
    features |= {c.name: {"dtype": "float64", **one} for c in tables[0] if c.means == "t"}
    features |= {n: {"dtype": "int64", **one} for n in said(tables[0])}
    rows: dict[str, list[Any]] = {name: [] for name in features}
    meta = []
    for e, table in enumerate(tables):
        path = [c for c in of_path(table) if c.means != "t"]
        n = len(path[0].values)
        rows["observation.state"] += [list(map(float, r)) for r in
                                      zip(*(c.values for c in path), strict=True)]  # fmt: skip
        rows["frame_index"] += range(n)
        rows["episode_index"] += [e] * n
        for c in table:
            if c.means == "t":
                rows[c.name] += c.values
        for name, value in said(table).items():
            rows[name] += [value] * n
        meta.append({"episode_index": e, "length": n, "tasks": [], "data/chunk_index": 0,
                     "data/file_index": 0})  # fmt: skip
    for part in ("data/chunk-000", "meta/episodes/chunk-000"):
        (folder / part).mkdir(parents=True)
    pq.write_table(pa.table(rows), folder / "data/chunk-000/file-000.parquet")
    pq.write_table(pa.Table.from_pylist(meta), folder / "meta/episodes/chunk-000/file-000.parquet")
    info = {"codebase_version": "v3.0", "fps": 20, "total_episodes": len(tables),
            "total_frames": len(rows["frame_index"]), "features": features,
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"}  # fmt: skip
    (folder / "meta/info.json").write_text(json.dumps(info))
    return Source(folder)


def write_hdf5(folder: Path, tables: list[Table]) -> Source:
    """HDF5: a group a demonstration, its positions in one dataset, the rest beside it."""
    import h5py

    with h5py.File(folder / "all.hdf5", "w") as file:
        for name, table in zip(NAMES, tables, strict=True):
            group = file.create_group(f"data/{name}")
            axes = [c for c in table if c.means in ("x", "y", "z") and c.name == c.means]
            if len(axes) >= 2:
                group["obs/eef_pos"] = np.array([c.values for c in axes], dtype=np.float64).T
            for c in of_path(table):
                if c not in axes:
                    group[f"obs/{c.name}"] = np.array(c.values)
            for key, value in said(table).items():
                group.attrs[key] = value
    return Source(folder / "all.hdf5")


def write_mcap(folder: Path, tables: list[Table]) -> Source:
    """MCAP with JSON messages: named values a sample, and the labels at the end."""
    from mcap.writer import Writer

    for name, table in zip(NAMES, tables, strict=True):
        columns = [c for c in of_path(table) if c.means != "t"]
        clock = next((c.values for c in table if c.means == "t"), None)
        with open(folder / f"{name}.mcap", "wb") as stream:
            writer = Writer(stream)
            writer.start(profile="", library="test")
            schema = writer.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
            channel = writer.register_channel("/state", "json", schema)
            last = 0
            for i, row in enumerate(zip(*(c.values for c in columns), strict=True)):
                last = int(1e9 * (clock[i] if clock else 0.05 * i)) + 10**9
                message = {"name": [c.name for c in columns], "position": row}
                data = json.dumps(message).encode()
                writer.add_message(channel, log_time=last, publish_time=last, data=data)
            for key, value in said(table).items():
                kind = "std_msgs/msg/String" if isinstance(value, str) else "std_msgs/msg/Int64"
                schema = writer.register_schema(kind, "jsonschema", b"{}")
                channel = writer.register_channel(f"/{key}", "json", schema)
                data = json.dumps({"data": value}).encode()
                writer.add_message(channel, log_time=last + 1, publish_time=last + 1, data=data)
            writer.finish()
    return Source(folder, {"path": "/state", "valid": "/success", "type": "/user_type"})


WRITERS: dict[str, Callable[[Path, list[Table]], Source]] = {
    "long table": write_long, "tables": write_files, "npz": write_npz, "npy": write_npy,
    "json lists": write_lists, "json steps": write_steps, "lerobot": write_lerobot,
    "hdf5": write_hdf5, "mcap": write_mcap,
}  # fmt: skip


def other_data(data: DemonstrationSet, notes: tuple[str, ...], tables: list[Table]) -> str | None:
    """How a set differs from the story: None where it says the same, or less and says so."""
    want = {n: {c.means: c.values for c in t} for n, t in zip(NAMES, tables, strict=True)}
    items = {d.demo_id.rpartition("-")[2]: d for d in data.demonstrations}
    if len(items) != len(data.demonstrations) or len(items) != len(NAMES):
        return f"demonstrations {list(items)}"
    by_order = dict(zip(NAMES, items.values(), strict=True))
    found = items if set(items) == set(NAMES) else by_order
    if data.units not in ("m", "px"):
        return f"unit {data.units}"
    factor = 1.0 if data.units == "m" else PIXELS  # where the file says that they are pixels
    extra = [c for c in data.columns if c not in ("x", "y", "z")]
    if extra:
        return f"columns {extra}"
    if (
        "z" not in data.columns
        and "z" in want[NAMES[0]]
        and not any("not read" in n for n in notes)
    ):
        return "no z, and no word of it"
    text = " ".join(notes)
    for k, name in enumerate(NAMES):
        item, columns = found[name], want[name]
        for j, axis in enumerate(data.columns):
            if axis not in columns or len(item.points) != len(columns[axis]):
                return f"{name}: {len(item.points)} points with {axis}"
            if not np.allclose(item.points[:, j], np.array(columns[axis]) * factor, atol=2e-7):
                return f"{name}: other {axis}"
        if item.t is None:
            if "time: none" not in text and "time:" in text:
                return f"{name}: no time, and no word of it"
        elif "t" in columns:
            stamps = np.array(columns["t"]) - columns["t"][0]
            if not np.allclose(item.t - item.t[0], stamps, atol=1e-5):
                return f"{name}: other time"
        if item.valid is not VALID[k] and not (item.valid is None and "valid: none" in text):
            return f"{name}: valid {item.valid}"
        if item.type != TYPES[k] and not (item.type is None and "type: none" in text):
            return f"{name}: type {item.type}"
    return None
