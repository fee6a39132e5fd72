"""The studio's functions as JSON end points, and the page that describes them."""

from __future__ import annotations

from typing import Any

# Loaded with the server only, whose extra brings it.
from fastapi import APIRouter, Query, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from markupsafe import Markup
from pydantic import BaseModel, ConfigDict, Field

from demospec.errors import DemospecError, InputError, OutputError
from demospec.report import joined
from demospec.studio.review._endpoints import review_router
from demospec.studio.server._elements import element
from demospec.studio.session._replay import demonstration_body, png_of, scene_body
from demospec.studio.session._upload import scene_from_picture
from demospec.studio.session._workspace import Workbench
from demospec.studio.table._endpoints import actor_of, table_router
from demospec.studio.teach._summary import how_many_more, question, understand

ACTOR = "api"


class NewDemonstration(BaseModel):
    """A path through a scene."""

    model_config = ConfigDict(extra="forbid")
    scene_id: str
    points: list[tuple[float, float]] = Field(description="At least two [x, y], pixels.")
    type: str | None = None
    demonstrator: str | None = None
    valid: bool | None = Field(None, description="Accepted, rejected, or not said.")
    t: list[float] | None = Field(None, description="Seconds, one a point.")


class Verdict(BaseModel):
    """Accepted (true), rejected (false) or not said (null)."""

    model_config = ConfigDict(extra="forbid")
    valid: bool | None


def register(workbench: Workbench) -> None:
    """Registers ``/api/…`` and the page ``/docs``."""
    from nicegui import app, ui

    from demospec.studio.server._frame import page_frame

    document = openapi(install(app, workbench))

    @ui.page("/docs", title="API · demospec")
    def docs() -> None:
        with page_frame("API", "docs"):
            element(docs_html(document)).classes("api-docs")


def install(app: Any, workbench: Workbench) -> Any:
    """Adds the end points to a FastAPI application; returns their router."""
    router = build_router(workbench)
    for more in (table_router, review_router):
        router.routes.extend(more(workbench).routes)
    app.include_router(router)

    async def refuse(_: Any, error: Exception) -> JSONResponse:
        return JSONResponse({"detail": str(error)}, status_code=422)

    async def refuse_fields(_: Any, error: RequestValidationError) -> JSONResponse:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        return JSONResponse({"detail": f"{place}: {first['msg']}"}, status_code=422)

    async def cannot_keep(_: Any, error: Exception) -> JSONResponse:
        return JSONResponse({"detail": str(error)}, status_code=507)

    app.add_exception_handler(DemospecError, refuse)
    app.add_exception_handler(RequestValidationError, refuse_fields)
    app.add_exception_handler(OutputError, cannot_keep)
    return router


def openapi(router: Any) -> dict[str, Any]:
    """The OpenAPI document of the end points."""
    from importlib.metadata import version

    from fastapi.openapi.utils import get_openapi

    return get_openapi(
        title="demospec studio", version=version("demospec"), routes=router.routes,
        description="The same functions as the pages; for programs on the same machine.",
    )  # fmt: skip


