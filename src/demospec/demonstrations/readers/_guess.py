"""Which format a source has, from its names and first bytes."""

from __future__ import annotations

from pathlib import Path

from demospec.demonstrations.readers._hdf5 import SUFFIXES as HDF5_SUFFIXES
from demospec.demonstrations.readers.tables._files import SUFFIXES
from demospec.demonstrations.readers.tables._labels import FILES as LABELS
from demospec.errors import InputError

FORMATS = ("demospec", "tables", "json", "lerobot", "hdf5", "ros", "label-studio", "cvat")
"""The formats that `convert` reads, as `--from` names them (lists of objects are `--objects`)."""

_HDF5 = b"\x89HDF\r\n\x1a\n"
_MCAP = b"\x89MCAP0\r\n"


def guess_format(path: Path) -> str:
    """The format of a file or folder.

    Raises:
        InputError: Nothing there, unreadable, or nothing that is known.
    """
    try:
        if path.is_dir():
            return _of_folder(path)
        if path.is_file():
            return _of_file(path)
        found = "no such file or folder" if not path.exists() else "a device"
    except OSError as error:
        raise InputError("a readable source", error.strerror or str(error), file=path) from error
    except ValueError as error:  # a NUL byte in the path
        raise InputError("a readable source", str(error), file=repr(str(path))) from error
    raise InputError("a source to read", found, file=path)


def _of_folder(path: Path) -> str:
    if (path / "dataset.json").is_file():
        return "demospec"
    if (path / "meta" / "info.json").is_file():
        return "lerobot"
    if (path / "metadata.yaml").is_file():
        return "ros"
    if (path / "annotations.xml").is_file():
        return "cvat"
    import os

    seen: dict[str, int] = {}
    for _, folders, names in os.walk(path, followlinks=False):
        folders.sort()
        for name in names:
            if name in LABELS:
                continue
            suffix = Path(name).suffix.lower()
            seen[suffix] = seen.get(suffix, 0) + 1
            if name == "metadata.yaml":
                return "ros"
    if any(s in seen for s in (".mcap", ".bag", ".db3")):
        return "ros"
    if any(s in seen for s in HDF5_SUFFIXES):
        return "hdf5"
    if any(s in seen for s in SUFFIXES):
        return "tables"
    if any(s in seen for s in (".json", ".jsonl")):
        return "json"
    kinds = ", ".join(sorted(s for s in seen if s)[:8]) or "nothing"
    raise InputError(f"a folder of one of the formats {', '.join(FORMATS)}", kinds, file=path)


def _of_file(path: Path) -> str:
    with open(path, "rb") as file:
        head = file.read(4096)
    suffix = path.suffix.lower()
    if head.startswith(_HDF5):
        return "hdf5"
    if head.startswith(_MCAP) or head.startswith(b"#ROSBAG") or suffix == ".db3":
        return "ros"
    if suffix in HDF5_SUFFIXES:
        return "hdf5"
    if suffix in (".mcap", ".bag"):
        return "ros"
    if suffix == ".xml" or head.lstrip().startswith(b"<?xml"):
        return "cvat"
    if suffix in SUFFIXES:
        return "tables"
    if suffix in (".json", ".jsonl"):
        start = head.lstrip()
        drawn = (start.startswith(b"[") and b'"annotations"' in head) or b'"completions"' in head
        return "label-studio" if drawn else "json"
    expected = f"one of the formats {', '.join(FORMATS)} (say which: --from)"
    raise InputError(expected, suffix or "a name without ending", file=path)
