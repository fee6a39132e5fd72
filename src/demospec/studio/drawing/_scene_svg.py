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
from demospec.scene import Scene
from demospec.studio.drawing._markup import joined

VERDICTS = {True: "accepted", False: "rejected", None: "unsaid"}


def short_name(demo_id: str) -> str:
    """``#7`` for the seventh path drawn here, else the name itself."""
    found = re.fullmatch(r"drawn-0*(\d+)", demo_id)
    return f"#{found[1]}" if found else demo_id


def view_box(scene: Scene) -> tuple[float, float, float, float]:
    """(x, y, width, height) of the picture; without one, of start, goal and objects."""
    if scene.size_px is not None:
        return (0.0, 0.0, float(scene.size_px[0]), float(scene.size_px[1]))
    boxes = [item.outline.bounds for item in scene.objects or ()]
    xs = [scene.start[0], scene.goal[0], *(b[0] for b in boxes), *(b[2] for b in boxes)]
    ys = [scene.start[1], scene.goal[1], *(b[1] for b in boxes), *(b[3] for b in boxes)]
    pad = 0.1 * max(max(xs) - min(xs), max(ys) - min(ys), 1.0)
    return (
        min(xs) - pad,
        min(ys) - pad,
        max(xs) - min(xs) + 2 * pad,
        max(ys) - min(ys) + 2 * pad,
    )


def scene_svg(
    scene: Scene, demonstrations: Iterable[Demonstration] = (), *, picture_url: str | None = None
) -> Markup:
    """Picture, outlined objects with their names, paths with class by verdict.

    Args:
        picture_url: Where the browser finds the picture; by default it is inside, as PNG data.
    """
    x, y, width, height = view_box(scene)
    parts = []
    if scene.picture is not None:
        parts.append(
            Markup(
                '<image href="{}" x="0" y="0" width="{:g}" height="{:g}" '
                'preserveAspectRatio="none"/>'
            ).format(picture_url or data_url(scene), width, height)
        )
    for item in scene.objects or ():
        parts.append(
            Markup('<g class="object">{}<title>{} ({})</title></g>').format(
                _outline(item.outline), item.symbol, item.id
            )
        )
    parts += [paths_svg(demonstrations), ends_svg(scene)]
    return Markup(
        '<svg class="scene" viewBox="{:g} {:g} {:g} {:g}" role="img" aria-label="Scene {}" '
        'style="--line-px:{:g}px" xmlns="http://www.w3.org/2000/svg">{}</svg>'
    ).format(x, y, width, height, scene.scene_id, max(width, height) / 200, joined(parts))


def marks_svg(scene: Scene, inner: Markup) -> Markup:
    """An SVG of the same view as `scene_svg`, to lie over it."""
    x, y, width, height = view_box(scene)
    return Markup(
        '<svg class="scene over" viewBox="{:g} {:g} {:g} {:g}" aria-hidden="true" '
        'style="--line-px:{:g}px" xmlns="http://www.w3.org/2000/svg">{}</svg>'
    ).format(x, y, width, height, max(width, height) / 200, inner)


def ends_svg(scene: Scene, *, words: bool = False) -> Markup:
    """The start as a circle, the goal as a star; with `words` named so."""
    x, _, width, height = view_box(scene)
    r = max(width, height) / 50
    parts = []
    for (ex, ey, *_), name in ((scene.start, "start"), (scene.goal, "goal")):
        parts.append(
            Markup(
                '<circle class="end" cx="{:g}" cy="{:g}" r="{:g}"><title>start</title></circle>'
            ).format(ex, ey, r)
            if name == "start"
            else Markup('<path class="end" d="{}"><title>goal</title></path>').format(
                _star(ex, ey, 1.6 * r)
            )
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


def points_of(path: Iterable[Iterable[float]]) -> str:
    """The ``points`` of a polyline."""
    return " ".join(f"{x:.2f},{y:.2f}" for x, y, *_ in path)


def data_url(scene: Scene) -> str:
    """The scene's picture as PNG within an address."""
    import PIL.Image

    buffer = io.BytesIO()
    PIL.Image.fromarray(np.asarray(scene.pixels())).save(
        buffer,
        format="PNG",
        compress_level=1,  # it stays on this machine: quick, not small
    )
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def _outline(shape: Footprint) -> Markup:
    if isinstance(shape, Disc):
        x, y = shape.center
        radius = max(shape.radius, 0.5)
        return Markup('<circle cx="{:g}" cy="{:g}" r="{:g}"/>').format(x, y, radius)
    polygon = Markup('<polygon points="{}"/>')
    return joined(polygon.format(points_of(rim)) for rim in rims(shape))


def _star(x: float, y: float, r: float) -> str:
    angle = -np.pi / 2 + np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2 == 0, r, 0.45 * r)
    points = zip(x + radius * np.cos(angle), y + radius * np.sin(angle), strict=True)
    return "M" + "L".join(f"{px:.2f} {py:.2f}" for px, py in points) + "Z"
