"""Scene: a top-down picture, the objects in it, a start and a goal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import CannotJudgeError
from demospec.geometry import (
    Bounds,
    Disc,
    Footprint,
    MultiPolygon,
    Polygon,
    bounds_of,
    extent,
    radius_about,
    rectangle,
    similar,
)
from demospec.scene._picture import Image, Picture

if TYPE_CHECKING:
    from demospec.scene._recipe import SceneRecipe


@dataclass(frozen=True)
class SceneObject:
    """One object on the table.

    Args:
        id: Unique in its scene.
        symbol: Class word, such as ``glass``.
        center: Pixels.
        bbox: (x, y, width, height), pixels, or None.
        footprint: Outline on the table, or None where it is not known. Read from
            ``polygons`` (several parts), else from ``polygon``, else from ``radius``, else
            from ``bbox`` (as a rectangle).
        heading_deg: Direction that it faces, from +x towards +y, degrees; None where it has
            none or it is not known.
        height: Lowest and highest z of the object, set units, or None.
    """

    id: str
    symbol: str
    center: tuple[float, float]
    bbox: tuple[float, float, float, float] | None = None
    footprint: Footprint | None = None
    heading_deg: float | None = None
    height: tuple[float, float] | None = None

    @property
    def outline(self) -> Footprint:
        """The footprint where known, else the centre as a disc of radius 0."""
        return self.footprint if self.footprint is not None else Disc(self.center, 0.0)

    @property
    def outline_radius(self) -> float:
        """Radius about the centre that holds the outline, set units."""
        return radius_about(self.outline, self.center)

    def moved(self, by: ArrayLike) -> SceneObject:
        """The same object translated by `by` (2,), pixels."""
        dx, dy = (float(v) for v in np.asarray(by, dtype=np.float64))
        box = self.bbox and (self.bbox[0] + dx, self.bbox[1] + dy, self.bbox[2], self.bbox[3])
        shape = self.footprint.moved((dx, dy)) if self.footprint is not None else None
        return replace(
            self, center=(self.center[0] + dx, self.center[1] + dy), bbox=box, footprint=shape
        )

    def mapped(self, matrix: ArrayLike, offset: ArrayLike = (0.0, 0.0)) -> SceneObject:
        """The same object under p ↦ matrix p + offset: turned, mirrored, scaled, moved.

        Args:
            matrix: (2, 2), a rotation or reflection times a factor; the factor scales the
                height too.
            offset: (2,), pixels.
        """
        m, o = np.asarray(matrix, dtype=np.float64), np.asarray(offset, dtype=np.float64)
        x, y = m @ np.asarray(self.center) + o
        shape = None if self.footprint is None else similar(self.footprint, m, o)
        box, heading, height = self.bbox, self.heading_deg, self.height
        if box is not None:
            outline = shape if shape is not None and m.all() else similar(rectangle(*box), m, o)
            x0, y0, x1, y1 = outline.bounds
            box = (x0, y0, x1 - x0, y1 - y0)
        scales_only = m[0, 0] > 0 and bool((m == m[0, 0] * np.eye(2)).all())
        if heading is not None and not scales_only:
            ahead = np.deg2rad(heading)
            along = m @ np.array([np.cos(ahead), np.sin(ahead)])
            heading = float(np.rad2deg(np.arctan2(along[1], along[0])))
        if height is not None:
            factor = float(np.sqrt(abs(np.linalg.det(m))))
            height = (height[0] * factor, height[1] * factor)
        return replace(
            self, center=(float(x), float(y)), bbox=box, footprint=shape, heading_deg=heading,
            height=height,
        )  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """The object as in ``scenes/metadata.jsonl``."""
        document: dict[str, Any] = {
            "id": self.id,
            "symbol": self.symbol,
            "center": list(self.center),
        }
        if self.bbox is not None:
            document["bbox"] = list(self.bbox)
        if isinstance(self.footprint, Polygon) and self.footprint != _box(self.bbox):
            document["polygon"] = self.footprint.vertices.tolist()
        elif isinstance(self.footprint, MultiPolygon):
            document["polygons"] = [part.vertices.tolist() for part in self.footprint.parts]
        elif isinstance(self.footprint, Disc):
            document["radius"] = self.footprint.radius
        if self.heading_deg is not None:
            document["heading_deg"] = self.heading_deg
        if self.height is not None:
            document["height"] = list(self.height)
        return document


def _box(bbox: tuple[float, float, float, float] | None) -> Polygon | None:
    return None if bbox is None else rectangle(*bbox)


@dataclass(frozen=True)
class Relation:
    """Two objects that belong together, such as people who talk to each other.

    Args:
        kind: A word, such as ``interact``.
        between: Ids of the two objects.
    """

    kind: str
    between: tuple[str, str]

    def to_json(self) -> dict[str, Any]:
        """The relation as in ``scenes/metadata.jsonl``."""
        return {"kind": self.kind, "between": list(self.between)}


@dataclass(frozen=True)
class Scene:
    """A top-down scene.

    Args:
        scene_id: Unique in its set.
        start: Where demonstrations begin, pixels, shape (2,).
        goal: Where they end, pixels, shape (2,).
        objects: None means *not listed*, which is not an empty table.
        picture: None where the set has object lists only.
        split: ``train`` or ``test``.
        extra: Further keys of the metadata line, kept as they came.
        recipe: What a rendered scene was drawn from; None for a photograph.
        relations: Which of the objects belong together. One that names an object which the
            list does not hold (any longer) says nothing and is left out.
        metres_per_unit: Of a picture of another scale than its set; None: as the set says.
    """

    scene_id: str
    start: tuple[float, ...]
    goal: tuple[float, ...]
    objects: tuple[SceneObject, ...] | None = None
    picture: Picture | None = None
    split: str = "train"
    extra: tuple[tuple[str, Any], ...] = ()
    recipe: SceneRecipe | None = None
    relations: tuple[Relation, ...] = ()
    metres_per_unit: float | None = None

    def __post_init__(self) -> None:
        if self.relations and self.objects is not None:
            listed = {o.id for o in self.objects}
            kept = tuple(r for r in self.relations if listed.issuperset(r.between))
            object.__setattr__(self, "relations", kept)

    def __hash__(self) -> int:
        return hash(self.scene_id)

    @property
    def size_px(self) -> tuple[int, int] | None:
        """(width, height) of the picture, or None without one."""
        return None if self.picture is None else self.picture.size_px

    @property
    def bounds(self) -> Bounds:
        """Box around the objects' footprints, start and goal, set units."""
        found = bounds_of([self.start[:2], self.goal[:2]], [o.outline for o in self.objects or ()])
        assert found is not None
        return found

    @property
    def length_scale(self) -> float:
        """The longer side of `bounds`, set units: the scene's size, whatever the unit."""
        return extent(self.bounds)

    def listed_objects(self) -> tuple[SceneObject, ...]:
        """The objects; CannotJudgeError where the scene does not list them."""
        if self.objects is None:
            raise CannotJudgeError(
                "a list of objects (a rule cannot see; `demospec detect` makes the list)",
                "objects not listed",
                row=f"scene {self.scene_id}",
                field="objects",
            )
        return self.objects

    def shown_picture(self) -> Picture:
        """The picture; CannotJudgeError where the scene has none."""
        if self.picture is None:
            raise CannotJudgeError(
                "a picture", "none", row=f"scene {self.scene_id}", field="file_name"
            )
        return self.picture

    def pixels(self) -> Image:
        """(height, width, 3) uint8; CannotJudgeError where the scene has no picture."""
        return self.shown_picture().pixels

    def seen(self) -> Scene:
        """The scene as a camera delivers it: without list, relations, and what it was drawn from.

        A learner that is to find the objects by itself gets this one.
        """
        return replace(self, objects=None, recipe=None, relations=())

    def with_changes(
        self, *, objects: tuple[SceneObject, ...] | None, picture: Picture | None
    ) -> Scene:
        """The same scene with other objects and another picture (an intervention)."""
        return replace(self, objects=objects, picture=picture)
