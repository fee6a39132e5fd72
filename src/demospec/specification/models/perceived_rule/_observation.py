"""From a scene to the things in it: by its list where it has one, else by its picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths
from demospec.errors import CannotJudgeError
from demospec.frames import FloatArray
from demospec.perception import KINDS, Sight, SymbolHead, look
from demospec.scene import Footprint, Scene
from demospec.specification.models.perceived_rule._view import Part

if TYPE_CHECKING:
    from demospec.perception import Body

LISTED_ERROR = 0.15
"""Distance error of a listed outline (hundredths of the table): the list is not the truth."""

SEEN_ERROR = 0.7
"""Standard deviation of a seen distance, hundredths of the table: about what calibration on
listed outlines finds. A rim that is wrong by a pixel must not make a label look wrong."""

_GRID = 100
_AROUND = 6.0  # hundredths of the table
_LEAST_ERROR = 0.1  # likewise; nowhere is a seen rim known better


@dataclass(frozen=True)
class Calibration:
    """How the body's distances at the clearance compare with the listed outlines.

    Args:
        bias: Class → seen − listed distance, hundredths of the table.
        error: Class → standard deviation of it, likewise, where the body doubts as usual.
        other_bias, other_error: For classes never calibrated.
    """

    bias: Mapping[str, float]
    error: Mapping[str, float]
    other_bias: float = 0.0
    other_error: float = 0.6

    def of_classes(self, classes: Mapping[str, float]) -> tuple[float, float]:
        """Bias and error of a thing of uncertain class, hundredths."""
        total = sum(classes.values())
        if total <= 0:
            return self.other_bias, self.other_error
        bias = sum(p * self.bias.get(n, self.other_bias) for n, p in classes.items()) / total
        error = sum(p * self.error.get(n, self.other_error) for n, p in classes.items()) / total
        return bias, error


def classes_of(sight: Sight, head: SymbolHead | None) -> list[dict[str, float]]:
    """Class → probability of every slot: symbols where a head was fitted, else generic words.

    What is missing to 1 is the probability that nothing is there.
    """
    if not sight.slots:
        return []
    if head is None:
        return [
            {k: float(s.confidence * p) for k, p in zip(KINDS, s.kinds, strict=True)}
            for s in sight.slots
        ]
    p = head.probabilities(np.stack([s.looks for s in sight.slots]))
    return [
        {name: float(q) for name, q in zip(head.classes, row, strict=True) if name} for row in p
    ]


def seen_parts(sight: Sight, head: SymbolHead | None, calibration: Calibration) -> tuple[Part, ...]:
    """The slots of a picture as parts, distances corrected by the calibration."""
    unit = sight.hundredth
    parts = []
    for slot, classes in zip(sight.slots, classes_of(sight, head), strict=True):
        bias, error = calibration.of_classes(classes)
        distance = slot.distance - np.float32(bias * unit)
        # Of this thing as a whole, where its clearance may be; the rest is place by place.
        around = (slot.distance > 0) & (slot.distance < _AROUND * unit)
        usual = float(np.median(sight.doubt[around])) if around.any() else 1.0
        least = _LEAST_ERROR / (error * usual)
        doubt = np.maximum(sight.doubt / usual, least).astype(np.float32)
        parts.append(Part(distance, classes, error * unit * usual, slot.center, False, doubt))
    return tuple(parts)


def listed_parts(
    scene: Scene, size: tuple[float, float], shape: tuple[int, int]
) -> tuple[Part, ...]:
    """The scene's own list as parts, exact on the grid."""
    error = LISTED_ERROR * max(size) / 100.0
    return tuple(
        Part(
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
    """(h, w) of the grid for a listed scene: twice the body's resolution."""
    scale = 2 * _GRID / max(size)
    return max(16, round(size[1] * scale)), max(16, round(size[0] * scale))


def sight_of(scene: Scene, body: Body | None, scale: float | None, **options: Any) -> Sight:
    """Looks at the picture; CannotJudgeError where there is none."""
    if scene.picture is None:
        raise CannotJudgeError(
            "a picture or a list of objects", "neither", row=f"scene {scene.scene_id}",
            field="file_name",
        )  # fmt: skip
    return look(scene.pixels(), body=body, scale=scale, **options)


@dataclass(frozen=True)
class PictureObserver:
    """Measures distances to what pictures show; an `Observer`.

    Args:
        symbols: The classes to name: a set's symbols, or generic words where no scene lists any.
        head: Appearance → symbols; None: generic words.
        calibration: Of the distances.
        observations: By scene, those that were made already.
        body, scale: As of `sight_of`, for the others; without a body, those are not measured.
    """

    symbols: tuple[str, ...]
    head: SymbolHead | None
    calibration: Calibration
    observations: Mapping[str, Sight]
    body: Body | None = None
    scale: float | None = None

    def nearest(self, scene: Scene, paths: Paths) -> tuple[FloatArray, float] | None:
        """(n, K) nearest approaches, and their standard deviation; set units."""
        sight = self.observations.get(scene.scene_id)
        if sight is None and (self.body is None or scene.picture is None):
            return None
        if self.head is None and self.symbols != KINDS:
            return None  # nobody could say what these things are called
        if sight is None:
            sight = sight_of(scene, self.body, self.scale)
        parts = seen_parts(sight, self.head, self.calibration)
        size = (float(sight.size_px[0]), float(sight.size_px[1]))
        near = nearest_in_parts(parts, size, list(paths), self.symbols)
        return near, SEEN_ERROR * sight.hundredth


def nearest_in_parts(
    parts: tuple[Part, ...],
    size: tuple[float, float],
    paths: list[FloatArray],
    names: tuple[str, ...],
) -> FloatArray:
    """(n, K) nearest approach to the likeliest class of every part; +inf where absent."""
    from demospec.demonstrations import densify
    from demospec.perception import read_map

    out = np.full((len(paths), len(names)), np.inf)
    for part in parts:
        if not part.classes:
            continue
        name = max(part.classes, key=lambda n: part.classes[n])
        if name not in names or sum(part.classes.values()) < 0.5:
            continue
        k = names.index(name)
        for i, path in enumerate(paths):
            near = read_map(part.distance, densify(path[:, :2], 0.5), size).min()  # type: ignore[arg-type]
            out[i, k] = min(out[i, k], float(near))
    return out
