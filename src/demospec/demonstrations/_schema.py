"""The set format as pydantic models: what is checked on reading, and the JSON Schema source."""

from __future__ import annotations

import math
import os
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from demospec.demonstrations._trajectory import LEAST_SCALE, MAX_COORDINATE, MAX_SCALE
from demospec.errors import InputError
from demospec.files import to_json
from demospec.frames import Frame
from demospec.geometry import Disc, Footprint, MultiPolygon, Polygon, rectangle
from demospec.scene import Picture, Relation, Scene, SceneObject, SceneRecipe

M = TypeVar("M", bound=BaseModel)


def _coordinate(value: float) -> float:
    if not math.isfinite(value) or abs(value) > MAX_COORDINATE:
        raise ValueError(f"must be a finite number of size at most {MAX_COORDINATE:.0e}")
    return value


Coordinate = Annotated[
    float,
    AfterValidator(_coordinate),
    Field(json_schema_extra={"minimum": -MAX_COORDINATE, "maximum": MAX_COORDINATE}),
]


def _box(value: list[float]) -> list[float]:
    if min(value[2:]) < 0:
        raise ValueError("must be [x, y, width, height] with width and height of at least 0")
    return value


def _ascending(value: list[float]) -> list[float]:
    if value[1] < value[0]:
        raise ValueError("must be [z_low, z_high] with z_low at most z_high")
    return value


Corners = Annotated[
    list[Annotated[list[Coordinate], Field(min_length=2, max_length=2)]], Field(min_length=3)
]

Name = Annotated[str, Field(min_length=1, max_length=1000)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)


Row = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]

Scale = Annotated[float, Field(ge=LEAST_SCALE, le=MAX_SCALE, allow_inf_nan=False)]


class FrameEntry(_Strict):
    """The frame of a set's points: its name, where y points, and for pixels that were metres the
    homography from set coordinates to metres in it."""

    name: Name | None = None
    y: Literal["up", "down"]
    homography: Annotated[list[Row], Field(min_length=3, max_length=3)] | None = None

    def to_frame(self) -> Frame:
        """The frame; InputError for a homography that has no inverse."""
        if self.homography is None:
            return Frame(self.name, self.y)
        (a, b, c), (d, e, f), (g, h, i) = self.homography
        if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) == 0:
            raise InputError("an invertible 3x3 matrix", self.homography, field="frame.homography")
        return Frame(self.name, self.y, ((a, b, c), (d, e, f), (g, h, i)))


class Header(_Strict):
    """``dataset.json``."""

    format: Literal["demospec"]
    version: Annotated[int, Field(ge=1)] = 1
    name: str = "unnamed"
    units: str = "px"
    metres_per_unit: Scale | None = None
    symbols: list[Name] = []
    types: list[Name] = []
    columns: Annotated[list[Name], Field(min_length=2)] = ["x", "y"]
    frame: FrameEntry | None = None


class ObjectLine(_Strict):
    """One object of a scene."""

    id: Name
    symbol: Name
    center: Annotated[list[Coordinate], Field(min_length=2)]
    bbox: (
        Annotated[list[Coordinate], Field(min_length=4, max_length=4), AfterValidator(_box)] | None
    ) = None
    polygon: Corners | None = None
    polygons: Annotated[list[Corners], Field(min_length=1)] | None = None
    radius: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    heading_deg: Annotated[float, Field(allow_inf_nan=False)] | None = None
    height: (
        Annotated[list[Coordinate], Field(min_length=2, max_length=2), AfterValidator(_ascending)]
        | None
    ) = None

    def to_object(self) -> SceneObject:
        """The object; its footprint is the polygons, else the polygon, else the disc, else the
        box."""
        center = (self.center[0], self.center[1])
        box = (
            None if self.bbox is None else (self.bbox[0], self.bbox[1], self.bbox[2], self.bbox[3])
        )
        footprint: Footprint | None = None
        if self.polygons is not None and len(self.polygons) > 1:
            footprint = MultiPolygon(self.polygons)
        elif self.polygons is not None:
            footprint = Polygon(self.polygons[0])
        elif self.polygon is not None:
            footprint = Polygon(self.polygon)
        elif self.radius is not None:
            footprint = Disc(center, self.radius)
        elif box is not None:
            footprint = rectangle(*box)
        height = None if self.height is None else (self.height[0], self.height[1])
        return SceneObject(self.id, self.symbol, center, box, footprint, self.heading_deg, height)


def object_from_json(document: object) -> SceneObject:
    """One object as `SceneObject.to_json` writes it; InputError names the field."""
    return parse(ObjectLine, document).to_object()


