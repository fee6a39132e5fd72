"""Demonstration sets with a known rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    bezier_points,
    write_set,
)
from demospec.rules import nearest_approach
from demospec.scene import Disc, Picture, Scene, SceneObject
from demospec.testing._scenes import (
    GOAL,
    START,
    SYMBOLS,
    bulged_path,
    random_paths,
    random_picture,
    random_scene,
)


def small_set(n: int = 6, *, pictures: bool = True, t: bool = False) -> DemonstrationSet:
    """Two scenes with a glass each, n demonstrations of the types ``careful`` and ``normal``.

    Args:
        pictures: With plain pictures of 100 × 100 pixels.
        t: With times, seconds.
    """
    scenes = tuple(
        Scene(
            f"s{i}",
            START,
            GOAL,
            (SceneObject("glass-0", "glass", (50.0, 50.0), None, Disc((50.0, 50.0), 6.0)),),
            Picture(array=np.full((100, 100, 3), 40 * i, np.uint8)) if pictures else None,
        )
        for i in range(2)
    )
    items = [
        Demonstration(
            f"d{i}",
            f"s{i % 2}",
            bulged_path(3.0 * i % 40 - 5 + i / 1000),
            ("careful", "normal")[i % 2],
            None,
            i % 3 != 0,
            np.arange(9) / 10 if t else None,
        )
        for i in range(n)
    ]
    return DemonstrationSet(
        scenes, Demonstrations.of(items), symbols=("glass",), types=("careful", "normal")
    )


def write_small_set(folder: Path, n: int = 6, *, pictures: bool = True, t: bool = False) -> Path:
    """`small_set` as a folder."""
    return write_set(small_set(n, pictures=pictures, t=t), folder)


def clearance_verdicts(
    nearest: ArrayLike, rule: Mapping[str, float], symbols: Sequence[str] = SYMBOLS
) -> NDArray[np.bool_]:
    """(n,) whether paths keep a clearance rule: the definition, without any engine.

    Args:
        nearest: (n, K) nearest approach to each of `symbols`.
        rule: Symbol that matters → clearance.
    """
    distance = np.asarray(nearest, dtype=np.float64)
    keep = np.ones(len(distance), dtype=bool)
    for k, symbol in enumerate(symbols):
        if symbol in rule:
            keep &= distance[:, k] >= rule[symbol]
    return keep


def demonstrator_set(
    rng: np.random.Generator,
    rules: Mapping[str, Mapping[str, float]],
    scenes: int,
    each: int,
    *,
    scale: float = 1.0,
    units: str = "px",
    metres_per_unit: float | None = 0.0082,
) -> DemonstrationSet:
    """A set without pictures whose types follow clearance rules exactly.

    Args:
        rules: Type → symbol → clearance, in percent of the table's size.
        scenes: How many `random_scene`s.
        each: Demonstrations a scene and type.
        scale: All lengths of the set, per percent of the table's size.
        units, metres_per_unit: Of the set.
    """
    places: list[Scene] = []
    items: list[Demonstration] = []
    for s in range(scenes):
        place = random_scene(rng, f"{s:02d}", scale=scale)
        places.append(place)
        for name, rule in rules.items():
            paths = random_paths(rng, each, scale=scale)
            own = {symbol: clearance * scale for symbol, clearance in rule.items()}
            keep = clearance_verdicts(nearest_approach(place, paths, SYMBOLS), own)
            items += [
                Demonstration(f"{s}-{name}-{i}", place.scene_id, path, name, None, bool(valid))
                for i, (path, valid) in enumerate(zip(paths, keep, strict=True))
            ]
    return DemonstrationSet(
        scenes=tuple(places),
        demonstrations=Demonstrations.of(items),
        symbols=SYMBOLS,
        types=tuple(rules),
        units=units,
        metres_per_unit=metres_per_unit,
    )


def colour_set(
    scenes: int = 12, each: int = 10, *, seed: int = 0, size: int = 100, blank: bool = False
) -> DemonstrationSet:
    """A set that needs its pictures: red scenes accept control points above the diagonal,
    blue ones below; colours alternate, and nothing is listed.

    Args:
        each: Demonstrations per scene of the type ``sided``; ``any`` gets two that are valid.
        size: Of the pictures, pixels.
        blank: All pictures are the same grey.
    """
    rng = np.random.default_rng(seed)
    places, items = [], []
    scale = size / 100
    start, goal = (tuple(v * scale for v in end) for end in (START, GOAL))
    for i in range(scenes):
        colour = (200, 40, 40) if i % 2 == 0 else (40, 40, 200)
        picture = random_picture(rng, (size, size), colour)
        if blank:
            picture = Picture(array=np.full((size, size, 3), 128, np.uint8))
        places.append(Scene(f"s{i}", start, goal, None, picture))
        for k in range(each + 2):
            control = rng.uniform(0, size, 2)
            above = control[0] + control[1] < size
            valid = bool(above == (i % 2 == 0)) if k < each else True
            items.append(
                Demonstration(
                    f"s{i}-{k}",
                    f"s{i}",
                    bezier_points(start, goal, control, 60),
                    type="sided" if k < each else "any",
                    demonstrator="p",
                    valid=valid,
                )
            )
    return DemonstrationSet(
        tuple(places), Demonstrations.of(items), types=("sided", "any"), symbols=("glass",)
    )


def with_labels(data: DemonstrationSet, valid: ArrayLike) -> DemonstrationSet:
    """The same set with other labels (n,) of 1, 0, −1 (none)."""
    demonstrations = data.demonstrations.rows(np.arange(len(data.demonstrations)))
    demonstrations.valid = np.asarray(valid).astype(np.int8)
    return replace(data, demonstrations=demonstrations)
