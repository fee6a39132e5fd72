"""Perceived objects of a scene: by its list where it has one, else by its picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths, densify
from demospec.errors import CannotJudgeError
from demospec.frames import FloatArray
from demospec.geometry import read_map
from demospec.perception import KINDS, Observation, SymbolHead, class_probabilities, observe
from demospec.scene import Footprint, Scene
from demospec.specification.models.perceived_rule._view import PerceivedObject

if TYPE_CHECKING:
    from demospec.perception import DistanceNet

LISTED_ERROR = 0.15
"""Distance error of a listed outline (percent of the table): the list is not the truth."""

SEEN_ERROR = 0.7
"""Standard deviation of a perceived distance, percent of the table: about what calibration on
listed outlines finds. A rim that is wrong by a pixel must not make a label look wrong."""

_GRID = 100
_AROUND = 6.0  # percent of the table
_LEAST_ERROR = 0.1  # likewise; nowhere is a perceived rim known better


@dataclass(frozen=True)
class Calibration:
    """How the network's distances at the clearance compare with the listed outlines.

    Args:
        bias: Class → perceived − listed distance, percent of the table.
        error: Class → standard deviation of it, likewise, where the uncertainty is as usual.
        other_bias, other_error: For classes never calibrated.
    """

    bias: Mapping[str, float]
    error: Mapping[str, float]
    other_bias: float = 0.0
    other_error: float = 0.6

    def of_classes(self, classes: Mapping[str, float]) -> tuple[float, float]:
        """Bias and error of an object of uncertain class, percent of the table."""
        total = sum(classes.values())
        if total <= 0:
            return self.other_bias, self.other_error
        bias = sum(p * self.bias.get(n, self.other_bias) for n, p in classes.items()) / total
        error = sum(p * self.error.get(n, self.other_error) for n, p in classes.items()) / total
        return bias, error


def perceived_objects(
    observation: Observation, head: SymbolHead | None, calibration: Calibration
) -> tuple[PerceivedObject, ...]:
    """The detections of a picture, distances corrected by the calibration."""
    unit, uncertainty = observation.percent_px, observation.uncertainty
    detections = observation.detections
    perceived = []
    for detection, classes in zip(detections, class_probabilities(detections, head), strict=True):
        bias, error = calibration.of_classes(classes)
        distance = detection.distance - np.float32(bias * unit)
        # Of this object as a whole, where its clearance may be; the rest is place by place.
        around = (detection.distance > 0) & (detection.distance < _AROUND * unit)
        usual = float(np.median(uncertainty[around])) if around.any() else 1.0
        least = _LEAST_ERROR / (error * usual)
        ratio = np.maximum(uncertainty / usual, least).astype(np.float32)
        perceived.append(
            PerceivedObject(distance, classes, error * unit * usual, detection.center, False, ratio)
        )
    return tuple(perceived)


def listed_objects(
    scene: Scene, size: tuple[float, float], shape: tuple[int, int]
) -> tuple[PerceivedObject, ...]:
    """The scene's own list, exact on the grid."""
    error = LISTED_ERROR * max(size) / 100.0
    return tuple(
        PerceivedObject(
            _outline_map(item.outline, size, shape),  # type: ignore[arg-type]  # it is hashable
            {item.symbol: 1.0},
            error,
            item.center,
            True,
        )
        for item in scene.listed_objects()
    )


@lru_cache(maxsize=128)
def _outline_map(
    outline: Footprint, size: tuple[float, float], shape: tuple[int, int]
) -> NDArray[np.float32]:
    """(h, w) signed distance to an outline; kept, because interventions leave most objects."""
    height, width = shape
    y, x = np.mgrid[0:height, 0:width]
    points = np.stack([(x + 0.5) * (size[0] / width), (y + 0.5) * (size[1] / height)], axis=-1)
    found = outline.signed_distance(points).astype(np.float32)
    found.setflags(write=False)
    return found


def span_of(scene: Scene) -> tuple[float, float]:
    """(width, height) that a scene spans: its picture's, else what its list and ends need."""
    if scene.size_px is not None:
        return float(scene.size_px[0]), float(scene.size_px[1])
    far = [(*scene.start[:2], *scene.start[:2]), (*scene.goal[:2], *scene.goal[:2])]
    far += [item.outline.bounds for item in scene.objects or ()]
    corner = np.array(far)[:, 2:].max(axis=0)
    return float(max(corner[0], 1e-6) * 1.25), float(max(corner[1], 1e-6) * 1.25)


def list_shape(size: tuple[float, float]) -> tuple[int, int]:
    """(h, w) of the grid for a listed scene: twice the network's resolution."""
    scale = 2 * _GRID / max(size)
    return max(16, round(size[1] * scale)), max(16, round(size[0] * scale))


def observation_of(
    scene: Scene, network: DistanceNet | None, scale: float | None, **options: Any
) -> Observation:
    """Observes the picture; CannotJudgeError where there is none."""
    if scene.picture is None:
        raise CannotJudgeError(
            "a picture or a list of objects", "neither", row=f"scene {scene.scene_id}",
            field="file_name",
        )  # fmt: skip
    return observe(scene.pixels(), network=network, scale=scale, **options)


@dataclass(frozen=True)
class PictureObserver:
    """Measures distances to what pictures show; an `Observer`.

    Args:
        symbols: The classes to name: a set's symbols, or generic words where no scene lists any.
        head: Appearance → symbols; None: generic words.
        calibration: Of the distances.
        observations: By scene, those that were made already.
        network, scale: As of `observation_of`, for the others; those are not measured without a
            network.
    """

    symbols: tuple[str, ...]
    head: SymbolHead | None
    calibration: Calibration
    observations: Mapping[str, Observation]
    network: DistanceNet | None = None
    scale: float | None = None

    def nearest(self, scene: Scene, paths: Paths) -> tuple[FloatArray, float] | None:
        """(n, K) nearest approaches, and their standard deviation; set units."""
        observation = self.observations.get(scene.scene_id)
        if observation is None and (self.network is None or scene.picture is None):
            return None
        if self.head is None and self.symbols != KINDS:
            return None  # nobody could say what these things are called
        if observation is None:
            observation = observation_of(scene, self.network, self.scale)
        perceived = perceived_objects(observation, self.head, self.calibration)
        size = (float(observation.size_px[0]), float(observation.size_px[1]))
        near = nearest_perceived(perceived, size, list(paths), self.symbols)
        return near, SEEN_ERROR * observation.percent_px


def nearest_perceived(
    perceived: tuple[PerceivedObject, ...],
    size: tuple[float, float],
    paths: list[FloatArray],
    names: tuple[str, ...],
) -> FloatArray:
    """(n, K) nearest approach to the likeliest class of every object; +inf where absent."""
    out = np.full((len(paths), len(names)), np.inf)
    for item in perceived:
        if not item.classes:
            continue
        name = max(item.classes, key=lambda n: item.classes[n])
        if name not in names or sum(item.classes.values()) < 0.5:
            continue
        k = names.index(name)
        for i, path in enumerate(paths):
            near = read_map(
                item.distance, densify(path[:, :2], size[0] / item.distance.shape[1] / 2), size
            ).min()
            out[i, k] = min(out[i, k], float(near))
    return out