def build_router(bench: Workbench) -> Any:
    """All end points. Bad input is answered with 422 and one line."""
    router = APIRouter(prefix="/api", tags=["studio"])

    @router.get("/set", summary="Name, types, symbols and numbers of the set")
    def get_set() -> dict[str, Any]:
        return {
            "name": bench.name, "units": bench.units, "metres_per_unit": bench.metres_per_unit,
            "types": list(bench.types), "symbols": list(bench.symbols),
            "scenes": len(bench.scenes), "demonstrations": len(bench.demonstrations),
            "version": bench.version, "out": str(bench.out),
        }  # fmt: skip

    @router.get("/scenes", summary="Every scene: ends, size and objects")
    def get_scenes() -> dict[str, Any]:
        return {"scenes": [scene_body(s) for s in bench.scenes]}

    @router.get(
        "/scenes/{scene_id:path}/picture.png",
        summary="The scene's picture",
        response_class=Response,
    )
    def get_picture(scene_id: str) -> Response:
        png = png_of(bench.scene(scene_id))
        if png is None:
            return Response("no picture", status_code=404, media_type="text/plain")
        keep = {"Cache-Control": "private, max-age=3600", "X-Content-Type-Options": "nosniff"}
        return Response(png, media_type="image/png", headers=keep)

    @router.get("/scenes/{scene_id:path}", summary="One scene")
    def get_scene(scene_id: str) -> dict[str, Any]:
        return scene_body(bench.scene(scene_id))

    @router.post(
        "/scenes",
        summary="A new scene from a picture: the body is a PNG, JPEG or WebP file",
        status_code=201,
        openapi_extra={
            "requestBody": {"required": True, "content": {
                "application/octet-stream": {"schema": {"type": "string", "format": "binary"}}
            }}
        },
    )  # fmt: skip
    async def post_scene(
        request: Request, name: str = "picture",
        start_x: float | None = None, start_y: float | None = None,
        goal_x: float | None = None, goal_y: float | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        from starlette.concurrency import run_in_threadpool

        data = await request.body()  # the guard bounds its length

        def add() -> dict[str, Any]:
            taken = [s.scene_id for s in bench.scenes]
            start = None if start_x is None or start_y is None else (start_x, start_y)
            goal = None if goal_x is None or goal_y is None else (goal_x, goal_y)
            scene = scene_from_picture(data, name, taken, start=start, goal=goal)
            bench.add_scene(scene, actor=ACTOR)
            return scene_body(scene)

        return await run_in_threadpool(add)

    @router.get("/demonstrations", summary="Demonstrations, all or of a scene or type")
    def get_demonstrations(scene_id: str | None = None, type: str | None = None) -> dict[str, Any]:
        chosen = [
            d for d in bench.demonstrations
            if scene_id in (None, d.scene_id) and type in (None, d.type)
        ]  # fmt: skip
        return {"demonstrations": [demonstration_body(d) for d in chosen]}

    @router.post("/demonstrations", summary="Keep a new demonstration", status_code=201)
    def post_demonstration(new: NewDemonstration) -> dict[str, Any]:
        demo = bench.draw(**new.model_dump(), actor=ACTOR)
        return demonstration_body(demo)

    @router.delete("/demonstrations/{demo_id:path}", summary="Take a demonstration away")
    def delete_demonstration(demo_id: str) -> dict[str, Any]:
        bench.delete(demo_id, actor=ACTOR)
        return {"deleted": demo_id}

    @router.put("/demonstrations/{demo_id:path}/label", summary="Accept, reject, or take back")
    def put_label(demo_id: str, verdict: Verdict) -> dict[str, Any]:
        bench.label(demo_id, verdict.valid, actor=ACTOR)
        return demonstration_body(bench.standing.demonstrations[demo_id])

    @router.post("/undo", summary="Undo the last action made through the API, or of a tab")
    def post_undo(actor: str = "") -> dict[str, Any]:
        event = bench.undo(actor_of(actor))
        return {"undone": None if event is None else event.kind}

    @router.post("/redo", summary="Redo it")
    def post_redo(actor: str = "") -> dict[str, Any]:
        event = bench.redo(actor_of(actor))
        return {"redone": None if event is None else event.kind}

    @router.get("/understood", summary="What was understood of one type")
    def get_understood(type: str) -> dict[str, Any]:
        return understand(bench.data(), type).to_json()

    @router.get("/query", summary="The path whose label would tell most")
    def get_query(type: str, seed: int = Query(0, ge=0, lt=2**31)) -> dict[str, Any]:
        found = question(bench.data(), type, seed=seed)
        known = understand(bench.data(), type)
        return {**found.to_json(), "advice": how_many_more(found, known)}

    @router.get("/export/rules", summary="The rule file, as demospec rules SET --json writes it")
    def export_rules() -> dict[str, Any]:
        from demospec.rules import rules_document

        rules = bench.rules()
        if rules is None:
            raise InputError("at least one accepted or rejected path", "none", field="rules")
        return rules_document(rules)

    @router.post("/export/set", summary="Write the set to its folder now")
    def export_set() -> dict[str, Any]:
        return {"folder": str(bench.write().resolve())}

    @router.get("/export/set.zip", summary="The set as a zip file", response_class=Response)
    def export_zip() -> Response:
        folder = bench.write()
        named = {"Content-Disposition": 'attachment; filename="set.zip"'}
        return Response(zipped(folder), media_type="application/zip", headers=named)

    @router.get("/openapi.json", include_in_schema=False)
    def get_openapi_document() -> dict[str, Any]:
        return openapi(router)

    return router


def zipped(folder: Any) -> bytes:
    """A folder as a zip file in memory."""
    import io
    import zipfile

    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(p for p in folder.rglob("*") if p.is_file()):
            archive.write(file, f"{folder.name}/{file.relative_to(folder)}")
    return buffer.getvalue()


def docs_html(document: dict[str, Any]) -> Markup:
    """The OpenAPI document as a page of its own: nothing is fetched to show it."""
    lead = Markup(
        "<p class='lead'>{} The machine-readable document is "
        "<a href='/api/openapi.json'>openapi.json</a>.</p>"
    ).format(document["info"]["description"])
    return lead + joined(
        _entry(document, path, method, entry)
        for path, methods in document["paths"].items()
        for method, entry in methods.items()
    )


def _entry(document: dict[str, Any], path: str, method: str, entry: dict[str, Any]) -> Markup:
    wanted = joined(
        Markup("<li><code>{}</code> <span class='soft'>in the {}{}</span></li>").format(
            p["name"], p["in"], "" if p.get("required") else ", may be left out"
        )
        for p in entry.get("parameters", [])
    )
    body = joined(
        Markup("<li>body: <code>{}</code>{}</li>").format(kind, _fields(document, content))
        for kind, content in entry.get("requestBody", {}).get("content", {}).items()
    )
    return Markup(
        "<section class='card'><h2><span class='method {}'>{}</span> <code>{}</code></h2>"
        "<p>{}</p><ul>{}{}</ul></section>"
    ).format(method, method.upper(), path, entry["summary"], wanted, body)


def _fields(document: dict[str, Any], content: dict[str, Any]) -> Markup:
    name = content["schema"].get("$ref", "").rsplit("/", 1)[-1]
    schema = document.get("components", {}).get("schemas", {}).get(name)
    if not schema:
        return Markup()
    needed = schema.get("required", [])
    return Markup("<ul>{}</ul>").format(
        joined(
            Markup("<li><code>{}</code> <span class='soft'>{}{}</span></li>").format(
                key, value.get("description", ""), "" if key in needed else " May be left out."
            )
            for key, value in schema["properties"].items()
        )
    )
