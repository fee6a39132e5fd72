"""HDF5 recordings: robomimic's layout, one episode a file (ALOHA), folders of either.

robomimic: group ``data`` with a group a demonstration (``demo_0``, …; attribute
``num_samples``), in it ``obs/KEY`` (T, …), ``actions``, ``rewards``, ``dones``; group ``mask``
with lists of demonstration names (filter keys such as ``train`` and ``valid``). ALOHA: the
demonstration at the root, ``observations/KEY`` and ``action``, pictures as arrays or as JPEG. Other
files with one group a demonstration are read too.

Sources: robomimic's documentation, "Dataset Structure"; ALOHA's record_episodes.
"""

from __future__ import annotations

import io
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.demonstrations.readers._column_names import column_name
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    MAX_NUMBERS,
    Clock,
    Pictures,
    RawScene,
    Recording,
    Source,
    chosen_camera,
    folders_between,
    path_array,
    wanted_files,
)
from demospec.demonstrations.readers._video import decoded
from demospec.errors import InputError, MissingExtraError
from demospec.progress import Progress
from demospec.scene import Picture

_PATHS = (
    "obs/robot0_eef_pos", "obs/eef_pos", "obs/ee_pos", "obs/ee_states", "observations/eef_pos",
    "observations/ee_pos", "eef_pos", "points", "path", "positions",
)  # fmt: skip
_JOINTS = (
    "obs/robot0_joint_pos", "observations/qpos", "observation/robot_state/joint_positions",
    "obs/joint_pos", "joint_positions", "qpos", "joints",
)  # fmt: skip
_TIMES = ("t", "time", "timestamp", "timestamps", "obs/t", "obs/time")
_JPEG = b"\xff\xd8\xff"
_PARTS = ("obs", "observation", "observations", "action", "actions", "images")
"""Groups that are parts of a demonstration, not demonstrations."""
_MAX_DEPTH = 8
SUFFIXES = (".hdf5", ".h5", ".hdf")


def read_hdf5(path: Path, mapping: Mapping, progress: Progress, pictures: Pictures) -> Source:
    """An HDF5 file with one group a demonstration or a demonstration at its root, or a folder of
    such files.

    The path is the dataset `mapping.path` inside each demonstration's group (default
    ``obs/robot0_eef_pos`` and its like, with the orientation of robosuite's ``_eef_quat`` beside
    it); the picture the first frame of the dataset `mapping.picture`. Attributes, scalars, and
    datasets with one number a step are fields. Object arrays, references and links to other files
    are never followed or loaded.

    Raises:
        InputError: Not HDF5, a dataset that is not there, or of another type.
        MissingExtraError: h5py is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingExtraError("h5py", "hdf5", "an HDF5 file") from error
    source = Source("hdf5", units="m", name=path.stem)
    files = [path] if path.is_file() else wanted_files(path, SUFFIXES, mapping)
    if not files:
        raise InputError("HDF5 files", "none", file=path)
    stems = Counter(file.stem for file in files)
    for i, each in enumerate(files):
        name = each.stem
        if stems[name] > 1:
            name = each.relative_to(path).with_suffix("").as_posix()
        folders = folders_between(path, each) if path.is_dir() else ()
        try:
            with h5py.File(each, "r", locking=False) as file:
                place = _Place(each, name if path.is_dir() else None, folders)
                _read(file, place, mapping, progress, pictures, source)
        except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError) as error:
            raise InputError("an HDF5 file", str(error), file=each) from error
        if len(files) > 1:
            progress("read", i + 1, len(files))
    files_read = f" in {len(files)} files" if path.is_dir() else ""
    source.notes.append(f"read: {len(source.recordings)} demonstrations{files_read}")
    return source


@dataclass(frozen=True)
class _Place:
    """A file, what its demonstrations' names begin with (None: nothing), and its folders."""

    file: Path
    name: str | None
    folders: tuple[str, ...]


def _read(
    file: Any,
    place: _Place,
    mapping: Mapping,
    progress: Progress,
    pictures: Pictures,
    source: Source,
) -> None:
    path = place.file
    groups = _groups(file, path, mapping)
    first = next(iter(groups.values()))
    cameras = tuple(name for name in _arrays(first) if _is_picture(first, name))
    if not source.cameras and cameras:
        source.cameras = cameras
        if chosen_camera(mapping.picture, cameras) is None:
            source.notes.append(f"cameras, not read: {', '.join(cameras)} (choose with --picture)")
    camera = chosen_camera(mapping.picture, cameras)
    key = _path_key(first, path, mapping)
    if f"path: {key}" not in source.notes:
        source.notes.append(f"path: {key}")
    splits = _splits(file)
    alone = len(groups) == 1 and next(iter(groups)) == path.stem
    for i, (own, group) in enumerate(groups.items()):
        name = own if place.name is None else place.name if alone else f"{place.name}-{own}"
        recording = replace(_recording(group, name, key, path), folders=place.folders)
        if camera is not None:
            scene = f"scene-{name}"
            source.scenes[scene] = RawScene(
                scene, load=_loader(path, group.name, camera, name, pictures),
                split=splits.get(own),
            )  # fmt: skip
            recording = replace(recording, scene=scene)
        source.recordings.append(recording)
        if place.name is None:
            progress("read", i + 1, len(groups))


