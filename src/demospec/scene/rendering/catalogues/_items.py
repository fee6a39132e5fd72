"""Catalogues of items: meshes, outlines and sprites by name and symbol."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import Polygon
from demospec.scene.rendering._mesh import Mesh, rotation
from demospec.scene.rendering._outlines import outline
from demospec.scene.rendering._sprites import SPRITES, Sprite, draw_sprite

ANGLE_STEPS = 72
"""Items are turned in steps of 5°, so that their sprites can be kept."""


@dataclass(frozen=True)
class CatalogueItem:
    """One thing that can stand on a table.

    Args:
        catalogue, name: Together unique.
        symbol: Class word.
        part: ``train``, ``test`` (unseen in training), or ``carried`` (the thing that moves).
        make: Builds the mesh, item frame, metres.
        creator, licence, source: Attribution, where the mesh is somebody's work.
    """

    catalogue: str
    name: str
    symbol: str
    part: str
    make: Callable[[], Mesh] = field(compare=False, repr=False)
    creator: str = ""
    licence: str = ""
    source: str = ""

    @cached_property
    def mesh(self) -> Mesh:
        """The mesh, centred on the origin."""
        return self.make().centred()

    @cached_property
    def outline_m(self) -> FloatArray:
        """(k, 2) outline of the projection onto the table, item frame, metres."""
        return outline(self.mesh)

    @cached_property
    def radius_m(self) -> float:
        """Radius about the item's centre that holds its outline, metres."""
        return float(np.linalg.norm(self.outline_m, axis=1).max())

    def footprint(self, center: ArrayLike, angle_rad: float, metres_per_px: float) -> Polygon:
        """The outline of the item standing at `center` (pixels), rounded to a thousandth."""
        turned = self.outline_m @ rotation(snap_angle(angle_rad)).T / metres_per_px
        turned[:, 1] *= -1
        return Polygon(np.round(turned + np.asarray(center, dtype=np.float64), 3))

    def sprite(self, angle_rad: float, px_per_metre: float) -> Sprite:
        """The item from above at the nearest step of `ANGLE_STEPS`, kept for the next call."""
        step = round(angle_rad / (2 * np.pi) * ANGLE_STEPS) % ANGLE_STEPS
        key = (self.catalogue, self.name, step, round(px_per_metre, 6))
        sprite = SPRITES.get(key)
        if sprite is None:
            sprite = draw_sprite(self.mesh.turned(step * 2 * np.pi / ANGLE_STEPS), px_per_metre)
            SPRITES.put(key, sprite)
        return sprite


def snap_angle(angle_rad: float) -> float:
    """The nearest angle at which items are drawn, in [0, 2π)."""
    return round(angle_rad / (2 * np.pi) * ANGLE_STEPS) % ANGLE_STEPS * 2 * np.pi / ANGLE_STEPS


@dataclass(frozen=True)
class Catalogue:
    """Items by name and by symbol.

    Args:
        name: ``builtin`` or ``sweethome3d``.
        items: In a fixed order.
    """

    name: str
    items: tuple[CatalogueItem, ...]

    @cached_property
    def _by_name(self) -> dict[str, CatalogueItem]:
        return {item.name: item for item in self.items}

    @property
    def symbols(self) -> tuple[str, ...]:
        """The symbols there are items for, in order of first appearance."""
        return tuple(dict.fromkeys(item.symbol for item in self.items))

    def item(self, name: str) -> CatalogueItem:
        """The item of that name; InputError lists some of those there are."""
        if name not in self._by_name:
            known = ", ".join(list(self._by_name)[:6])
            expected = f"an item of the catalogue {self.name} ({known}, …)"
            raise InputError(expected, name, field="item")
        return self._by_name[name]

    def of_symbol(self, symbol: str) -> tuple[CatalogueItem, ...]:
        """The items of one symbol; InputError where there are none."""
        found = tuple(item for item in self.items if item.symbol == symbol)
        if not found:
            expected = f"a symbol of the catalogue {self.name} ({', '.join(self.symbols)})"
            raise InputError(expected, symbol, field="symbol")
        return found

    def attribution(self) -> list[dict[str, str]]:
        """Name, creator, licence and source of every item that is somebody's work."""
        return [
            {"item": i.name, "creator": i.creator, "licence": i.licence, "source": i.source}
            for i in self.items
            if i.creator
        ]
