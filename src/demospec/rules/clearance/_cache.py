"""Distances from paths that cannot change to objects that cannot change, kept for a while.

The causal analysis and the validity maps judge the same paths in a scene again and again, with
one object more or less each time: only the new object's distances are new.
"""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock

import numpy as np

from demospec.demonstrations import Paths
from demospec.frames import FloatArray
from demospec.scene import SceneObject

_KEEP = 256
_held: OrderedDict[tuple[int, int, str], tuple[Paths, SceneObject, FloatArray]] = OrderedDict()
_lock = Lock()


def constant(paths: Paths) -> bool:
    """Whether nobody can write into these paths: a read-only array that owns its numbers."""
    return isinstance(paths, np.ndarray) and paths.base is None and not paths.flags.writeable


def recall(paths: Paths, item: SceneObject, distance: str) -> FloatArray | None:
    """(n,) distances kept for exactly these objects in memory, or None."""
    with _lock:
        found = _held.get((id(paths), id(item), distance))
        return None if found is None else found[2]


def keep(paths: Paths, item: SceneObject, distance: str, found: FloatArray) -> None:
    """Keeps distances; the entry holds paths and object, so that their ids stay theirs."""
    with _lock:
        _held[id(paths), id(item), distance] = (paths, item, found)
        while len(_held) > _KEEP:
            _held.popitem(last=False)