def _groups(file: Any, path: Path, mapping: Mapping) -> dict[str, Any]:
    """The groups that hold a demonstration each: those in ``data``, else those at the root; or
    the root itself, where what it holds are parts of one."""
    import h5py

    parent = file
    if isinstance(_item(file, "data"), h5py.Group):
        parent = _item(file, "data")
    groups = {n: _item(parent, n) for n in parent if isinstance(_item(parent, n), h5py.Group)}
    groups = {n: g for n, g in groups.items() if n != "mask"}
    key = mapping.path
    own = key is not None and isinstance(_item(parent, key), h5py.Dataset)
    if own or any(n in _PARTS for n in groups) or (not groups and any(_arrays(parent))):
        return {path.stem: parent}
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


def _is_picture(group: Any, name: str) -> bool:
    """Whether a dataset holds frames: (T, h, w, 3) bytes, or (T, n) bytes of JPEG."""
    item = _item(group, name)
    if item is None or item.dtype != np.uint8 or not item.shape or item.shape[0] < 1:
        return False
    if len(item.shape) == 4:
        return bool(item.shape[-1] == 3)
    return len(item.shape) == 2 and item.shape[1] > 3 and bytes(item[0, :3]) == _JPEG


def _path_key(group: Any, path: Path, mapping: Mapping) -> str:
    known = _arrays(group)
    if mapping.path is not None:
        if mapping.path not in known:
            raise InputError(f"a dataset {mapping.path}", ", ".join(known) or "none", file=path,
                             row=group.name, field="path")  # fmt: skip
        return mapping.path
    usual = [name for name in (_PATHS if mapping.robot is None else _JOINTS) if name in known]
    narrow = [name for name in usual if _item(group, name).shape[1:] in ((2,), (3,))]
    if mapping.robot is None and len(narrow) > 1:
        raise InputError("one dataset for the path; say which: --path NAME", ", ".join(narrow),
                         file=path, row=group.name, field="path")  # fmt: skip
    if usual:
        return usual[0] if mapping.robot is not None else (narrow or usual)[0]
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
    t, clock = None, None
    steps = [(n,) for n in (len(points), len(points) - 1)]  # flags may have one less: one a step
    for other in _arrays(group):
        item = _item(group, other)
        if other == key or item.dtype.kind not in "biuf":
            continue
        if item.shape in steps or (
            item.ndim == 2 and item.shape[1] == 1 and item.shape[:1] in steps
        ):
            values = _load(item, path, name, other).reshape(-1)
            fields[other] = values
            whole = len(values) == len(points) and values.dtype.kind in "iuf"
            said = column_name(other.rsplit("/", 1)[-1])
            if whole and t is None and (other in _TIMES or said.quantity == "time"):
                t, clock = values.astype(np.float64), Clock(other, said.unit)
        elif item.size == 1:
            fields[other] = _load(item, path, name, other).reshape(-1)[0].item()
    columns = tuple(str(i) for i in range(points.shape[1]))
    turn = _item(group, f"{key.removesuffix('_pos')}_quat")
    if key.endswith("eef_pos") and points.shape[1] == 3 and turn is not None:
        quaternion = _load(turn, path, name, f"{key.removesuffix('_pos')}_quat")
        if quaternion.shape == (len(points), 4):  # robosuite's order: x, y, z, w
            points = np.concatenate([points, quaternion], axis=1)
            columns = ("x", "y", "z", "qx", "qy", "qz", "qw")
    return Recording(name, points, columns, t=t, clock=clock, fields=fields, file=path, row=name)


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
        return value.reshape(-1)[0].item() if value.size == 1 else value.reshape(-1).tolist()
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
                if not _is_picture(file[group], camera):
                    raise InputError("8-bit RGB frames (T, h, w, 3) or JPEG", "something else",
                                     file=path, row=name, field=camera)  # fmt: skip
                if len(item.shape) == 2:
                    data = io.BytesIO(np.asarray(item[0]).tobytes())
                    return pictures.keep(name, decoded(data, path, name))
                if item.shape[1] * item.shape[2] > 64_000_000:
                    raise InputError("frames of at most 64000000 pixels", item.shape, file=path,
                                     row=name, field=camera)  # fmt: skip
                return pictures.keep(name, np.ascontiguousarray(item[0]))
        except (OSError, RuntimeError, KeyError, ValueError, MemoryError) as error:
            raise InputError("an HDF5 file", str(error), file=path, row=name) from error

    return load
