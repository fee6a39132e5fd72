"""One scene with its demonstrations as SVG: crisp at any size, drawn by the browser."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterable

import numpy as np
from markupsafe import Markup

from demospec.demonstrations import Demonstration
from demospec.geometry import Disc, Footprint, rims
from demospec.report.drawing._markup import joined
from demospec.report.drawing._window import line_width, view_box
from demospec.scene import Scene

VERDICTS = {True: "accepted", False: "rejected", None: "unsaid"}

_SMALL_PIXELS = 400 * 400
"""Up to here a picture travels as it is; larger ones as JPEG."""


def short_name(demo_id: str) -> str:
    """``#7`` for the seventh path drawn in the studio, else the name itself."""
    found = re.fullmatch(r"drawn-0*(\d+)", demo_id)
    return f"#{found[1]}" if found else demo_id


def scene_svg(
    scene: Scene,
    inner: str | Markup = "",
    *,
    picture_url: str | None = None,
    alt: str = "",
    look: str = "scene",
    names: bool = False,
) -> Markup:
    """Picture, outlined objects with their names, what is put over them, start and goal.

    Args:
        inner: Drawn between the objects and the ends (`paths_svg`, `rings_svg`).
        picture_url: Where the browser finds the picture; by default it is inside.
        alt: What the drawing shows, for those who cannot see it.
        look: Classes for the style sheet; with ``outlined`` the outlines are always seen.
        names: Write the class of every object beside it.
    """
    _, _, width, height = view_box(scene)
    parts: list[str | Markup] = []
    if scene.picture is not None:
        parts.append(
            Markup(
                '<image href="{}" x="0" y="0" width="{:g}" height="{:g}" '
                'preserveAspectRatio="none"/>'
            ).format(picture_url or data_url(scene), width, height)
        )
    parts += [objects_svg(scene, names=names), inner, ends_svg(scene)]
    attributes = Markup('role="img" aria-label="{}"').format(alt or f"Scene {scene.scene_id}")
    return _svg(scene, look, attributes, joined(parts))


def over_svg(scene: Scene, inner: str | Markup) -> Markup:
    """An SVG of the same view as `scene_svg`, to lie over it."""
    return _svg(scene, "scene over", Markup('aria-hidden="true"'), inner)


def _svg(scene: Scene, look: str, attributes: Markup, inner: str | Markup) -> Markup:
    x, y, width, height = view_box(scene)
    return Markup(
        '<svg class="{}" viewBox="{:g} {:g} {:g} {:g}" {} style="--line-px:{:g}px" '
        'xmlns="http://www.w3.org/2000/svg">{}</svg>'
    ).format(look, x, y, width, height, attributes, line_width(scene), inner)


def objects_svg(scene: Scene, *, names: bool = False) -> Markup:
    """Outlines of the listed objects; with `names` their class is written beside them."""
    size = 7 * line_width(scene)
    parts = []
    for item in scene.objects or ():
        told = Markup()
        if names or scene.picture is None:
            x0, _, x1, y1 = item.outline.bounds
            told = Markup('<text x="{:g}" y="{:g}" font-size="{:g}">{}</text>').format(
                (x0 + x1) / 2, y1 + 1.1 * size, size, item.symbol
            )
        parts.append(
            Markup('<g class="object" data-id="{}">{}<title>{} ({})</title>{}</g>').format(
                item.id, outline_svg(item.outline), item.symbol, item.id, told
            )
        )
    return joined(parts)


