"""HDF5 recordings, robomimic's layout first.

robomimic: group ``data`` with a group a demonstration (``demo_0``, …; attribute
``num_samples``), in it ``obs/KEY`` (T, …), ``actions``, ``rewards``, ``dones``; group ``mask``
with lists of demonstration names (filter keys such as ``train`` and ``valid``). Other files
with one group a demonstration are read too.

Source: robomimic's documentation, "Dataset Structure".
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    MAX_NUMBERS,
    Pictures,
    RawScene,
    Recording,
    Source,
    path_array,
)
from demospec.errors import InputError, MissingExtraError
from demospec.progress import Progress
from demospec.scene import Picture

_PATHS = (
    "obs/robot0_eef_pos", "obs/eef_pos", "obs/ee_pos", "obs/ee_states", "observations/eef_pos",
    "eef_pos", "points", "path", "positions",
)  # fmt: skip
_TIMES = ("t", "time", "timestamp", "timestamps", "obs/t", "obs/time")
_MAX_DEPTH = 8


def read_hdf5(path: Path, mapping: Mapping, progress: Progress, pictures: Pictures) -> Source:
    """An HDF5 file with one group a demonstration.

    The path is the dataset `mapping.path` inside each demonstration's group (default
    ``obs/robot0_eef_pos`` and its like); the picture the first frame of the dataset
    `mapping.picture`. Attributes, scalars, and datasets with one number a step are fields.
    Object arrays, references and links to other files are never followed or loaded.

    Raises:
        InputError: Not HDF5, a dataset that is not there, or of another type.
        MissingExtraError: h5py is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingExtraError("h5py", "hdf5", "an HDF5 file") from error
    source = Source("hdf5", units="m", name=path.stem)
    try:
        with h5py.File(path, "r", locking=False) as file:
            _read(file, path, mapping, progress, pictures, source)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError) as error:
        raise InputError("an HDF5 file", str(error), file=path) from error
    return source


def _read(
    file: Any, path: Path, mapping: Mapping, progress: Progress, pictures: Pictures, source: Source
) -> None:
    groups = _groups(file, path)
    first = next(iter(groups.values()))
    cameras = tuple(name for name in _arrays(first) if _is_picture(_item(first, name)))
    source.cameras = cameras
    camera = mapping.picture if mapping.picture in cameras else None
    if camera is None and cameras:
        source.notes.append(f"cameras, not read: {', '.join(cameras)} (choose with --picture)")
    key = _path_key(first, path, mapping)
    splits = _splits(file)
    for i, (name, group) in enumerate(groups.items()):
        recording = _recording(group, name, key, path)
        if camera is not None:
            scene = f"scene-{name}"
            source.scenes[scene] = RawScene(
                scene, load=_loader(path, group.name, camera, name, pictures),
                split=splits.get(name),
            )  # fmt: skip
            recording = Recording(
                recording.name, recording.points, recording.columns, recording.t,
                recording.fields, (), scene, path, name,
            )  # fmt: skip
        source.recordings.append(recording)
        progress("read", i + 1, len(groups))
    source.notes.append(f"read: {len(groups)} groups, path {key}")


def _groups(file: Any, path: Path) -> dict[str, Any]:
    """The groups that hold a demonstration each: those in ``data``, else those at the root."""
    import h5py

    parent = file
    if isinstance(_item(file, "data"), h5py.Group):
        parent = _item(file, "data")
    groups = {n: _item(parent, n) for n in parent if isinstance(_item(parent, n), h5py.Group)}
    groups = {n: g for n, g in groups.items() if n != "mask"}
    if not groups and any(True for _ in _arrays(parent)):
        groups = {path.stem: parent}  # one demonstration at the root
    if not groups:
        raise InputError("a group for each demonstration", ", ".join(parent) or "none", file=path)
    return dict(sorted(groups.items(), key=lambda item: _natural(item[0])))


def _natural(name: str) -> tuple[str, int, str]:
    digits = "".join(c for c in name if c.isdigit())
    return name.rstrip("0123456789"), int(digits[:18]) if digits else -1, name


def _item(group: Any, name: str) -> Any:
    """A member of a group, or None: links to other files and broken links are not followed."""
    import h5py

    here = group
    for part in name.split("/"):
        if not isinstance(here, h5py.Group) or part not in here:
            return None
        if isinstance(here.get(part, getlink=True), (h5py.ExternalLink, h5py.SoftLink)):
            return None
        here = here[part]
    return here


