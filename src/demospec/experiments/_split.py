"""Splits: demonstrations held out for judging; seen scenes and unseen scenes apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.demonstrations import DemonstrationSet, ValidityModel, View
from demospec.errors import InputError
from demospec.scene import Scene


def hold_out(
    data: DemonstrationSet, share: float = 0.2, seed: int = 0
) -> tuple[DemonstrationSet, DemonstrationSet]:
    """Splits the demonstrations of every (scene, type) at random: for training, held out.

    The held-out ones are *seen scenes, unseen trajectories*. Groups of fewer than two
    demonstrations are kept whole for training.

    Raises:
        InputError: No group is large enough to hold anything out.
    """
    rng = np.random.default_rng(seed)
    d = data.demonstrations
    groups: dict[tuple[str, str | None], list[int]] = {}
    for i, key in enumerate(zip(d.scene_id, d.type, strict=True)):
        groups.setdefault(key, []).append(i)
    held = np.zeros(len(d), dtype=bool)
    for rows in groups.values():
        count = min(len(rows) - 1, max(1, round(share * len(rows))))
        held[rng.permutation(rows)[: max(count, 0)]] = True
    if not held.any():
        raise InputError("two demonstrations of a type in a scene", "one", field="demonstrations")
    return data.select(~held), data.select(held)


def without_objects(scenes: Sequence[Scene]) -> tuple[Scene, ...]:
    """The scenes as a camera delivers them: pictures without lists of objects."""
    return tuple(s.seen() for s in scenes)


class PicturesOnly:
    """A model that is shown the pictures of scenes and never their lists of objects.

    Some models take a list where a scene has one. Here they have to see for themselves, also
    in scenes whose lists an intervention or the truth needs.
    """

    def __init__(self, model: ValidityModel) -> None:
        self.model = model

    @property
    def types(self) -> tuple[str, ...]:
        return self.model.types

    def see(self, scene: Scene) -> View:
        """Look at the picture alone; CannotJudgeError where there is none."""
        return self.model.see(scene.seen())
