"""One scene with its demonstrations as SVG: crisp at any size, drawn by the browser."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterable
from html import escape

import numpy as np

from demospec.demonstrations import Demonstration
from demospec.scene import Capsule, Disc, Footprint, Polygon, Scene

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
) -> str:
    """SVG text: picture, outlined objects with their names, paths with class by verdict.

    Everything that came from a file is escaped.

    Args:
        picture_url: Where the browser finds the picture; by default it is inside, as PNG data.
    """
    x, y, width, height = view_box(scene)
    line = max(width, height) / 200
    parts = [
        f'<svg class="scene" viewBox="{x:g} {y:g} {width:g} {height:g}" role="img" '
        f'aria-label="Scene {escape(scene.scene_id)}" style="--line-px:{line:g}px" '
        'xmlns="http://www.w3.org/2000/svg">'
    ]
    if scene.picture is not None:
        parts.append(
            f'<image href="{picture_url or data_url(scene)}" x="0" y="0" '
            f'width="{width:g}" height="{height:g}" preserveAspectRatio="none"/>'
        )
    for item in scene.objects or ():
        parts.append(
            f'<g class="object">{_outline(item.outline)}<title>{escape(item.symbol)} '
            f"({escape(item.id)})</title></g>"
        )
    parts.append(paths_svg(demonstrations))
    parts.append(ends_svg(scene))
    parts.append("</svg>")
    return "".join(parts)


def marks_svg(scene: Scene, inner: str) -> str:
    """An SVG of the same view as `scene_svg`, to lie over it."""
    x, y, width, height = view_box(scene)
    line = max(width, height) / 200
    return (
        f'<svg class="scene over" viewBox="{x:g} {y:g} {width:g} {height:g}" aria-hidden="true" '
        f'style="--line-px:{line:g}px" xmlns="http://www.w3.org/2000/svg">{inner}</svg>'
    )


def ends_svg(scene: Scene, *, words: bool = False) -> str:
    """The start as a circle, the goal as a star; with `words` named so."""
    x, _, width, height = view_box(scene)
    r = max(width, height) / 50
    parts = []
    for (ex, ey, *_), shape, name in (
        (scene.start, "circle", "start"),
        (scene.goal, "star", "goal"),
    ):
        title = f"<title>{name}</title>"
        parts.append(
            f'<circle class="end" cx="{ex:g}" cy="{ey:g}" r="{r:g}">{title}</circle>'
            if shape == "circle"
            else f'<path class="end" d="{_star(ex, ey, 1.6 * r)}">{title}</path>'
        )
        if words:
            # Beside the mark, on the side where there is room.
            right = ex - x < width / 2
            at, anchor = (ex + 2.2 * r, "start") if right else (ex - 2.2 * r, "end")
            parts.append(
                f'<text class="end-word" x="{at:g}" y="{ey + 0.6 * r:g}" '
                f'font-size="{1.7 * r:g}" text-anchor="{anchor}">{name}</text>'
            )
    return "".join(parts)


def paths_svg(demonstrations: Iterable[Demonstration], chosen: str | None = None) -> str:
    """Paths, each a light line under one in the colour and dash of its verdict."""
    parts = []
    for demo in demonstrations:
        verdict = VERDICTS[demo.valid]
        points = " ".join(f"{px:.2f},{py:.2f}" for px, py in demo.xy)
        who = demo.demonstrator or demo.type
        by = f" by {escape(who)}" if who else ""
        mark = " chosen" if demo.demo_id == chosen else ""
        name = escape(demo.demo_id)
        parts.append(
            f'<polyline class="halo" points="{points}"/>'
            f'<polyline class="path {verdict}{mark}" points="{points}" data-id="{name}"><title>'
            f"{escape(short_name(demo.demo_id))}: {verdict}{by}</title></polyline>"
        )
    return "".join(parts)


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


def _outline(shape: Footprint) -> str:
    if isinstance(shape, Polygon):
        points = " ".join(f"{x:.2f},{y:.2f}" for x, y in shape.vertices)
        return f'<polygon points="{points}"/>'
    if isinstance(shape, Disc):
        x, y = shape.center
        return f'<circle cx="{x:g}" cy="{y:g}" r="{max(shape.radius, 0.5):g}"/>'
    assert isinstance(shape, Capsule)
    (x0, y0), (x1, y1) = shape.start, shape.end
    width = 2 * shape.radius
    return (
        f'<line x1="{x0:g}" y1="{y0:g}" x2="{x1:g}" y2="{y1:g}" '
        f'stroke-width="{width:g}" stroke-linecap="round"/>'
    )


def _star(x: float, y: float, r: float) -> str:
    angle = -np.pi / 2 + np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2 == 0, r, 0.45 * r)
    points = zip(x + radius * np.cos(angle), y + radius * np.sin(angle), strict=True)
    return "M" + "L".join(f"{px:.2f} {py:.2f}" for px, py in points) + "Z"
