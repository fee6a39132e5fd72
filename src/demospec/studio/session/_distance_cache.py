"""What paths do past objects, remembered: a new stroke is measured alone."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from typing import Any, Generic, TypeVar

import numpy as np

from demospec.frames import FloatArray
from demospec.rules import FitMemory, Passes, nearest_approach, passes
from demospec.scene import Scene

_KEPT = 50_000  # paths: some 10 MB of distances

Row = TypeVar("Row")


class _Rows(Generic[Row]):
    """The last answers about single paths past the objects of a scene. For many threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        # The objects are held beside the row, so that their id stays theirs.
        self._rows: OrderedDict[Hashable, tuple[Any, Row]] = OrderedDict()

    def of(
        self,
        scene: Scene,
        paths: Any,
        about: tuple[Hashable, ...],
        answer: Callable[[list[Any]], Sequence[Row]],
    ) -> list[Row]:
        """A row a path; `answer` gives those of the paths that were never asked about."""
        keys = [(id(scene.objects), *about, path_digest(path)) for path in paths]
        with self._lock:
            known = {k: self._rows[k][1] for k in keys if k in self._rows}
        new = {k: i for i, k in enumerate(keys) if k not in known}
        if new:
            found = dict(zip(new, answer([paths[i] for i in new.values()]), strict=True))
            known |= found
            with self._lock:
                for key, row in found.items():
                    self._rows[key] = (scene.objects, row)
                while len(self._rows) > _KEPT:
                    self._rows.popitem(last=False)
        return [known[k] for k in keys]


class NearMemory:
    """Called as `nearest_approach`, and gives the same."""

    def __init__(self) -> None:
        self._rows = _Rows[FloatArray]()

    def __call__(
        self, scene: Scene, paths: Any, symbols: Sequence[str], *, distance: Any = "footprint"
    ) -> FloatArray:
        def answer(new: list[Any]) -> Sequence[FloatArray]:
            return list(nearest_approach(scene, new, symbols, distance=distance).copy())

        rows = self._rows.of(scene, paths, (tuple(symbols), distance), answer)
        return np.array(rows).reshape(len(rows), len(symbols))


class PassMemory:
    """Called as `passes`, and gives the same."""

    def __init__(self) -> None:
        self._rows = _Rows[Passes]()

    def __call__(
        self,
        scene: Scene,
        paths: Any,
        symbols: Sequence[str],
        *,
        distance: Any = "footprint",
        unit: float = 1.0,
    ) -> Passes:
        def answer(new: list[Any]) -> Sequence[Passes]:
            return passes(scene, new, symbols, distance=distance, unit=unit).one_by_one()

        rows = self._rows.of(scene, paths, (tuple(symbols), distance, unit), answer)
        return Passes.stacked(rows)


def path_digest(path: Any) -> bytes:
    """Equal for equal paths in the plane."""
    xy = np.ascontiguousarray(np.asarray(path, dtype=np.float64)[:, :2])
    return hashlib.blake2b(xy.tobytes(), digest_size=16).digest()


near = NearMemory()
"""The memory of distances that all tabs share."""

passing = PassMemory()
"""The memory of passes that all tabs share."""

fits = FitMemory()
"""The memory of single people's fits that all tabs share."""
