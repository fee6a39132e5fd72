"""Features of a path beside the things of a scene: distances, sides, height over, edge, region."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from demospec.demonstrations import Motion
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Footprint, Polygon, extent, nearest_on_segments, rectangle
from demospec.rules.constraints.features._feature import FeatureValue
from demospec.rules.constraints.features._near_things import convex, gaps, inside, line_gaps, things
from demospec.scene import Scene, SceneObject

if TYPE_CHECKING:
    from demospec.rules.constraints._constraint import Constraint

UNKNOWN = FeatureValue(float("nan"))
FREE = FeatureValue(float("inf"))


def distance(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Least distance to the footprints of a class, on one side of them where a sector is named.

    Things whose sides are not known are no matter where they are farther away than the nearest.
    """
    best = FREE
    unknown = np.inf
    for item in things(scene, str(asked.of)):
        if asked.sector is None:
            gap, along = gaps(motion, item)
            row: int | None = int(gap.argmin())
            value, place = float(gap[row]), float(along[row])
        else:
            ahead = sector_direction(item, asked.sector, asked.unit == "px")
            if ahead is None:
                unknown = min(unknown, float(gaps(motion, item)[0].min()))
                continue
            value, row, place = _on_side(motion, item, ahead)
        if row is not None and value < best.value:
            best = FeatureValue(value, motion.share(row, place), (item.id,))
    return UNKNOWN if unknown < best.value else best


def near(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """How near the path comes to the nearest thing of a class; it must come so near."""
    items = things(scene, str(asked.of))
    if not items:
        return FeatureValue(-np.inf)  # where none stands, none has to be approached
    best = FREE
    for item in items:
        gap, along = gaps(motion, item)
        row = int(gap.argmin())
        if gap[row] < best.value:
            best = FeatureValue(float(gap[row]), motion.share(row, float(along[row])), (item.id,))
    return best


def sector_direction(item: SceneObject, sector: str, y_down: bool) -> FloatArray | None:
    """(2,) where a side of a thing lies; None where it needs a heading that is not known.

    Args:
        y_down: Whether y grows downwards, as in pictures: what lies to the left as seen from
            above is then the other way round.
    """
    fixed = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}
    if sector in fixed:
        return np.array(fixed[sector])
    if item.heading_deg is None:
        return None
    left = -90.0 if y_down else 90.0
    turn = {"front": 0.0, "back": 180.0, "left": left, "right": -left}[sector]
    angle = np.radians(item.heading_deg + turn)
    return np.array([np.cos(angle), np.sin(angle)])


def _on_side(
    motion: Motion, item: SceneObject, ahead: FloatArray
) -> tuple[float, int | None, float]:
    """Least distance over the path's part in the half-plane ahead of the centre; exact."""
    a, b = motion.segments
    first = (a - np.asarray(item.center)) @ ahead
    last = (b - np.asarray(item.center)) @ ahead
    gap, along = gaps(motion, item)
    value = np.where((first >= 0) & (last >= 0), gap, np.inf)
    place = along.copy()
    cut = np.flatnonzero((first >= 0) != (last >= 0))
    # A cut segment cannot come nearer than it does as a whole.
    cut = cut[gap[cut] < value.min(initial=np.inf)]
    if len(cut):
        at = first[cut] / (first[cut] - last[cut])
        low = np.where(first[cut] >= 0, 0.0, at)
        high = np.where(first[cut] >= 0, at, 1.0)
        step = b[cut] - a[cut]
        found, part = nearest_on_segments(
            item.outline, a[cut] + low[:, None] * step, a[cut] + high[:, None] * step
        )
        value[cut] = found
        place[cut] = low + part * (high - low)
    row = int(value.argmin())
    if not np.isfinite(value[row]):
        return np.inf, None, 0.0
    return float(value[row]), row, float(place[row])


