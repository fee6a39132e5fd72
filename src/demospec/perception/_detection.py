"""Detection: the body's slots as the objects of a scene, with symbols and confidence.

The paper assumes an object detector; here the slots are one. Rules then work from pictures
alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.errors import CannotJudgeError
from demospec.perception._observation import Sight, Slot
from demospec.perception.heads._symbols import NOTHING, SymbolHead, match_slots
from demospec.perception.inference._observe import look
from demospec.progress import Progress, silent
from demospec.scene import Image, Polygon, Scene, SceneObject

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import Body

LEAST_CONFIDENCE = 0.5
"""Parts less sure than this are not listed."""


@dataclass(frozen=True)
class DetectedObject(SceneObject):
    """A `SceneObject` that was seen, not listed.

    Args:
        confidence: In [0, 1]: probability that a thing is there and is called `symbol`, as far
            as the symbol head knows; without a head, that a thing is there.
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
    picture: Image | Scene | Sight,
    *,
    body: Body | None = None,
    head: SymbolHead | None = None,
    least: float = LEAST_CONFIDENCE,
    scale: float | None = None,
) -> list[DetectedObject]:
    """The objects in a picture, largest first; an empty list is an empty table.

    Args:
        picture: (h, w, 3) uint8 of any size, a scene with a picture, or what `look` gave.
        body: The shipped one by default.
        head: Names the symbols, see `fit_symbol_head`. Without one the symbols are generic
            words (`KINDS`), which say what a thing looks like and not what anybody calls it.
        least: Objects of lower confidence that something is there are left out, in [0, 1].
        scale: See `look`.

    Raises:
        CannotJudgeError: A scene without a picture.
    """
    sight = picture if isinstance(picture, Sight) else _seen(picture, body, scale)
    found: list[DetectedObject] = []
    count: dict[str, int] = {}
    for slot, names in zip(sight.slots, _names(sight.slots, head), strict=True):
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
                center=(round(slot.center[0], 3), round(slot.center[1], 3)),
                bbox=tuple(round(v, 3) for v in slot.bbox),  # type: ignore[arg-type]
                footprint=Polygon(np.round(slot.polygon, 3)),
                confidence=float(there if head is None else p),
                symbols=ranked[:3],
            )
        )
    return found


def _seen(picture: Image | Scene, body: Body | None, scale: float | None) -> Sight:
    if isinstance(picture, Scene):
        if picture.picture is None:
            raise CannotJudgeError(
                "a picture", "none", row=f"scene {picture.scene_id}", field="file_name"
            )
        picture = picture.pixels()
    return look(picture, body=body, scale=scale)


def _names(slots: Sequence[Slot], head: SymbolHead | None) -> Iterable[dict[str, float]]:
    from demospec.perception.synthetic._things import KINDS

    if head is None or not slots:
        for slot in slots:
            yield {k: float(slot.confidence * p) for k, p in zip(KINDS, slot.kinds, strict=True)}
        return
    for row in head.probabilities(np.stack([slot.looks for slot in slots])):
        yield {n: float(p) for n, p in zip(head.classes, row, strict=True) if n != NOTHING}


def fit_symbol_head(
    scenes: Iterable[Scene], *, body: Body | None = None, progress: Progress = silent
) -> SymbolHead | None:
    """A head that names symbols as these scenes do; None where none of them lists an object.

    Args:
        scenes: Those with a picture and a list are used, each as it is and turned three ways.
    """
    looks: list[NDArray[np.float32]] = []
    names: list[str] = []
    weights: list[float] = []
    usable = [s for s in scenes if s.picture is not None and s.objects]
    for number, scene in enumerate(usable):
        objects = scene.objects or ()
        sight = look(scene.pixels(), body=body)
        owner, largest = match_slots(sight, objects)
        turned = [_looks_turned(scene.pixels(), turn, body) for turn in (1, 2, 4)]
        for i, slot in enumerate(sight.slots):
            name = objects[owner[i]].symbol if owner[i] >= 0 else NOTHING
            whole = owner[i] < 0 or largest[owner[i]] == i
            views = [slot.looks, *(_alike(slot, sight, view) for view in turned)]
            seen = [view for view in views if view is not None]
            looks += seen
            names += [name] * len(seen)
            weights += [(1.0 if whole else 0.5) / len(seen)] * len(seen)
        progress("learning the symbols", number + 1, len(usable))
    if not any(name != NOTHING for name in names):
        return None
    return SymbolHead.fit(np.stack(looks), names, np.array(weights))


def _looks_turned(pixels: Image, turn: int, body: Body | None) -> tuple[Sight, int]:
    from demospec.perception.inference._observe import turned_array

    planes = turned_array(pixels.transpose(2, 0, 1), turn).transpose(1, 2, 0)
    return look(np.ascontiguousarray(planes), body=body, turns=(0,)), turn


def _alike(slot: Slot, sight: Sight, view: tuple[Sight, int]) -> NDArray[np.float32] | None:
    """Looks of the same thing in a turned picture: the slot that covers most of it."""
    from demospec.perception.inference._observe import turned_back

    mask = slot.distance < 0
    best, found = 0.5, None
    for other in view[0].slots:
        theirs = turned_back(other.distance, view[1]) < 0
        share = float((mask & theirs).sum() / max(1, (mask | theirs).sum()))
        if share > best:
            best, found = share, other.looks
    return found


def detect_in_set(
    data: DemonstrationSet,
    *,
    body: Body | None = None,
    head: SymbolHead | None = None,
    least: float = LEAST_CONFIDENCE,
    progress: Progress = silent,
) -> tuple[DemonstrationSet, tuple[str, ...]]:
    """The set with what is seen in its pictures in place of what its scenes listed.

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
            found = detect_objects(scene, body=body, head=head, least=least)
            scene = replace(scene.seen(), objects=tuple(found))
        scenes.append(scene)
        progress("looking at the scenes", number + 1, len(data.scenes))
    used = {item.symbol for scene in scenes for item in scene.objects or ()}
    symbols = (*data.symbols, *sorted(used - set(data.symbols)))
    return replace(data, scenes=tuple(scenes), symbols=symbols), skipped