def _arrays(group: Any, prefix: str = "", depth: int = 0) -> list[str]:
    """Names of the datasets below a group (links left out, so that no loop is entered)."""
    import h5py

    names: list[str] = []
    if depth > _MAX_DEPTH:
        return names
    for name in group:
        item = _item(group, name)
        if isinstance(item, h5py.Dataset):
            names.append(prefix + name)
        elif isinstance(item, h5py.Group):
            names += _arrays(item, f"{prefix}{name}/", depth + 1)
    return names


def _is_picture(item: Any) -> bool:
    return bool(item.dtype == np.uint8 and len(item.shape) == 4 and item.shape[-1] == 3)


def _path_key(group: Any, path: Path, mapping: Mapping) -> str:
    known = _arrays(group)
    if mapping.path is not None:
        if mapping.path not in known:
            raise InputError(f"a dataset {mapping.path}", ", ".join(known) or "none", file=path,
                             row=group.name, field="path")  # fmt: skip
        return mapping.path
    for name in _PATHS:
        if name in known:
            return name
    raise InputError("a dataset for the path; say which: --path NAME", ", ".join(known) or "none",
                     file=path, row=group.name, field="path")  # fmt: skip


def _load(item: Any, path: Path, row: str, name: str) -> np.ndarray:
    """A dataset's numbers; its type and size are judged before anything is read."""
    if item is None:
        raise InputError(f"a dataset {name}", "none", file=path, row=row, field=name)
    if item.dtype.kind not in "biuf":
        found = "an object array (never loaded)" if item.dtype.hasobject else f"type {item.dtype}"
        raise InputError("an array of numbers", found, file=path, row=row, field=name)
    if item.size > MAX_NUMBERS or (item.ndim and item.shape[0] > 100 * MAX_POINTS):
        raise InputError(f"at most {MAX_NUMBERS} numbers", f"shape {item.shape}", file=path,
                         row=row, field=name)  # fmt: skip
    return np.asarray(item[()])


def _recording(group: Any, name: str, key: str, path: Path) -> Recording:
    points = path_array(_load(_item(group, key), path, name, key), file=path, name=key)
    fields: dict[str, Any] = {}
    for attribute in group.attrs:
        fields[attribute] = _attribute(group.attrs, attribute)
    t = None
    for other in _arrays(group):
        item = _item(group, other)
        if other == key or item.dtype.kind not in "biuf":
            continue
        if item.shape == (len(points),) or item.shape == (len(points), 1):
            values = _load(item, path, name, other).reshape(-1)
            fields[other] = values
            if other in _TIMES and t is None and values.dtype.kind in "iuf":
                t = values.astype(np.float64)
        elif item.size == 1:
            fields[other] = _load(item, path, name, other).reshape(-1)[0].item()
    columns = tuple(str(i) for i in range(points.shape[1]))
    return Recording(name, points, columns, t=t, fields=fields, file=path, row=name)


def _attribute(attributes: Any, name: str) -> Any:
    """A scalar attribute or a word; None for anything else."""
    kind = attributes.get_id(name).dtype
    import h5py

    if h5py.check_string_dtype(kind) is None and kind.kind not in "biufSU":
        return None
    value = attributes[name]
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    if isinstance(value, np.ndarray):
        return value.reshape(-1)[0].item() if value.size == 1 else None
    return value.item() if isinstance(value, np.generic) else value


def _splits(file: Any) -> dict[str, str]:
    """Demonstration → ``train`` or ``test``, from robomimic's filter keys."""
    out: dict[str, str] = {}
    for key, split in (("train", "train"), ("valid", "test"), ("test", "test")):
        item = _item(file, f"mask/{key}")
        if item is None or (item.dtype.hasobject and _not_text(item.dtype)):
            continue
        for name in np.asarray(item[()]).reshape(-1)[:1_000_000].tolist():
            text = name.decode("utf-8", errors="replace") if isinstance(name, bytes) else str(name)
            out[text] = split
    return out


def _not_text(kind: Any) -> bool:
    import h5py

    return h5py.check_string_dtype(kind) is None


def _loader(path: Path, group: str, camera: str, name: str, pictures: Pictures) -> Any:
    def load() -> Picture:
        import h5py

        try:
            with h5py.File(path, "r", locking=False) as file:
                item = _item(file[group], camera)
                if item is None or not _is_picture(item) or item.shape[0] < 1:
                    raise InputError("8-bit RGB frames (T, h, w, 3)", "something else", file=path,
                                     row=name, field=camera)  # fmt: skip
                if item.shape[1] * item.shape[2] > 64_000_000:
                    raise InputError("frames of at most 64000000 pixels", item.shape, file=path,
                                     row=name, field=camera)  # fmt: skip
                return pictures.keep(name, np.ascontiguousarray(item[0]))
        except (OSError, RuntimeError, KeyError, ValueError, MemoryError) as error:
            raise InputError("an HDF5 file", str(error), file=path, row=name) from error

    return load
