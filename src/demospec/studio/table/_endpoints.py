"""What the Table page asks and does, as JSON end points of the API."""

from __future__ import annotations

import re
from typing import Any

# Loaded with the server only, whose extra brings it.
from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from demospec.errors import InputError
from demospec.frames import describe_length, ruler
from demospec.studio.session._replay import UNNAMED, scene_body
from demospec.studio.session._workspace import Workbench
from demospec.studio.table._found import find_in
from demospec.studio.table._marker import can_find, scale_by_marker
from demospec.studio.table._steps import missing_on_table, steps_of
from demospec.studio.teach._doubts import doubts_of

ACTOR = "api"
Point = tuple[float, float]


class _Body(BaseModel):
    model_config = ConfigDict(extra="forbid")
    scene_id: str


class Ends(_Body):
    """Where motions start and arrive, pixels."""

    start: Point
    goal: Point


class Scale(_Body):
    """How large the picture is on the table: one of three ways; none takes it back."""

    between: tuple[Point, Point] | None = Field(None, description="Two places of the picture.")
    length_cm: float | None = Field(None, gt=0, description="What lies between them.")
    width_cm: float | None = Field(None, gt=0, description="The whole picture's width.")


class Marker(_Body):
    """Printed AprilTags on the table."""

    size_cm: float = Field(gt=0, description="Side of the black square.")


class NewObject(_Body):
    """A loop about an object, and what it is."""

    symbol: str
    points: list[Point]


class ChangedObject(_Body):
    """Another name, outline (its corners) or direction of a marked object."""

    id: str
    symbol: str | None = None
    outline: list[Point] | None = None
    heading_deg: float | None = Field(None, allow_inf_nan=False)


class NewName(_Body):
    """Another name of a scene."""

    name: str


def actor_of(actor: str) -> str:
    """Who acts: a tab that says so, else the API."""
    return actor if re.fullmatch(r"tab-[a-z0-9]{1,32}", actor) else ACTOR


def table_document(bench: Workbench, scene_id: str, type: str = "") -> dict[str, Any]:
    """Everything that the page shows of one scene."""
    scene = bench.scene(scene_id)
    names = [s.scene_id for s in bench.scenes]
    scale = bench.scale_of(scene_id)
    wide = None if scale is None or scene.size_px is None else scene.size_px[0] * scale
    objects = [
        {
            "id": o.id,
            "symbol": o.symbol,
            "named": not o.symbol.startswith(UNNAMED),
            "heading_deg": o.heading_deg,
            "outline": corners(o.outline),
        }
        for o in scene.objects or ()
    ]
    return {
        **scene_body(scene),
        "objects": objects,
        "listed": scene.objects is not None,
        "may_mark": bench.may_mark(scene_id),
        "may_measure": scene.picture is not None,
        "scale": scale,
        "wide": None if wide is None else describe_length(wide, 1.0, "m"),
        "wide_cm": None if wide is None else round(100 * wide, 2),
        "picture": scene.picture is not None,
        "paths": sum(d.scene_id == scene_id for d in bench.demonstrations),
        "scenes": names,
        "symbols": [s for s in bench.symbols if not s.startswith(UNNAMED)],
        "markers": can_find(),
        "missing": missing_on_table(bench, scene_id),
        "steps": _steps(bench, scene_id, type),
        "version": bench.version,
    }


def _steps(bench: Workbench, scene_id: str, type: str) -> list[dict[str, Any]]:
    open_ = doubts_of(bench).soon()
    count = None if open_ is None else len(open_)
    return [vars(s) for s in steps_of(bench, scene_id, type or bench.types[0], count)]


def corners(shape: Any) -> list[list[float]]:
    """Corners to draw and to drag; of a round thing 24 of them."""
    from demospec.geometry import rims

    rim = max(rims(shape), key=len)
    step = max(1, len(rim) // 48)
    return [[round(float(x), 2), round(float(y), 2)] for x, y in rim[::step]]


def table_router(bench: Workbench) -> APIRouter:
    """The end points. Each answers with the table as it stands afterwards."""
    router = APIRouter(prefix="/api", tags=["table"])

    @router.get("/table", summary="One scene with all that the Table page shows")
    def get_table(scene_id: str = "", type: str = "") -> dict[str, Any]:
        return table_document(bench, scene_id or bench.scenes[0].scene_id, type)

    @router.get("/steps", summary="What is done and what is missing on the way")
    def get_steps(scene_id: str = "", type: str = "") -> dict[str, Any]:
        scene = scene_id or bench.scenes[0].scene_id
        return {"steps": _steps(bench, scene, type)}

    @router.put("/ends", summary="Put start and goal elsewhere")
    def put_ends(new: Ends, actor: str = "") -> dict[str, Any]:
        bench.move_ends(new.scene_id, new.start, new.goal, actor=actor_of(actor))
        return table_document(bench, new.scene_id)

    @router.put("/scale", summary="Say how large a picture is on the table")
    def put_scale(new: Scale, actor: str = "") -> dict[str, Any]:
        size = bench.scene(new.scene_id).size_px
        scale = None
        if new.between is not None and new.length_cm is not None:
            scale = ruler(*new.between, new.length_cm / 100)
        elif new.width_cm is not None and size is not None:
            scale = new.width_cm / 100 / size[0]
        elif new.between is not None or new.length_cm is not None:
            raise InputError("two places and the length between them", "one", field="scale")
        bench.measure(new.scene_id, scale, actor=actor_of(actor))
        return table_document(bench, new.scene_id)

    @router.post("/marker", summary="Measure a picture by printed AprilTags")
    def post_marker(new: Marker, actor: str = "") -> dict[str, Any]:
        scale = scale_by_marker(bench.scene(new.scene_id), new.size_cm / 100)
        bench.measure(new.scene_id, scale, actor=actor_of(actor))
        return table_document(bench, new.scene_id)

    @router.post("/objects", summary="Mark an object", status_code=201)
    def post_object(new: NewObject, actor: str = "") -> dict[str, Any]:
        bench.mark(new.scene_id, [(new.symbol, new.points)], actor=actor_of(actor))
        return table_document(bench, new.scene_id)

    @router.post("/objects/found", summary="Mark what is seen in the picture", status_code=201)
    def post_found(scene_id: str, actor: str = "") -> dict[str, Any]:
        bench.mark(scene_id, find_in(bench.scene(scene_id)), actor=actor_of(actor))
        return table_document(bench, scene_id)

    @router.put("/objects", summary="Name, outline or turn a marked object")
    def put_object(new: ChangedObject, actor: str = "") -> dict[str, Any]:
        bench.change_object(
            new.scene_id, new.id, actor=actor_of(actor), symbol=new.symbol, outline=new.outline,
            heading_deg=new.heading_deg,
        )  # fmt: skip
        return table_document(bench, new.scene_id)

    @router.delete("/objects", summary="Take a marked object off the list")
    def delete_object(scene_id: str, id: str, actor: str = "") -> dict[str, Any]:
        bench.unmark(scene_id, id, actor=actor_of(actor))
        return table_document(bench, scene_id)

    @router.put("/scene-name", summary="Give a scene another name")
    def put_name(new: NewName, actor: str = "") -> dict[str, Any]:
        bench.rename_scene(new.scene_id, new.name, actor=actor_of(actor))
        return table_document(bench, new.name)

    @router.delete("/scene", summary="Take a scene away with its paths")
    def delete_scene(scene_id: str, actor: str = "") -> dict[str, Any]:
        bench.drop_scene(scene_id, actor=actor_of(actor))
        return table_document(bench, bench.scenes[0].scene_id)

    return router
