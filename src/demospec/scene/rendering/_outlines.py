"""The outline of a mesh's projection onto the table: the union of its triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import Mesh
from demospec.scene.rendering._sprites import coverage

RESOLUTION = 480
"""Samples along the longer side of the box in which the union is found."""


def outline(mesh: Mesh, resolution: int = RESOLUTION) -> FloatArray:
    """(k, 2) outer outline of the union of all projected triangles, item frame, metres.

    The union is found on a fine grid (the longer side has `resolution` samples), traced along
    the boundary of its largest connected part, and thinned so that no removed corner was
    further than 0.7 samples from the new outline. Holes (the ring of a handle) count as inside.
    """
    span = float((mesh.vertices[:, :2].max(axis=0) - mesh.vertices[:, :2].min(axis=0)).max())
    per_metre = resolution / span
    inside, half = coverage(mesh, per_metre)
    loop = _boundary(inside)
    xy = (_midpoints(loop) - half) / per_metre
    xy[:, 1] *= -1
    return _thinned(xy, 0.7 / per_metre)


def _boundary(inside: NDArray[np.bool_]) -> FloatArray:
    """Corners (x, y) of the longest closed boundary of a mask, walked edge by edge."""
    padded = np.pad(inside, 1)
    # Directed edges of the pixel grid with the inside on the right: start corner → end corner.
    edges: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for dy, dx, start, end in (
        (-1, 0, (0, 0), (1, 0)),
        (0, 1, (1, 0), (1, 1)),
        (1, 0, (1, 1), (0, 1)),
        (0, -1, (0, 1), (0, 0)),
    ):
        beyond = np.roll(padded, (-dy, -dx), axis=(0, 1))
        for y, x in np.argwhere(padded & ~beyond).tolist():
            a = (x - 1 + start[0], y - 1 + start[1])
            edges.setdefault(a, []).append((x - 1 + end[0], y - 1 + end[1]))
    best: list[tuple[int, int]] = []
    best_area = -1.0
    while edges:
        first = next(iter(edges))
        loop = [first]
        here = first
        while here in edges:
            there = edges[here]
            step = there.pop()
            if not there:
                del edges[here]
            here = step
            if here == first:
                break
            loop.append(here)
        corners = np.array(loop, dtype=np.float64)
        x, y = corners.T
        area = 0.5 * float(np.abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
        if area > best_area:
            best, best_area = loop, area
    return np.array(best, dtype=np.float64)


def _midpoints(loop: FloatArray) -> FloatArray:
    """Midpoints of the unit edges: they cut the corners of the staircase by half a sample."""
    return np.asarray((loop + np.roll(loop, -1, axis=0)) / 2)


def _thinned(loop: FloatArray, tolerance: float) -> FloatArray:
    """Douglas–Peucker on a closed loop, split at its two corners furthest apart."""
    a = int(np.linalg.norm(loop - loop.mean(axis=0), axis=1).argmax())
    loop = np.roll(loop, -a, axis=0)
    b = int(np.linalg.norm(loop - loop[0], axis=1).argmax())
    closed = np.concatenate([loop, loop[:1]])
    keep = np.zeros(len(closed), dtype=bool)
    keep[[0, b]] = True
    stack = [(0, b), (b, len(closed) - 1)]
    while stack:
        low, high = stack.pop()
        if high - low < 2:
            continue
        chord = closed[high] - closed[low]
        rel = closed[low + 1 : high] - closed[low]
        length = float(np.hypot(*chord))
        if length > 0:
            gap = np.abs(chord[0] * rel[:, 1] - chord[1] * rel[:, 0]) / length
        else:
            gap = np.linalg.norm(rel, axis=1)
        worst = int(gap.argmax())
        if gap[worst] > tolerance:
            middle = low + 1 + worst
            keep[middle] = True
            stack += [(low, middle), (middle, high)]
    return np.asarray(closed[:-1][keep[:-1]])
