"""Detection: the objects of a picture in the set format, with symbols and confidence.

The paper assumes an object detector; here is one. Rules then work from pictures alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import CannotJudgeError
from demospec.perception._observation import Observation
from demospec.perception.heads._symbols import SymbolHead, class_probabilities
from demospec.perception.inference._observe import observe
from demospec.progress import Progress, silent
from demospec.scene import Image, Polygon, Scene, SceneObject

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

LEAST_CONFIDENCE = 0.5
"""Detections less sure than this are not listed."""


@dataclass(frozen=True)
class DetectedObject(SceneObject):
    """A `SceneObject` that was detected, not listed.

    Args:
        confidence: In [0, 1]: probability that an object is there and is a `symbol`, by the symbol
            head; without a head, that an object is there.
        symbols: Every symbol (or generic word) → probability.
    """

    confidence: float = 1.0
    symbols: tuple[tuple[str, float], ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As in the set format, with `confidence` and the runners-up."""
        runners = {name: round(p, 4) for name, p in self.symbols}
        return {
            **super().to_json(),
            "confidence": round(self.confidence, 4),
            "symbols": runners,
        }


def detect_objects(
    picture: Image | Scene | Observation,
    *,
    network: DistanceNet | None = None,
    head: SymbolHead | None = None,
    least: float = LEAST_CONFIDENCE,
    scale: float | None = None,
) -> list[DetectedObject]:
    """The objects in a picture, largest first; an empty list is an empty table.

    Args:
        picture: (h, w, 3) uint8 of any size, a scene with a picture, or what `observe` gave.
        network: The shipped one by default.
        head: Names the symbols, see `fit_symbol_head`. Without one the symbols are generic
            words (`KINDS`), which say what an object looks like and not what anybody calls it.
        least: Objects of lower confidence that something is there are left out, in [0, 1].
        scale: See `observe`.

    Raises:
        CannotJudgeError: A scene without a picture.
    """
    observation = picture
    if not isinstance(observation, Observation):
        observation = _observed(observation, network, scale)
    found: list[DetectedObject] = []
    count: dict[str, int] = {}
    detections = observation.detections
    for detection, names in zip(detections, class_probabilities(detections, head), strict=True):
        there = sum(names.values())
        if there < least:
            continue
        ranked = tuple(sorted(names.items(), key=lambda pair: -pair[1]))
        symbol, p = ranked[0]
        number = count.get(symbol, 0)
        count[symbol] = number + 1
        found.append(
            DetectedObject(
                id=f"{symbol}-{number}",
                symbol=symbol,
                center=(round(detection.center[0], 3), round(detection.center[1], 3)),
                bbox=tuple(round(v, 3) for v in detection.bbox),  # type: ignore[arg-type]
                footprint=Polygon(np.round(detection.polygon, 3)),
                confidence=float(there if head is None else p),
                symbols=ranked[:3],
            )
        )
    return found


def _observed(
    picture: Image | Scene, network: DistanceNet | None, scale: float | None
) -> Observation:
    if isinstance(picture, Scene):
        picture = picture.pixels()
    return observe(picture, network=network, scale=scale)


def detect_in_set(
    data: DemonstrationSet,
    *,
    network: DistanceNet | None = None,
    head: SymbolHead | None = None,
    least: float = LEAST_CONFIDENCE,
    progress: Progress = silent,
) -> tuple[DemonstrationSet, tuple[str, ...]]:
    """The set with what is detected in its pictures in place of what its scenes listed.

    A head from the set's own training lists (`fit_symbol_head`) keeps its symbols; generic
    words are added to the set's symbols where no head is given.

    Returns:
        (set, ids of scenes without a picture, which are left as they are).

    Raises:
        CannotJudgeError: No scene has a picture.
    """
    skipped = tuple(s.scene_id for s in data.scenes if s.picture is None)
    if len(skipped) == len(data.scenes):
        raise CannotJudgeError("scenes with pictures", "none", field="scenes")
    scenes = []
    for number, scene in enumerate(data.scenes):
        if scene.picture is not None:
            found = detect_objects(scene, network=network, head=head, least=least)
            scene = replace(scene.seen(), objects=tuple(found))
        scenes.append(scene)
        progress("observing the scenes", number + 1, len(data.scenes))
    used = {item.symbol for scene in scenes for item in scene.objects or ()}
    symbols = (*data.symbols, *sorted(used - set(data.symbols)))
    return replace(data, scenes=tuple(scenes), symbols=symbols), skipped
