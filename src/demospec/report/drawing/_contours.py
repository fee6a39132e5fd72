"""A clearance rule as rings about the objects of a scene."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import lru_cache
from typing import Any

import numpy as np
from markupsafe import Markup

from demospec.frames import describe_length
from demospec.report.drawing._markup import joined
from demospec.report.drawing._window import view_box
from demospec.rules import ClearanceRule
from demospec.scene import Footprint, Scene


def rings_svg(
    scene: Scene,
    rule: ClearanceRule | None,
    scale: float | None = None,
    units: str = "px",
) -> Markup:
    """For every object that matters, the least clearance dashed, the greatest solid.

    Between them lies what the demonstrations leave open. An upper end that no demonstration
    sets is not drawn.

    Args:
        scale, units: `metres_per_unit` and `units` of the scene, for the words.
    """
    bands, rims = [], []
    for item in scene.objects or ():
        if rule is None or item.symbol not in rule.value:
            continue
        value = rule.value[item.symbol]
        low, high = rule.interval.get(item.symbol, (value, value))
        low = max(low, 0.0)
        shape: Any = item.outline
        inner = outline_at(shape, low)
        words = f"{item.symbol}: {describe_length(value, scale, units, interval=(low, high))}"
        if math.isfinite(high):
            outer = outline_at(shape, high)
            bands.append(Markup('<path class="ring-band" d="{}{}"/>').format(outer, inner))
            rims.append(Markup('<path class="ring upper" d="{}"/>').format(outer))
        rims.append(
            Markup('<path class="ring lower" d="{}"><title>{}</title></path>').format(inner, words)
        )
    if not rims:
        return Markup()
    # One group, so that overlapping bands are as light as one.
    return Markup('<g class="rings"><g class="ring-bands">{}</g>{}</g>').format(
        joined(bands), joined(rims)
    )


def ring_words_svg(
    scene: Scene,
    rule: ClearanceRule | None,
    scale: float | None = None,
    units: str = "px",
    *,
    unknown: Collection[str] = (),
) -> Markup:
    """The clearance beside one ring of each class, and a question mark where nothing is known.

    To be drawn over everything else.

    Args:
        unknown: Classes of which nothing is known.
    """
    x, y, width, height = view_box(scene)
    size = 0.036 * max(width, height)
    told: list[Markup] = []
    named: set[str] = set()
    for item in scene.objects or ():
        x0, y0, x1, y1 = item.outline.bounds
        middle = (x0 + x1) / 2
        if item.symbol in unknown:
            told.append(
                Markup(
                    '<text class="ring-unknown" x="{:.6g}" y="{:.6g}" font-size="{:.6g}">?<title>'
                    "nothing is known about {}</title></text>"
                ).format(middle, (y0 + y1) / 2 + 0.5 * size, 1.4 * size, item.symbol)
            )
        if rule is None or item.symbol not in rule.value or item.symbol in named:
            continue
        value = rule.value[item.symbol]
        low, high = rule.interval.get(item.symbol, (value, value))
        reach = high if math.isfinite(high) else max(low, 0.0)
        words = describe_length(value, scale, units)
        half = 0.3 * size * len(words)
        above, below = y0 - reach - 0.4 * size, y1 + reach + 1.1 * size
        at = above if above - size > y else below
        if at < y + height:
            named.add(item.symbol)
            middle = min(max(middle, x + half), x + width - half)
            told.append(
                Markup(
                    '<text class="ring-word" x="{:.6g}" y="{:.6g}" font-size="{:.6g}">{}</text>'
                ).format(middle, at, size, words)
            )
    return joined(told)


@lru_cache(maxsize=4096)
def outline_at(shape: Any, distance: float) -> str:
    """SVG path of all points at `distance` ≥ 0 from a footprint, by contouring its distance."""
    return "".join(
        "M" + "L".join(f"{x:.6g} {y:.6g}" for x, y in line[:-1]) + "Z"
        for line in contour_at(shape, distance)
    )


def contour_at(shape: Footprint, distance: float) -> list[Any]:
    """Closed lines (n, 2), the scene's units, at a distance from a footprint."""
    import skimage.measure

    x0, y0, x1, y1 = shape.bounds
    side = max(x1 - x0 + 2 * distance, y1 - y0 + 2 * distance)
    if side <= 0:
        return []
    step = side / 60
    pad = distance + 2 * step
    xs = np.arange(x0 - pad, x1 + pad + step, step)
    ys = np.arange(y0 - pad, y1 + pad + step, step)
    grid = np.stack(np.meshgrid(xs, ys), axis=-1)
    field: Any = shape.signed_distance(grid)
    find: Any = skimage.measure.find_contours
    return [
        np.column_stack([xs[0] + line[:, 1] * step, ys[0] + line[:, 0] * step])
        for line in find(field, distance)
        if len(line) > 3
    ]
