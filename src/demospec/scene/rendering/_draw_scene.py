"""Random scenes of a task: which items, where, on which table, under which lamp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Polygon
from demospec.scene._scene import Scene
from demospec.scene.rendering._compose import TABLE_M, Placement, compose_scene, snap_center
from demospec.scene.rendering._light import draw_light
from demospec.scene.rendering._tables import draw_table
from demospec.scene.rendering.catalogues._catalogue import TASK_SYMBOLS
from demospec.scene.rendering.catalogues._items import Catalogue, CatalogueItem


@dataclass(frozen=True)
class SceneStatistics:
    """How crowded a task's scenes are. All lengths at a picture of 100 px.

    Args:
        watched: The symbol that ``normal`` looks out for.
        watched_count: Probabilities of 0, 1, 2, … watched objects.
        other_count: Probabilities of 0, 1, 2, … other objects.
        watched_spread: Standard deviation of a watched object's distance from the straight
            line start–goal; the smaller, the more it is in the way.
        other_shyness: How much rarer other objects are on that line than far from it, 0 … 1.
        gap: Least distance between two footprints.
        end_gap: Least distance between a footprint and the start or the goal.
    """

    watched: str
    watched_count: tuple[float, ...]
    other_count: tuple[float, ...]
    watched_spread: float
    other_shyness: float
    gap: float = 3.0
    end_gap: float = 5.0


SHY_RANGE = 20.0
"""How far from the line the shyness reaches (standard deviation, pixels at 100)."""

# Chosen so that, over many scenes, 0.43 / 0.62 of random paths are valid (docs/demonstrations.md
# gives the command that measures it).
STATISTICS = {
    "tabletop": SceneStatistics(
        "glass", (0.02, 0.63, 0.3, 0.05), (0.15, 0.5, 0.3, 0.05), 19.0, 0.9
    ),
    "workbench": SceneStatistics("drill", (0.03, 0.94, 0.03), (0.15, 0.5, 0.3, 0.05), 100.0, 0.9),
}


def draw_scene(
    rng: np.random.Generator,
    catalogue: Catalogue,
    *,
    task: str = "tabletop",
    scene_id: str = "0000",
    split: str = "train",
    size_px: int = 100,
) -> Scene:
    """A random scene; its objects lie apart from each other, from start and from goal.

    Args:
        rng: Source of randomness.
        catalogue: The items to choose from (the part that belongs to the split).
        task: ``tabletop`` or ``workbench``.
        scene_id, split: Of the scene.
        size_px: Side of the picture.
    """
    if task not in TASK_SYMBOLS:
        raise InputError(f"one of the tasks {', '.join(TASK_SYMBOLS)}", task, field="task")
    how = STATISTICS[task]
    scale = size_px / 100.0
    start, goal = _ends(rng, task)
    table, light = draw_table(rng, "wood" if task == "workbench" else None), draw_light(rng)
    others = [s for s in TASK_SYMBOLS[task] if s != how.watched and s in catalogue.symbols]
    wanted = [how.watched] * int(rng.choice(len(how.watched_count), p=how.watched_count))
    count = int(rng.choice(len(how.other_count), p=how.other_count))
    if not wanted and not count:
        count = 1  # an empty table shows nothing
    wanted += [others[int(k)] for k in rng.integers(len(others), size=count)]
    placed: list[tuple[Placement, Polygon]] = []
    for symbol in wanted:
        items = catalogue.of_symbol(symbol)
        item = items[int(rng.integers(len(items)))]
        found = _place(rng, item, [p for _, p in placed], start, goal, how)
        if found is not None:
            placed.append(found)
    placements = [
        Placement(p.item, (p.center[0] * scale, p.center[1] * scale), p.angle_rad)
        for p, _ in placed
    ]
    return compose_scene(
        scene_id, placements, table=table, light=light, size_px=size_px,
        start=start * scale, goal=goal * scale, split=split,
    )  # fmt: skip


def _ends(rng: np.random.Generator, task: str) -> tuple[FloatArray, FloatArray]:
    if task == "tabletop":
        return np.array([10.0, 90.0]), np.array([90.0, 10.0])
    left, right = np.round(rng.uniform(30.0, 70.0, 2), 1)
    return np.array([8.0, left]), np.array([92.0, right])


def _place(
    rng: np.random.Generator,
    item: CatalogueItem,
    others: list[Polygon],
    start: FloatArray,
    goal: FloatArray,
    how: SceneStatistics,
) -> tuple[Placement, Polygon] | None:
    """A free pose in a picture of 100 px, or None where none was found."""
    along = (goal - start) / np.linalg.norm(goal - start)
    across = np.array([-along[1], along[0]])
    ends = np.stack([start, goal])
    for _ in range(600):
        center = rng.uniform(0.0, 100.0, 2)
        angle = float(rng.uniform(0, 2 * np.pi))
        off = float((center - start) @ across)
        if item.symbol == how.watched:
            chance = np.exp(-0.5 * (off / how.watched_spread) ** 2)
        else:
            chance = 1.0 - how.other_shyness * np.exp(-0.5 * (off / SHY_RANGE) ** 2)
        if rng.random() > chance:
            continue
        shape = item.footprint(snap_center(center), angle, TABLE_M / 100.0)
        x0, y0, x1, y1 = shape.bounds
        if min(x0, y0) < 1.0 or max(x1, y1) > 99.0:
            continue
        if shape.signed_distance(ends).min() < how.end_gap:
            continue
        if all(
            min(shape.signed_distance(o.vertices).min(), o.signed_distance(shape.vertices).min())
            >= how.gap
            for o in others
        ):
            return Placement(item, (float(center[0]), float(center[1])), angle), shape
    return None
