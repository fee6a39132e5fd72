"""`.npy` and `.npz` files, judged before anything is allocated; pickles refused."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    MAX_NUMBERS,
    Recording,
    numeric,
    path_array,
)
from demospec.errors import InputError
from demospec.files import read_bytes

TIME_NAMES = ("t", "time", "timestamp", "time_s", "seconds", "stamp", "t_s")


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
            if other.lower() in TIME_NAMES and t is None:
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
