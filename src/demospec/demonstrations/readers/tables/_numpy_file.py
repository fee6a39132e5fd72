"""`.npy` and `.npz` files, judged before anything is allocated; pickles refused."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._column_names import column_name, may_be_path
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    MAX_NUMBERS,
    Clock,
    Recording,
    numeric,
    path_array,
)
from demospec.errors import InputError
from demospec.files import read_bytes

_PATHS = ("points", "path", "trajectory", "positions", "position", "waypoints", "xy", "xyz", "pos")
"""Names of arrays whose columns are x, y and z in this order."""


def load_npy(file: Path) -> np.ndarray:
    """The array of a ``.npy`` file; InputError where it is broken, too large, or of objects."""
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


def read_npz(file: Path, name: str, folders: tuple[str, ...], mapping: Mapping) -> Recording:
    """One ``.npz`` archive as a recording: its path array, the other arrays as fields."""
    arrays: dict[str, np.ndarray] = {}
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(file))) as archive:
            whole = sum(item.file_size for item in archive.infolist())
            if whole > 8 * MAX_NUMBERS:
                raise InputError(f"at most {8 * MAX_NUMBERS} bytes of arrays", whole, file=file)
            for item in archive.infolist():
                data = io.BytesIO(archive.read(item))
                own = item.filename.removesuffix(".npy")
                if own in arrays:
                    raise InputError("each array once", f"{own} twice", file=file)
                arrays[own] = _load_array(data, file)
    except (zipfile.BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError, ValueError,
            MemoryError) as error:  # fmt: skip
        raise InputError("a NumPy archive (.npz)", str(error), file=file) from error
    key = _path_key(arrays, mapping, file)
    if key is None:
        points, columns = _lists(arrays, file)
    else:
        points = path_array(arrays[key], file=file, name=key)
        columns = tuple("xyz"[: points.shape[1]])
        if (key not in _PATHS and mapping.path is None) or points.shape[1] > 3:
            columns = tuple(str(i) for i in range(points.shape[1]))
    fields: dict[str, Any] = {}
    clocks = []
    for other, array in arrays.items():
        if other == key:
            continue
        said = column_name(other)
        if array.ndim == 1 and array.dtype.kind in "biuf" and len(array) >= 1:
            fields[other] = numeric(array, file=file, name=other)
            whole = len(array) == len(points)
            if said.quantity == "time" and whole and array.dtype.kind in "iuf":
                clocks.append((said.rank, other, said.unit))
            elif said.quantity in ("tilt", "speed", "gripper") and whole and key is not None:
                points = np.column_stack([points, fields[other]])
                columns = (*columns, other)
        elif array.ndim == 2 and said.quantity == "other" and array.shape == (len(points), 4):
            extra, theirs = quaternion_columns(other, array, mapping)
            points, columns = np.column_stack([points, extra]), (*columns, *theirs)
        elif array.size == 1:
            fields[other] = array.reshape(-1)[0].item()
        elif array.ndim == 1 and array.dtype.kind == "U":
            fields[other] = array
    _, clock, unit = min(clocks, default=(0, None, None))
    return Recording(
        name, np.asarray(points, dtype=np.float64), columns,
        t=None if clock is None else fields[clock].astype(np.float64),
        fields=fields, folders=folders, file=file,
        clock=None if clock is None else Clock(clock, unit), ordered=False,
    )  # fmt: skip


def quaternion_columns(
    name: str, array: np.ndarray, mapping: Mapping
) -> tuple[np.ndarray, tuple[str, ...]]:
    """(n, 4) numbers of an orientation and their names; unnamed where nobody says their order."""
    order = mapping.quaternion
    names = tuple(f"{name}.{a}" for a in order) if order else tuple(f"{name}.{i}" for i in range(4))
    return np.asarray(array, dtype=np.float64), names


def _lists(arrays: dict[str, np.ndarray], file: Path) -> tuple[np.ndarray, tuple[str, ...]]:
    """The path from lists named x, y and so on, one value a point each."""
    lists = {
        n: numeric(a, file=file, name=n)
        for n, a in arrays.items()
        if a.ndim == 1 and a.dtype.kind in "iuf" and column_name(n).quantity != "time"
    }
    length = next(len(a) for n, a in lists.items() if column_name(n).axis == "x")
    named = {n: a for n, a in lists.items() if len(a) == length}
    points = np.stack([a.astype(np.float64) for a in named.values()], axis=1)
    return path_array(points, file=file, name=", ".join(named)), tuple(named)


def _path_key(arrays: dict[str, np.ndarray], mapping: Mapping, file: Path) -> str | None:
    """The array of points; None where x, y, … are lists of their own."""
    if mapping.path is not None:
        if mapping.path not in arrays:
            known = ", ".join(arrays) or "none"
            raise InputError(f"an array {mapping.path}", known, file=file, field="path")
        return mapping.path
    if "points" in arrays:
        return "points"
    flat = [k for k, a in arrays.items() if a.ndim == 2 and a.shape[1] in (2, 3) and may_be_path(k)]
    if len(flat) == 1:
        return flat[0]
    single = {
        column_name(k).axis for k, a in arrays.items() if a.ndim == 1 and a.dtype.kind in "iuf"
    }
    if not flat and {"x", "y"} <= single:
        return None
    expected = "one array of points; say which: --path NAME"
    raise InputError(expected, ", ".join(arrays) or "none", file=file, field="path")
