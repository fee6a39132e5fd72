"""Distances from paths to objects, remembered: a new stroke is measured alone."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Sequence
from typing import Any

import numpy as np

from demospec.frames import FloatArray
from demospec.rules import nearest_approach
from demospec.scene import Scene

_KEPT = 50_000  # paths: some 10 MB


class NearMemory:
    """Called as `nearest_approach`, and gives the same. For any number of threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        # The objects are held beside the row, so that their id stays theirs.
        self._rows: OrderedDict[tuple[Any, ...], tuple[Any, FloatArray]] = OrderedDict()

    def __call__(
        self, scene: Scene, paths: Any, symbols: Sequence[str], *, distance: Any = "footprint"
    ) -> FloatArray:
        about = (id(scene.objects), tuple(symbols), distance)
        keys = [(*about, path_digest(path)) for path in paths]
        with self._lock:
            known = {i: self._rows[k][1] for i, k in enumerate(keys) if k in self._rows}
        new = [i for i in range(len(keys)) if i not in known]
        out = np.empty((len(keys), len(symbols)))
        if new:
            out[new] = nearest_approach(scene, [paths[i] for i in new], symbols, distance=distance)
        for i, row in known.items():
            out[i] = row
        with self._lock:
            for i in new:
                self._rows[keys[i]] = (scene.objects, out[i].copy())
            while len(self._rows) > _KEPT:
                self._rows.popitem(last=False)
        return out


def path_digest(path: Any) -> bytes:
    """Equal for equal paths in the plane."""
    xy = np.ascontiguousarray(np.asarray(path, dtype=np.float64)[:, :2])
    return hashlib.blake2b(xy.tobytes(), digest_size=16).digest()


near = NearMemory()
"""The memory that all tabs share."""