def between(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Least distance to the segments that join two things: of two classes, or of a relation."""
    best = FREE
    for one, other in joined_things(scene, asked.of):
        gap, along = line_gaps(motion, one, other)
        row = int(gap.argmin())
        if gap[row] < best.value:
            best = FeatureValue(
                float(gap[row]), motion.share(row, float(along[row])), (one.id, other.id)
            )
    return best


def joined_things(
    scene: Scene, of: str | tuple[str, str] | None
) -> list[tuple[SceneObject, SceneObject]]:
    """Pairs of things that ``between`` speaks of: of two classes, or of one kind of relation."""
    listed = scene.listed_objects()
    if isinstance(of, tuple):
        first = [item for item in listed if item.symbol == of[0]]
        second = [item for item in listed if item.symbol == of[1]]
        pairs = {frozenset((p.id, q.id)): (p, q) for p, q in product(first, second) if p is not q}
        return list(pairs.values())
    by_id = {item.id: item for item in listed}
    return [(by_id[r.between[0]], by_id[r.between[1]]) for r in scene.relations if r.kind == of]


def height_over(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Least height over the tops of things of a class, while above their footprints."""
    z = motion.column("z")
    if z is None:
        return UNKNOWN
    best = FREE
    for item in things(scene, str(asked.of)):
        for i, spans in inside(motion, item, 0.0).items():
            if item.height is None:
                if spans:
                    return UNKNOWN
                continue
            here, there = float(z[i]), float(z[min(i + 1, len(z) - 1)])
            for along in (end for span in spans for end in span):  # linear in between
                over = here + along * (there - here) - item.height[1]
                if over < best.value:
                    best = FeatureValue(over, motion.share(i, along), (item.id,))
    return best


def edge(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Least distance from the edge of the table, < 0 beyond it.

    The table is the region ``table`` of the scene where it names one, else its picture.
    """
    shape = table_of(scene)
    if shape is None:
        return UNKNOWN
    value, share = _farthest(motion, shape)
    return FeatureValue(-value, share)


def region(motion: Motion, scene: Scene, asked: Constraint) -> FeatureValue:
    """Signed distance to a region of the scene: the least (keep out), or greatest (stay in)."""
    shape = regions_of(scene).get(str(asked.of))
    if shape is None:
        return FeatureValue(asked.sign * np.inf)
    if asked.sense == "at_most":
        return FeatureValue(*_farthest(motion, shape))
    a, b = motion.segments
    gap, along = nearest_on_segments(shape, a, b)
    row = int(gap.argmin())
    return FeatureValue(float(gap[row]), motion.share(row, float(along[row])))


def regions_of(scene: Scene) -> dict[str, Polygon]:
    """The named polygons of a scene: ``"regions": {name: [[x, y], …]}`` of its metadata.

    Raises:
        InputError: Something else stands there.
    """
    found = dict(scene.extra).get("regions", {})
    where = f"scene {scene.scene_id}"
    if not isinstance(found, dict):
        raise InputError("regions by name {…}", found, row=where, field="regions")
    out = {}
    for name, corners in found.items():
        try:
            v = np.array(corners, dtype=np.float64)
        except (TypeError, ValueError) as error:
            expected = "a polygon [[x, y], …]"
            raise InputError(expected, corners, row=where, field=f"regions.{name}") from error
        if v.ndim != 2 or v.shape[1] != 2 or len(v) < 3 or not np.isfinite(v).all():
            raise InputError(
                "a polygon [[x, y], …] of three corners or more", corners, row=where,
                field=f"regions.{name}",
            )  # fmt: skip
        out[str(name)] = Polygon(v)
    return out


def table_of(scene: Scene) -> Polygon | None:
    """The table: the region of that name, else the whole picture, else not known."""
    named = regions_of(scene).get("table")
    if named is not None or scene.size_px is None:
        return named
    width, height = scene.size_px
    return rectangle(0.0, 0.0, float(width), float(height))


def _farthest(motion: Motion, shape: Footprint) -> tuple[float, float]:
    """Greatest signed distance of a path to a shape, and where, to 1e-9 of their extent.

    A signed distance is 1-Lipschitz: a stretch whose ends and length leave no room for more
    than what is known is not looked at again; the others are halved. That to a convex shape is a
    convex function: greatest at a point of the path.
    """
    a, b = motion.segments
    if convex(shape):
        gaps_at = np.asarray(shape.signed_distance(motion.xy))
        at = int(gaps_at.argmax())
        last_one = at == len(motion.steps)
        return float(gaps_at[at]), motion.share(at - last_one, float(last_one))
    tolerance = 1e-9 * (extent(shape.bounds) + float(np.ptp(motion.xy, axis=0).max(initial=0.0)))

    def gap(points: FloatArray) -> FloatArray:
        return np.asarray(shape.signed_distance(points))

    first, last = gap(a), gap(b)
    row = np.arange(len(a))
    low, high = np.zeros(len(a)), np.ones(len(a))
    size = motion.steps
    best, share = _best(motion, first, last, row, low, high)
    for _ in range(80):
        room = (first + last + size * (high - low)) / 2
        open_ = room > best + tolerance
        if not open_.any():
            break
        row, low, high = row[open_], low[open_], high[open_]
        first, last, size = first[open_], last[open_], size[open_]
        middle = (low + high) / 2
        value = gap(a[row] + middle[:, None] * (b[row] - a[row]))
        row, size = np.tile(row, 2), np.tile(size, 2)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        first, last = np.concatenate([first, value]), np.concatenate([value, last])
        found, place = _best(motion, first, last, row, low, high)
        if found > best:
            best, share = found, place
    return best, share


def _best(
    motion: Motion,
    first: FloatArray,
    last: FloatArray,
    row: np.ndarray,
    low: FloatArray,
    high: FloatArray,
) -> tuple[float, float]:
    at = int(np.maximum(first, last).argmax())
    ahead = float(high[at] if last[at] > first[at] else low[at])
    return float(max(first[at], last[at])), motion.share(int(row[at]), ahead)
