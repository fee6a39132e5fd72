"""Recipe of a rendered scene: scale, table top, light, and the catalogue item behind each object.

It names the true items, so that a scene as a camera delivers it (`Scene.seen`) has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from demospec.errors import InputError

TABLE_KINDS = ("wood", "cloth", "stone")


@dataclass(frozen=True)
class Light:
    """One lamp, and light from everywhere.

    Args:
        azimuth: Direction to the lamp, radians; 0 = right, π/2 = *down* in the picture.
        elevation: Of the lamp above the table, radians.
        strength: Brightness of a white table.
        ambient: Share of the light that comes from everywhere.
        warmth: Red up, blue down.
        softness: Size of the lamp: how fast a shadow's edge widens with the height that casts it.
    """

    azimuth: float = -2.3
    elevation: float = 1.15
    strength: float = 1.0
    ambient: float = 0.5
    warmth: float = 0.0
    softness: float = 0.18

    def __post_init__(self) -> None:
        for field in fields(self):
            _finite(getattr(self, field.name), f"light.{field.name}")


@dataclass(frozen=True)
class TableTop:
    """A procedural table top: one of `TABLE_KINDS`, and the seed of its pattern."""

    kind: str
    seed: int

    def __post_init__(self) -> None:
        if self.kind not in TABLE_KINDS:
            expected = f"one of the tables {', '.join(TABLE_KINDS)}"
            raise InputError(expected, self.kind, field="table.kind")
        if (
            isinstance(self.seed, bool)
            or not isinstance(self.seed, int)
            or not (0 <= self.seed < 2**63)
        ):
            raise InputError("a table with kind and seed", self.seed, field="table.seed")


@dataclass(frozen=True)
class CatalogueEntry:
    """The catalogue item that an object is, and its angle (radians, counter-clockwise)."""

    catalogue: str
    item: str
    angle: float


@dataclass(frozen=True)
class SceneRecipe:
    """All that a rendered scene was drawn from, beside the objects' places.

    Args:
        metres_per_px: Scale, > 0.
        table: The table top.
        light: The lamp.
        items: Object id → catalogue item.
    """

    metres_per_px: float
    table: TableTop
    light: Light
    items: Mapping[str, CatalogueEntry]

    def __post_init__(self) -> None:
        if not _finite(self.metres_per_px, "metres_per_px") > 0:
            raise InputError("a number > 0", self.metres_per_px, field="metres_per_px")

    def with_item(self, object_id: str, entry: CatalogueEntry) -> SceneRecipe:
        """The recipe with one more object (last), or another item for one."""
        rest = {name: old for name, old in self.items.items() if name != object_id}
        return replace(self, items={**rest, object_id: entry})

    def without_item(self, object_id: str) -> SceneRecipe:
        """The recipe without one object."""
        rest = {name: entry for name, entry in self.items.items() if name != object_id}
        return replace(self, items=rest)

    def to_json(self) -> dict[str, Any]:
        """The value of ``render`` in ``scenes/metadata.jsonl``."""
        return asdict(self)

    @classmethod
    def from_json(cls, document: Any) -> SceneRecipe | None:
        """The recipe of a value of ``render``; None where it is something else of the user's.

        Raises:
            InputError: It has the keys of a recipe, and one of them holds something else.
        """
        if not isinstance(document, dict) or not {f.name for f in fields(cls)} <= set(document):
            return None
        try:
            return cls(
                document["metres_per_px"],
                _table(document["table"]),
                _light(document["light"]),
                _items(document["items"]),
            )
        except InputError as error:
            raise InputError(error.expected, error.found, field=f"render.{error.field}") from error


def _finite(value: Any, field: str) -> float:
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not good or not math.isfinite(value):
        raise InputError("a finite number", value, field=field)
    return float(value)


def _table(document: Any) -> TableTop:
    if not isinstance(document, dict) or not {"kind", "seed"} <= set(document):
        raise InputError("a table with kind and seed", document, field="table")
    return TableTop(document["kind"], document["seed"])


def _light(document: Any) -> Light:
    if not isinstance(document, dict):
        raise InputError("a light", document, field="light")
    return Light(*(_finite(document.get(f.name), f"light.{f.name}") for f in fields(Light)))


def _items(document: Any) -> dict[str, CatalogueEntry]:
    if not isinstance(document, dict):
        raise InputError("items by object id", document, field="items")
    out = {}
    for name, entry in document.items():
        field = f"items.{name}"
        if not isinstance(entry, dict) or not all(
            isinstance(entry.get(key), str) for key in ("catalogue", "item")
        ):
            raise InputError("catalogue, item and angle", entry, field=field)
        angle = _finite(entry.get("angle"), f"{field}.angle")
        out[name] = CatalogueEntry(entry["catalogue"], entry["item"], angle)
    return out
