"""Training of a symbol head: appearance of detections in scenes that list their objects."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.perception._canonical import turned_array
from demospec.perception._observation import Observation
from demospec.perception.heads._symbols import NOTHING, SymbolHead, match_detections
from demospec.perception.inference._observe import observe
from demospec.progress import Progress, silent
from demospec.scene import Picture, Scene

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

_TURNS = (1, 2, 3, 4, 5, 6, 7)
_VIEWS = 3  # beside the scene as it is


def fit_symbol_head(
    scenes: Iterable[Scene],
    *,
    network: DistanceNet | None = None,
    scale: float | None = None,
    seed: int = 0,
    observations: Sequence[Observation] | None = None,
    progress: Progress = silent,
) -> SymbolHead | None:
    """A head that names symbols as these scenes do; None where none of them lists an object.

    Every scene is also observed turned, mirrored and recoloured: that changes the appearance a
    little and, unlike for distances, does no harm here. All views of one object count as one.

    Args:
        scenes: Those with a picture and a list are used.
        network: The shipped one by default.
        scale: Map pixels per picture pixel, see `observe`.
        seed: Of turns and colours.
        observations: Of these scenes, where they have been observed already.
        progress: Told the scenes used.
    """
    every = list(scenes)
    given = observations if observations is not None else [None] * len(every)
    usable = [
        (scene, known)
        for scene, known in zip(every, given, strict=True)
        if scene.picture is not None and scene.objects
    ]
    rng = np.random.default_rng([seed, 77])
    examples = _Examples()
    for number, (scene, known) in enumerate(usable):
        observation = known or observe(scene.pixels(), network=network, scale=scale)
        examples.add(scene, observation)
        for turn in rng.permutation(_TURNS)[:_VIEWS]:
            turned = turned_scene(scene, int(turn), rng)
            view = observe(turned.pixels(), network=network, scale=scale, turns=(0,))
            examples.add(turned, view)
        progress("learning the symbols", number + 1, len(usable))
    return examples.fitted()


class _Examples:
    """Appearance features, their symbols and weights."""

    def __init__(self) -> None:
        self.appearance: list[NDArray[np.float32]] = []
        self.symbols: list[str] = []
        self.weights: list[float] = []

    def add(self, scene: Scene, observation: Observation) -> None:
        """Every detection in a listed scene."""
        objects = scene.objects or ()
        owner, largest = match_detections(observation, objects)
        for i, detection in enumerate(observation.detections):
            self.appearance.append(detection.appearance)
            self.symbols.append(objects[owner[i]].symbol if owner[i] >= 0 else NOTHING)
            # Segments are met at test time too, but the whole object counts more.
            whole = owner[i] < 0 or largest[owner[i]] == i
            self.weights.append(1.0 if whole else 0.5)

    def fitted(self) -> SymbolHead | None:
        """The head; None where no symbol was seen."""
        if not any(symbol != NOTHING for symbol in self.symbols):
            return None
        weight = np.array(self.weights) / (1.0 + _VIEWS)
        # A ridge of 1 tells unseen items apart better than 3: log-loss 0.14 against 0.17.
        return SymbolHead.fit(np.stack(self.appearance), self.symbols, weight, ridge=1.0)


def turned_scene(scene: Scene, turn: int, rng: np.random.Generator) -> Scene:
    """The scene turned (as `turned_array` does) with its outlines, and slightly recoloured."""
    pixels = scene.pixels()
    height, width = pixels.shape[:2]
    planes = turned_array(pixels.transpose(2, 0, 1), turn).transpose(1, 2, 0)
    gain = rng.uniform(0.85, 1.15) * rng.uniform(0.94, 1.06, 3)
    painted = np.clip((planes / 255.0) ** rng.uniform(0.85, 1.2) * gain * 255, 0, 255)

    def moved(p: FloatArray) -> FloatArray:
        x, y = p[:, 0], p[:, 1]
        w, h = width, height
        for _ in range(turn % 4):  # a quarter turn as np.rot90 does it
            x, y = y, w - x
            w, h = h, w
        if turn >= 4:
            x = w - x
        return np.stack([x, y], axis=1)

    corner = moved(np.zeros((1, 2)))[0]
    matrix = (moved(np.eye(2)) - corner).T
    objects = tuple(item.mapped(matrix, corner) for item in scene.objects or ())
    picture = Picture(array=painted.astype(np.uint8))
    return replace(scene.seen(), objects=objects, picture=picture)