def ends_svg(scene: Scene, *, words: bool = False) -> Markup:
    """The start as a circle, the goal as a star; with `words` named so."""
    x, _, width, _ = view_box(scene)
    r = 4 * line_width(scene)
    parts = []
    for (ex, ey, *_), name in ((scene.start, "start"), (scene.goal, "goal")):
        parts.append(
            Markup(
                '<circle class="end" data-end="start" cx="{:g}" cy="{:g}" r="{:g}">'
                "<title>start</title></circle>"
            ).format(ex, ey, r)
            if name == "start"
            else Markup(
                '<path class="end" data-end="goal" d="{}"><title>goal</title></path>'
            ).format(_star(ex, ey, 1.6 * r))
        )
        if words:
            # Beside the mark, on the side where there is room.
            right = ex - x < width / 2
            at, anchor = (ex + 2.2 * r, "start") if right else (ex - 2.2 * r, "end")
            parts.append(
                Markup(
                    '<text class="end-word" x="{:g}" y="{:g}" font-size="{:g}" '
                    'text-anchor="{}">{}</text>'
                ).format(at, ey + 0.6 * r, 1.7 * r, anchor, name)
            )
    return joined(parts)


def paths_svg(demonstrations: Iterable[Demonstration], chosen: str | None = None) -> Markup:
    """Paths, each a light line under one in the colour and dash of its verdict."""
    parts = []
    for demo in demonstrations:
        verdict = VERDICTS[demo.valid]
        points = points_of(demo.xy)
        who = demo.demonstrator or demo.type
        parts.append(
            Markup(
                '<polyline class="halo" points="{0}"/><polyline class="path {1}{2}" '
                'points="{0}" data-id="{3}"><title>{4}: {1}{5}</title></polyline>'
            ).format(
                points,
                verdict,
                " chosen" if demo.demo_id == chosen else "",
                demo.demo_id,
                short_name(demo.demo_id),
                f" by {who}" if who else "",
            )
        )
    return joined(parts)


def line_svg(path: Iterable[Iterable[float]], look: str) -> Markup:
    """One line of a class of its own over a light one: a plan, a question."""
    return Markup(
        '<polyline class="halo" points="{0}"/><polyline class="{1}" points="{0}"/>'
    ).format(points_of(path), look)


def crosses_svg(scene: Scene, places: Iterable[tuple[float, float]]) -> Markup:
    """A cross at each place, set units."""
    r = 2.5 * line_width(scene)
    parts = [
        Markup('<path class="{}" d="M{:.6g} {:.6g}l{:.6g} {:.6g}m0 {:.6g}l{:.6g} {:.6g}"/>').format(
            look, x - r, y - r, 2 * r, 2 * r, -2 * r, -2 * r, 2 * r
        )
        for x, y in places
        for look in ("halo", "cross")
    ]
    return joined(parts)


def points_of(path: Iterable[Iterable[float]]) -> str:
    """The ``points`` of a polyline."""
    return " ".join(f"{x:.6g},{y:.6g}" for x, y, *_ in path)


def data_url(scene: Scene) -> str:
    """The scene's picture within an address: as PNG, a large one as JPEG."""
    import PIL.Image

    image = PIL.Image.fromarray(np.asarray(scene.pixels()))
    buffer = io.BytesIO()
    if image.size[0] * image.size[1] > _SMALL_PIXELS:
        image.save(buffer, format="JPEG", quality=85)
        kind = "jpeg"
    else:
        image.save(buffer, format="PNG", compress_level=1)  # quick, not small
        kind = "png"
    return f"data:image/{kind};base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def outline_svg(shape: Footprint) -> Markup:
    """A footprint, one shape a part."""
    if isinstance(shape, Disc):
        (x, y), radius = shape.center, shape.radius
        return Markup('<circle cx="{:g}" cy="{:g}" r="{:g}"/>').format(x, y, radius)
    polygon = Markup('<polygon points="{}"/>')
    return joined(polygon.format(points_of(rim)) for rim in rims(shape))


def _star(x: float, y: float, r: float) -> str:
    angle = -np.pi / 2 + np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2 == 0, r, 0.45 * r)
    points = zip(x + radius * np.cos(angle), y + radius * np.sin(angle), strict=True)
    return "M" + "L".join(f"{px:.6g} {py:.6g}" for px, py in points) + "Z"