class RelationLine(_Strict):
    """Two objects of a scene that belong together."""

    kind: Name
    between: Annotated[list[Name], Field(min_length=2, max_length=2)]


class SceneLine(_Strict):
    """One line of ``scenes/metadata.jsonl``. An empty list of objects means *not listed*, unless
    ``listed`` says that the table is empty."""

    file_name: Name | None = None
    scene_id: Name
    split: Name = "train"
    start: Annotated[list[Coordinate], Field(min_length=2)]
    goal: Annotated[list[Coordinate], Field(min_length=2)]
    objects: list[ObjectLine] | None = None
    listed: bool | None = None
    relations: list[RelationLine] | None = None
    metres_per_unit: Scale | None = None

    def to_scene(self, picture: Picture | None) -> Scene:
        """The scene, with a picture that the caller opened.

        Raises:
            InputError: ``render`` is no whole recipe; objects that are listed and said not to
                be; a relation of an object that is not in the list.
        """
        extra = dict(self.model_extra or {})
        recipe = SceneRecipe.from_json(extra.get("render"))
        if recipe is not None:
            del extra["render"]
        objects = tuple(o.to_object() for o in self.objects or ())
        if objects and self.listed is False:
            raise InputError("no objects, or listed true", "listed false", field="listed")
        listed = objects if objects or self.listed else None
        for relation in self.relations or ():
            for name in relation.between:
                if listed is not None and all(o.id != name for o in listed):
                    raise InputError("ids of objects of this scene", name,
                                     field="relations.between")  # fmt: skip
        return Scene(
            scene_id=self.scene_id,
            start=tuple(self.start),
            goal=tuple(self.goal),
            objects=listed,
            picture=picture,
            split=self.split,
            extra=tuple(extra.items()),
            recipe=recipe,
            relations=tuple(
                Relation(r.kind, (r.between[0], r.between[1])) for r in self.relations or ()
            ),
            metres_per_unit=self.metres_per_unit,
        )

    @staticmethod
    def of(scene: Scene, file_name: str | None) -> _Line:
        """The line that describes `scene`."""
        said: dict[str, Any] = {}
        if scene.objects == ():
            said["listed"] = True
        if scene.relations:
            said["relations"] = [r.to_json() for r in scene.relations]
        if scene.metres_per_unit is not None:
            said["metres_per_unit"] = scene.metres_per_unit
        return _Line(
            {
                "file_name": file_name,
                "scene_id": scene.scene_id,
                "split": scene.split,
                "start": list(scene.start),
                "goal": list(scene.goal),
                "objects": [o.to_json() for o in scene.objects or ()],
                **said,
                **({} if scene.recipe is None else {"render": scene.recipe.to_json()}),
                **dict(scene.extra),
            }
        )


class _Line:
    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document

    def line(self) -> str:
        """One line of JSON, with its line feed."""
        import json

        return json.dumps(self.document, ensure_ascii=False, allow_nan=False) + "\n"


def parse(
    model: type[M],
    document: object,
    *,
    file: str | os.PathLike[str] | None = None,
    row: int | str | None = None,
) -> M:
    """Validates a JSON document against a model.

    Raises:
        InputError: The first fault, with the field's path in the document.
    """
    try:
        return model.model_validate(document)
    except ValidationError as error:
        raise _faults(error, file, row)[0] from error


def faults(
    model: type[BaseModel],
    document: object,
    *,
    file: str | os.PathLike[str] | None = None,
    row: int | str | None = None,
) -> list[InputError]:
    """Every fault of a JSON document, where `parse` raises the first."""
    try:
        model.model_validate(document)
    except ValidationError as error:
        return _faults(error, file, row)
    return []


def _faults(
    error: ValidationError, file: str | os.PathLike[str] | None, row: int | str | None
) -> list[InputError]:
    found_faults = []
    for fault in error.errors(include_url=False):
        field = ".".join(str(part) for part in fault["loc"]) or None
        found = fault["input"] if fault["type"] != "missing" else "nothing"
        if isinstance(found, (dict, list)):
            found = f"{type(found).__name__} {to_short(found)}"
        message = str(fault["msg"]).removeprefix("Value error, ")
        expected = "a value" if fault["type"] == "missing" else _expected(message)
        found_faults.append(InputError(expected, found, file=file, row=row, field=field))
    return found_faults


def _expected(message: str) -> str:
    return message.replace("Input should be ", "").replace("must be ", "").strip()


def to_short(value: object) -> str:
    """The beginning of a JSON value, for a message."""
    try:
        return to_json(value)[:60]
    except (ValueError, TypeError, RecursionError):
        return repr(value)[:60]
