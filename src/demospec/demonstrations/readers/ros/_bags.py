"""Bags on disk: folders and files, SQLite, MCAP or ROS 1, metadata of any version."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path
from typing import Any

from demospec.demonstrations.readers.ros._bag import Bag, Messages
from demospec.demonstrations.readers.ros._mcap import open_mcap
from demospec.errors import InputError, MissingExtraError

_STORAGE = (".mcap", ".db3")


def bag_files(path: Path) -> list[Path]:
    """The bags at `path`: itself, or those below it (a ROS 2 bag is a folder)."""
    if path.is_file() or (path / "metadata.yaml").is_file():
        return [path]
    found: list[Path] = []
    for base, folders, names in os.walk(path, followlinks=False):
        folders.sort()
        if "metadata.yaml" in names:
            found.append(Path(base))
            folders.clear()
            continue
        found += [Path(base) / n for n in sorted(names) if n.endswith((".bag", *_STORAGE))]
    if not found:
        raise InputError("bags (metadata.yaml, .mcap, .db3 or .bag)", "none", file=path)
    return found


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """Opens a ROS 2 bag (folder), a bare ``.mcap`` or ``.db3`` file, or a ROS 1 ``.bag``.

    Raises:
        InputError: Broken, or of a kind that is not known.
        MissingExtraError: The library that reads it is not installed.
    """
    opener: Callable[[Path], AbstractContextManager[Bag]]
    opener = open_mcap if path.is_file() and path.suffix.lower() == ".mcap" else _rosbags
    if path.is_dir() and (any(path.glob("*.mcap")) or not _is_known_version(path)):
        opener = _storage_files
    try:
        with opener(path) as bag:
            yield bag
    except (InputError, MissingExtraError):
        raise
    except Exception as error:
        # Both libraries raise dozens of kinds (struct.error, zlib.error, sqlite3.Error, …) on
        # broken files.
        text = str(error) or type(error).__name__
        raise InputError("a readable bag", text, file=path) from error


def _is_known_version(folder: Path) -> bool:
    """Whether rosbags reads the bag's ``metadata.yaml``; what it cannot read otherwise it says."""
    try:
        from rosbags.rosbag2 import Reader, ReaderError
    except ImportError as error:
        raise MissingExtraError("rosbags", "ros", "a ROS bag") from error
    try:
        with Reader(folder):
            return True
    except ReaderError as error:
        return "version" not in str(error)
    except Exception:  # broken in another way: opening it says how
        return True


@contextmanager
def _storage_files(folder: Path) -> Iterator[Bag]:
    """A bag by its storage files alone: those of MCAP say all that ``metadata.yaml`` repeats, and
    metadata of a newer version than rosbags knows need not be understood."""
    files = sorted(p for p in folder.iterdir() if p.suffix.lower() in _STORAGE)
    if not files:
        raise InputError("storage files (.mcap or .db3)", "none", file=folder)
    with ExitStack() as stack:
        bags = [
            stack.enter_context(open_mcap(f) if f.suffix.lower() == ".mcap" else _rosbags(f))
            for f in files
        ]
        topics: dict[str, tuple[str, ...]] = {}
        for bag in bags:
            for topic, kinds in bag.topics.items():
                topics[topic] = tuple(dict.fromkeys([*topics.get(topic, ()), *kinds]))

        def messages(wanted: list[str]) -> Messages:
            import heapq

            yield from heapq.merge(*(b.messages(wanted) for b in bags), key=lambda m: m[1])

        yield Bag(topics, messages)


@contextmanager
def _rosbags(path: Path) -> Iterator[Bag]:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("rosbags", "ros", "a ROS bag") from error
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([path], default_typestore=store) as reader:

        def messages(topics: list[str]) -> Messages:
            chosen = [c for c in reader.connections if c.topic in topics]
            if not chosen:  # an empty choice would be all of them
                return
            for connection, nanoseconds, data in reader.messages(connections=chosen):
                message: Any = reader.deserialize(data, connection.msgtype)
                yield connection.topic, nanoseconds * 1e-9, message

        kinds: dict[str, list[str]] = {}
        for connection in reader.connections:
            kinds.setdefault(connection.topic, []).append(connection.msgtype)
        yield Bag({t: tuple(dict.fromkeys(k)) for t, k in kinds.items()}, messages)
