"""Several annotators' objects of one picture as one list."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from demospec.demonstrations.readers.annotations._shapes import ObjectList
from demospec.errors import InputError
from demospec.geometry import Disc, Footprint
from demospec.scene import SceneObject

Drawn = tuple[str, tuple[str, Footprint | tuple[float, float]]]
"""A region's id; its symbol, and its footprint or the place of a point."""

_SAME = 0.5
"""Share of two outlines' union that lies in both, from which on they are one thing."""
_CELLS = 100


def agreed(
    lists: list[list[Drawn]],
    size_px: tuple[float, float] | None,
    path: Path,
    row: int,
    notes: list[str],
) -> tuple[SceneObject, ...]:
    """The objects that annotators listed, each once.

    Args:
        lists: One list an annotation.
        size_px: Of the picture; points that lie within a hundredth of it are one.
        path, row: The file, and the task in it.
        notes: Told of what was found by several.

    Raises:
        InputError: Two annotators gave the same thing (by its region's id, or by its place)
            different labels, or one id to things at different places.
    """
    objects = ObjectList()
    kept: list[tuple[str, str, Footprint, int]] = []
    near = 0.01 * max(size_px) if size_px is not None else 0.0
    shared = 0
    for number, drawn in enumerate(lists):
        earlier = len(kept)
        matched: set[int] = set()
        for key, (symbol, shape) in drawn:
            outline = Disc(shape, 0.0) if isinstance(shape, tuple) else shape
            where = f"task {row}, region {key}"
            twin = None
            for k in (k for k in range(earlier) if k not in matched):
                its_key, its_symbol, its_outline, _ = kept[k]
                same = _is_same(outline, its_outline, near)
                if same and symbol != its_symbol:
                    raise InputError(f"{its_symbol}, as another annotator says", symbol, file=path,
                                     row=where, field="labels")  # fmt: skip
                if its_key == key and not same:
                    expected = "the outline that another annotator gave this region"
                    raise InputError(expected, "another place", file=path, row=where,
                                     field="value")  # fmt: skip
                if same and (twin is None or its_key == key):
                    twin = k
            if twin is not None:
                matched.add(twin)
                shared += 1
                continue
            kept.append((key, symbol, outline, number))
            if isinstance(shape, tuple):
                objects.add(symbol, None, center=shape)
            else:
                objects.add(symbol, shape)
    if len(lists) > 1:
        notes.append(f"task {row}: {len(lists)} annotations, {shared} objects outlined twice")
    return tuple(objects.objects)


def _is_same(a: Footprint, b: Footprint, near: float) -> bool:
    """Whether two outlines are of one thing: by the area that they share, or as points."""
    if isinstance(a, Disc) or isinstance(b, Disc):
        if not (isinstance(a, Disc) and isinstance(b, Disc)):
            return False
        return float(np.hypot(*np.subtract(a.center, b.center))) <= near
    boxes = np.array([a.bounds, b.bounds])
    if (boxes[0, :2] >= boxes[1, 2:]).any() or (boxes[1, :2] >= boxes[0, 2:]).any():
        return False
    low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    u = (np.arange(_CELLS) + 0.5) / _CELLS
    grid = low + np.stack(np.meshgrid(u, u), axis=-1) * (high - low)
    one, other = a.signed_distance(grid) < 0, b.signed_distance(grid) < 0
    union = int((one | other).sum())
    return union > 0 and int((one & other).sum()) >= _SAME * union
