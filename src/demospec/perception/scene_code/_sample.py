"""New scenes whose things, tables and lamps resemble those of given scenes.

A smoothed bootstrap: every new thing lies between one that was there and another of the same
name that looks alike; tables lie between two tables. Places are free of each other, of start
and goal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.perception.scene_code._code import ObjectCode, SceneCode, TableCode
from demospec.perception.scene_code._draw import draw_scene_code, outline_of
from demospec.scene import Footprint, Picture, Scene, SceneObject

_MIX = 0.4  # how far a new thing may lie from the old one towards its neighbour
_TRIES = 200  # of placing one thing
_GAP = 0.03  # of the picture's longer side, between things
_END_GAP = 0.05  # between things and start or goal


@dataclass(frozen=True)
class SceneSampler:
    """The distribution that scenes are drawn from.

    Args:
        codes: Of the scenes to resemble.
        ends: (start, goal) of each, picture pixels.
    """

    codes: tuple[SceneCode, ...]
    ends: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]

    def __post_init__(self) -> None:
        if not self.codes:
            raise InputError("at least one scene to resemble", "none", field="scenes")

    def sample(self, n: int, rng: np.random.Generator) -> list[tuple[Scene, SceneCode]]:
        """n new scenes with pictures and lists of what was put in, and their codes."""
        if n < 0:
            raise InputError("a count of at least 0", n, field="n")
        return [self._one(f"sampled-{i:04d}", rng) for i in range(n)]

    def _one(self, name: str, rng: np.random.Generator) -> tuple[Scene, SceneCode]:
        first = int(rng.integers(len(self.codes)))
        base = self.codes[first]
        start, goal = self.ends[first]
        alike = [c for c in self.codes if c.grid == base.grid and c.size_px == base.size_px]
        other = alike[int(rng.integers(len(alike)))]
        code = replace(
            base, table=_between_tables(base.table, other.table, float(rng.random())), objects=()
        )
        pool = [item for c in alike for item in c.objects if _whole(item, c)]
        ends = np.array([start[:2], goal[:2]], dtype=np.float64)
        placed: list[ObjectCode] = []
        shapes: list[Footprint] = []
        for _ in range(len(base.objects) if pool else 0):
            item = _new_item(pool, rng)
            found = _placed(item, code, shapes, ends, rng)
            if found is not None:
                placed.append(found[0])
                shapes.append(found[1])
        code = code.with_objects(tuple(placed))
        objects = tuple(
            _listed(item, shape, i)
            for i, (item, shape) in enumerate(zip(placed, shapes, strict=True))
        )
        picture = Picture(array=draw_scene_code(code))
        return Scene(name, start, goal, objects, picture), code


def _whole(item: ObjectCode, code: SceneCode) -> bool:
    """Whether the thing lies inside the picture, not cut by its edge."""
    corners = item.frame.outward(np.array([[-1.0, -1], [-1, 1], [1, -1], [1, 1]]))
    inside = (corners > -1.0) & (corners < np.asarray(code.grid) + 1.0)
    return bool(inside.all() and np.abs(item.outline).max() > 0)


def _new_item(pool: list[ObjectCode], rng: np.random.Generator) -> ObjectCode:
    """A thing between one of the pool and one of the five of its name that are most alike."""
    one = pool[int(rng.integers(len(pool)))]
    same = [s for s in pool if s.symbol == one.symbol and len(s.vector()) == len(one.vector())]
    gaps = np.array([_unlike(one, s) for s in same])
    near = np.argsort(gaps, kind="stable")[: min(5, len(same))]
    other = same[int(near[rng.integers(len(near))])]
    return between_slots(one, other, float(rng.uniform(0.0, _MIX)))


def _unlike(one: ObjectCode, other: ObjectCode) -> float:
    outline = float(((one.outline - other.outline) ** 2).sum())
    size = float((np.log(one.half / other.half) ** 2).sum())
    return outline + 20.0 * size + 0.05 * float(((one.luma - other.luma) ** 2).sum())


def between_slots(one: ObjectCode, other: ObjectCode, share: float) -> ObjectCode:
    """The thing that lies `share` of the way from one to another; names are the nearer's."""

    def mix(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray((1 - share) * a + share * b)

    turn = (other.angle_rad - one.angle_rad + np.pi) % (2 * np.pi) - np.pi
    return replace(
        one if share < 0.5 else other,
        center=mix(one.center, other.center),
        angle_rad=one.angle_rad + share * turn,
        half=np.exp(mix(np.log(one.half), np.log(other.half))),
        outline=mix(one.outline, other.outline),
        luma=mix(one.luma, other.luma),
        chroma=mix(one.chroma, other.chroma),
        clear=(1 - share) * one.clear + share * other.clear,
        height=(1 - share) * one.height + share * other.height,
        shade=(1 - share) * one.shade + share * other.shade,
    )


def _between_tables(one: TableCode, other: TableCode, share: float) -> TableCode:
    """Colours are mixed; the texture is that of the nearer table (mixed weaves look like none)."""
    near = one if share < 0.5 else other
    return replace(
        near,
        low=(1 - share) * one.low + share * other.low,
        low_chroma=(1 - share) * one.low_chroma + share * other.low_chroma,
    )


def _placed(
    item: ObjectCode,
    code: SceneCode,
    shapes: Sequence[Footprint],
    ends: FloatArray,
    rng: np.random.Generator,
) -> tuple[ObjectCode, Footprint] | None:
    """The thing at a free place, and its outline there; None where there is no room."""
    size = np.asarray(code.size_px, np.float64)
    side = float(size.max())
    for _ in range(_TRIES):
        here = replace(
            item,
            center=rng.uniform(0.0, 1.0, 2) * code.grid,
            angle_rad=float(rng.uniform(-np.pi, np.pi)),
        )
        if not _whole(here, code):
            continue
        shape = outline_of(here, code)
        if shape is None or shape.signed_distance(ends).min() < _END_GAP * side:
            continue
        gaps = (
            min(
                float(shape.signed_distance(other.vertices).min()),  # type: ignore[attr-defined]
                float(other.signed_distance(shape.vertices).min()),
            )
            for other in shapes
        )
        if all(gap >= _GAP * side for gap in gaps):
            return here, shape
    return None


def _listed(item: ObjectCode, shape: Footprint, number: int) -> SceneObject:
    x0, y0, x1, y1 = shape.bounds
    box = (round(x0, 3), round(y0, 3), round(x1 - x0, 3), round(y1 - y0, 3))
    middle = (round((x0 + x1) / 2, 3), round((y0 + y1) / 2, 3))
    return SceneObject(f"{item.symbol}-{number}", item.symbol, middle, box, shape)
