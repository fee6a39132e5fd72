"""Parts of random solids: colours, plans of bodies of revolution, patterns."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.frames import FloatArray
from demospec.perception.synthetic._backgrounds import near_colour, random_colour
from demospec.scene import Mesh

FLAT, HOLLOW, CLEAR, LONG, TOOL, BLOCK, ROUND = range(7)
"""Positions in `KINDS`."""


@dataclass(frozen=True)
class Solid:
    """A mesh whose unit is the pixel.

    Args:
        kind: Position in `KINDS`.
        mesh: Centred on the origin, standing on the table.
        filled: The surface of what it holds, in the mesh's frame, or None.
    """

    kind: int
    mesh: Mesh
    filled: Mesh | None = None


class Paint:
    """Colours of one thing: some alike, some not, some like the table."""

    def __init__(self, rng: np.random.Generator, table: FloatArray) -> None:
        self.rng = rng
        pick = rng.random()
        if pick < 0.2:
            self.base = near_colour(rng, np.asarray(table, np.float32), rng.uniform(0.03, 0.2))
        elif pick < 0.4:
            self.base = np.asarray(rng.uniform(0.6, 0.98) + rng.normal(0, 0.03, 3), np.float32)
        else:
            self.base = random_colour(rng)
        self.gloss = float(rng.choice([0.0, 0.2, 0.5, 0.9], p=[0.15, 0.3, 0.3, 0.25]))

    def same(self) -> FloatArray:
        shade = self.base * self.rng.uniform(0.9, 1.08)
        return np.asarray(np.clip(shade, 0.02, 0.98), np.float64)

    def other(self, different: float) -> FloatArray:
        """A colour for another part: another one with that probability."""
        if self.rng.random() < different:
            return random_colour(self.rng).astype(np.float64)
        return self.same()


def form_of(rng: np.random.Generator, round_share: float) -> dict[str, object]:
    """Plan of a body of revolution: round, oval, squarish, scalloped."""
    pick = rng.random()
    if pick < round_share:
        return {}
    pick = rng.random()
    if pick < 0.4:
        return {"stretch": (float(rng.uniform(0.95, 1.2)), float(rng.uniform(0.6, 0.95)))}
    if pick < 0.75:
        return {
            "squareness": float(rng.uniform(0.1, 1.0)),
            "stretch": (1.0, float(rng.uniform(0.7, 1.0))),
        }
    return {"lobes": (int(rng.integers(5, 18)), float(rng.uniform(0.01, 0.07)))}


def patterned(rng: np.random.Generator, mesh: Mesh, radius: float) -> Mesh:
    """Bands, petals or blots of another colour, face by face."""
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    r, phi = np.hypot(centre[:, 0], centre[:, 1]) / radius, np.arctan2(centre[:, 1], centre[:, 0])
    pick = rng.random()
    if pick < 0.45:
        at, wide = rng.uniform(0.2, 1.0), rng.uniform(0.03, 0.25)
        mask = np.abs(r - at) < wide
    elif pick < 0.8:
        mask = np.sin(int(rng.integers(3, 14)) * phi + rng.uniform(0, 6)) > rng.uniform(-0.3, 0.7)
        mask &= r > rng.uniform(0.0, 0.8)
    else:
        return speckled(rng, mesh)
    colour = mesh.colour.copy()
    share = rng.uniform(0.3, 1.0)
    colour[mask] = (1 - share) * colour[mask] + share * random_colour(rng)
    return replace(mesh, colour=colour)


def speckled(rng: np.random.Generator, mesh: Mesh) -> Mesh:
    colours = np.stack([random_colour(rng) for _ in range(int(rng.integers(2, 5)))])
    which = rng.integers(len(colours), size=len(mesh.faces))
    share = rng.uniform(0.2, 1.0) * rng.random((len(mesh.faces), 1))
    return replace(mesh, colour=(1 - share) * mesh.colour + share * colours[which])


def rectangle(half_x: float, half_y: float) -> FloatArray:
    a, b = half_x, half_y
    return np.array([(a, -b), (a, b), (-a, b), (-a, -b)])
