"""Detection: the objects of a picture in the set format, with symbols and confidence.

The paper assumes an object detector; here is one. Rules then work from pictures alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import CannotJudgeError, InputError
from demospec.perception._detected import DetectedObject
from demospec.perception._observation import Observation
from demospec.perception.heads._familiarity import UNSURE, Familiarity
from demospec.perception.heads._symbols import SymbolHead, class_probabilities
from demospec.perception.inference._observe import observe
from demospec.progress import Progress, silent
from demospec.scene import Image, Polygon, Scene

if TYPE_CHECKING:
    from demospec.perception.detectors import Detector
    from demospec.perception.network._distance_net import DistanceNet

LEAST_CONFIDENCE = 0.5
"""Detections less sure than this are not listed."""


def detect_objects(
    picture: Image | Scene | Observation,
    *,
    network: DistanceNet | None = None,
    head: SymbolHead | None = None,
    least: float = LEAST_CONFIDENCE,
    scale: float | None = None,
) -> list[DetectedObject]:
    """The objects in a picture, largest first; an empty list is an empty table.

    In a picture of an unfamiliar kind nothing is more than 0.6 sure (`Observation.familiarity`).

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
    known = observation.familiarity is None or observation.familiarity.familiar
    most = 1.0 if known else UNSURE
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
                confidence=min(most, float(there if head is None else p)),
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


def detect_with(
    detector: Detector,
    scene: Scene,
    *,
    symbols: Mapping[str, str] | None = None,
    least: float = LEAST_CONFIDENCE,
) -> list[DetectedObject] | None:
    """The objects that a detector finds in a scene's picture; None where it does not know it.

    Args:
        detector: Anything with the protocol `demospec.perception.detectors.Detector`.
        scene: With a picture.
        symbols: The detector's class → symbol; other classes keep their word.
        least: Less sure objects are left out, in [0, 1].

    Raises:
        CannotJudgeError: A scene without a picture.
        InputError: What the detector gave is no list of findings, or lies in no picture.
    """
    from demospec.perception.detectors import Finding, listed

    picture = scene.shown_picture()
    pixels = picture.pixels
    names = [scene.scene_id]
    if picture.file is not None:
        names = [picture.file.name, picture.file.stem, scene.scene_id]
    try:
        found = detector.detect(pixels, tuple(dict.fromkeys(names)))
        if found is None:
            return None
        wrong = [f for f in found if not isinstance(f, Finding)]
        if wrong:
            raise InputError("findings (demospec.perception.detectors.Finding)",
                             type(wrong[0]).__name__)  # fmt: skip
        height, width = pixels.shape[:2]
        return listed(found, (width, height), symbols=symbols, least=least)
    except InputError as error:
        raise error.at(row=f"scene {scene.scene_id}", field=detector.name) from error


def detect_in_set(
    data: DemonstrationSet,
    *,
    network: DistanceNet | None = None,
    head: SymbolHead | None = None,
    detector: Detector | None = None,
    symbols: Mapping[str, str] | None = None,
    least: float = LEAST_CONFIDENCE,
    progress: Progress = silent,
) -> tuple[DemonstrationSet, tuple[str, ...]]:
    """The set with what is detected in its pictures in place of what its scenes listed.

    A head from the set's own training lists (`fit_symbol_head`) keeps its symbols; generic
    words are added to the set's symbols where no head is given, and so are the classes of a
    detector. Each such scene keeps the detector's name and the least confidence as ``detector``
    in its line of the set; of the package's own also whether the picture is ``familiar``.

    Args:
        network, head: Of the package's own detector, which is used where `detector` is None.
        detector, symbols, least: See `detect_with`.

    Returns:
        (set, ids of scenes without a picture, or with one that the detector does not know: they
        are left as they are).

    Raises:
        CannotJudgeError: No scene has a picture.
        InputError: A set that is not in the pixels of its pictures; a detector that knows none
            of the pictures.
    """
    if data.units != "px":
        raise InputError("px (objects are detected in pixels)", data.units, field="units")
    if all(s.picture is None for s in data.scenes):
        raise CannotJudgeError("scenes with pictures", "none", field="scenes")
    scenes, skipped = [], []
    record = {"name": "demospec" if detector is None else detector.name, "least": least}
    for number, scene in enumerate(data.scenes):
        found: list[DetectedObject] | None = None
        known: Familiarity | None = None
        if scene.picture is not None and detector is None:
            observation = _observed(scene, network, None)
            found, known = (
                detect_objects(observation, head=head, least=least),
                observation.familiarity,
            )
        elif scene.picture is not None and detector is not None:
            found = detect_with(detector, scene, symbols=symbols, least=least)
        if found is None:
            skipped.append(scene.scene_id)
        else:
            extra = tuple((k, v) for k, v in scene.extra if k != "detector")
            own = record if known is None else {**record, **known.to_json()}
            scene = replace(scene.seen(), objects=tuple(found), extra=(*extra, ("detector", own)))
        scenes.append(scene)
        progress("observing the scenes", number + 1, len(data.scenes))
    if len(skipped) == len(scenes) and detector is not None:
        some = ", ".join(skipped[:5])
        raise InputError(f"detections for one of the scenes ({some}, …)", "none",
                         field=detector.name)  # fmt: skip
    used = {item.symbol for scene in scenes for item in scene.objects or ()}
    words = (*data.symbols, *sorted(used - set(data.symbols)))
    return replace(data, scenes=tuple(scenes), symbols=words), tuple(skipped)
