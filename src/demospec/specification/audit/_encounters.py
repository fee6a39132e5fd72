"""How near every path came to the things around it: by the scenes' lists, else by their pictures.

A list is exact. What a picture shows is not: a thing may be missed or taken for another, and
its rim is known to about a hundredth of the table; `Approaches.error` says which is which.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.errors import MissingExtraError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.rules import nearest_approach

SEEN_ERROR = 0.7
"""Standard deviation of a seen distance, hundredths of the table: about what calibration on
listed outlines finds. A rim that is wrong by a pixel must not make a label look wrong."""


@dataclass(frozen=True)
class Approaches:
    """Nearest approaches of the n demonstrations of a set to things of K classes.

    Args:
        names: The set's symbols; the body's generic words where no scene lists an object.
        nearest: (n, K) set units; +inf where no such thing is.
        known: (n,) whether they could be told.
        seen: (n,) whether from a picture.
        why_not: Why pictures were not looked at, or None.
    """

    names: tuple[str, ...]
    nearest: FloatArray
    known: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    why_not: str | None = None

    def distances(self, row: int) -> dict[str, float]:
        """Class → nearest approach of one demonstration."""
        return dict(zip(self.names, self.nearest[row].tolist(), strict=True))


def approaches(
    data: DemonstrationSet,
    wanted: NDArray[np.bool_],
    *,
    seed: int = 0,
    progress: Progress = silent,
) -> Approaches:
    """Of the wanted demonstrations, from lists where there are any, from pictures otherwise.

    Where some scenes list their objects, things that pictures show are given those names.
    """
    listed = any(scene.objects is not None for scene in data.scenes)
    names = data.symbols
    n = len(data.demonstrations)
    known, seen = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    nearest = np.full((n, len(names)), np.inf)
    unlisted: dict[str, NDArray[np.int64]] = {}
    for scene_id, rows in data.rows_by_scene().items():
        mine = rows[wanted[rows]]
        scene = data.scene(scene_id)
        if not len(mine):
            continue
        if scene.objects is not None:
            paths = data.demonstrations.paths_xy(mine)
            nearest[mine] = nearest_approach(scene, paths, names)
            known[mine] = True
        elif scene.picture is not None:
            unlisted[scene_id] = mine
    if not unlisted:
        return Approaches(names, nearest, known, seen)
    try:
        names, rows_seen, distances = _look(data, unlisted, listed, seed, progress)
    except MissingExtraError as error:
        return Approaches(names, nearest, known, seen, str(error))
    if not listed:
        nearest = np.full((n, len(names)), np.inf)
    nearest[rows_seen] = distances
    known[rows_seen] = seen[rows_seen] = True
    return Approaches(names, nearest, known, seen)


def _look(
    data: DemonstrationSet,
    unlisted: dict[str, NDArray[np.int64]],
    listed: bool,
    seed: int,
    progress: Progress,
) -> tuple[tuple[str, ...], NDArray[np.int64], FloatArray]:
    """(names, rows, distances (rows, K)) of the demonstrations in scenes without lists."""
    from demospec.perception import KINDS, load_body
    from demospec.specification.models.perceived_rule._fit import calibrate, fit_head, look_at_all
    from demospec.specification.models.perceived_rule._observation import (
        Calibration,
        nearest_in_parts,
        seen_parts,
        sight_of,
    )

    body = load_body()
    names: tuple[str, ...] = KINDS
    head, calibration = None, Calibration({}, {})
    if listed:
        examples = [s for s in data.scenes if s.objects and s.picture is not None]
        looked = look_at_all(examples, body, None)
        head, calibration = fit_head(looked, body, None, seed), calibrate(looked, None, seed)
        names = data.symbols
    rows: list[NDArray[np.int64]] = []
    distances: list[FloatArray] = []
    for done, (scene_id, mine) in enumerate(unlisted.items()):
        if listed and head is None:
            break  # nobody could say what these things are called
        sight = sight_of(data.scene(scene_id), body, None)
        parts = seen_parts(sight, head, calibration)
        size = (float(sight.size_px[0]), float(sight.size_px[1]))
        paths = list(data.demonstrations.paths_xy(mine))
        rows.append(mine)
        distances.append(nearest_in_parts(parts, size, paths, names))
        progress("looking at the scenes", done + 1, len(unlisted))
    if not rows:
        return names, np.zeros(0, dtype=np.int64), np.zeros((0, len(names)))
    return names, np.concatenate(rows), np.concatenate(distances)
