"""The part of the plane that a drawing of a scene shows."""

from __future__ import annotations

from demospec.scene import Scene


def view_box(scene: Scene) -> tuple[float, float, float, float]:
    """(x, y, width, height) of the picture; without one, of start, goal and objects.

    Without a picture it is never a strip: there is room beside the straight line for paths.
    """
    if scene.size_px is not None:
        return (0.0, 0.0, float(scene.size_px[0]), float(scene.size_px[1]))
    boxes = [item.outline.bounds for item in scene.objects or ()]
    xs = [scene.start[0], scene.goal[0], *(b[0] for b in boxes), *(b[2] for b in boxes)]
    ys = [scene.start[1], scene.goal[1], *(b[1] for b in boxes), *(b[3] for b in boxes)]
    side = max(max(xs) - min(xs), max(ys) - min(ys)) or 1.0
    width, height = (max(max(v) - min(v) + 0.2 * side, 0.7 * side) for v in (xs, ys))
    left, top = (0.5 * (max(v) + min(v) - wide) for v, wide in ((xs, width), (ys, height)))
    return (left, top, width, height)


def line_width(scene: Scene) -> float:
    """Width of a thin line, in the scene's units."""
    _, _, width, height = view_box(scene)
    return max(width, height) / 200
