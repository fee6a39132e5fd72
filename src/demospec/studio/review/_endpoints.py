"""What Check and Demonstrations ask and do, as JSON end points of the API."""

from __future__ import annotations

from typing import Any

# Loaded with the server only, whose extra brings it.
from fastapi import APIRouter, Request
from pydantic import BaseModel, ConfigDict, Field

from demospec.errors import InputError
from demospec.report import people_of
from demospec.studio.results._run import taught_run
from demospec.studio.review._audit import doubtful_labels
from demospec.studio.review._gallery import frame_of, frames, gallery, history, small
from demospec.studio.review._incoming import How, Incoming, described
from demospec.studio.session._later import SOON_S, Later
from demospec.studio.session._workspace import Workbench
from demospec.studio.table._endpoints import actor_of
from demospec.studio.table._steps import steps_of
from demospec.studio.teach._doubts import doubts_of


class Change(BaseModel):
    """The same change of many demonstrations."""

    model_config = ConfigDict(extra="forbid")
    demo_ids: list[str] = Field(min_length=1, max_length=100_000)
    valid: bool | None = None
    type: str | None = None
    demonstrator: str | None = None
    delete: bool = False


class Kept(BaseModel):
    """Demonstrations that are right, with what contradicts them."""

    model_config = ConfigDict(extra="forbid")
    demo_ids: list[str] = Field(min_length=1)


class Renamed(BaseModel):
    """All paths of one person become another's: a new name, or two people in one."""

    model_config = ConfigDict(extra="forbid")
    type: str
    name: str


class Dropped(BaseModel):
    """Recordings that were sent, and how they are read."""

    model_config = ConfigDict(extra="forbid")
    batch: str
    how: How = How()
    onto: str = Field("", description="Scene here that all paths go to; else theirs come too.")


class Merged(BaseModel):
    """Two scenes in one."""

    model_config = ConfigDict(extra="forbid")
    scene_id: str
    into: str


SHOWN = 12
"""Paths that are shown before recordings are taken in."""


def _cards(bench: Workbench) -> list[dict[str, Any]]:
    """Everybody as the report shows them."""
    run = taught_run(bench)
    return [
        {
            "name": p.name,
            "sentence": p.sentence,
            "picture": None if p.picture is None else str(p.picture.svg),
            "lights": [vars(light) for light in p.lights],
            "facts": [list(fact) for fact in p.facts],
        }
        for p in (() if run is None else people_of(run))
    ]


def review_router(bench: Workbench) -> APIRouter:
    """The end points."""
    router = APIRouter(prefix="/api", tags=["review"])
    doubts = doubts_of(bench)

    @router.get("/gallery", summary="Paths as small pictures, filtered, a page at a time")
    def get_gallery(
        type: str = "", verdict: str = "", scene_id: str = "", contradicting: bool = False,
        page: int = 0, wait: bool = True,
    ) -> dict[str, Any]:  # fmt: skip
        among, learning = None, False
        if contradicting:
            open_ = doubts.all() if wait else doubts.soon()
            learning = open_ is None
            among = {n for d in open_ or () for c in d.group for n in c.members}
        found = gallery(
            bench, type=type, verdict=verdict, scene_id=scene_id, among=among, page=page
        )
        return {**found, "learning": learning}

    @router.get("/check", summary="Contradictions, unsaid paths, labels that look wrong")
    def get_check(
        scene_id: str = "", type: str = "", audit: bool = False, wait: bool = True
    ) -> dict[str, Any]:
        known = doubts.all() if wait else doubts.soon()
        open_ = known or ()
        named = {n for d in open_ for c in d.group for n in c.members}
        wrong = doubtful_labels(bench) if audit else []
        standing = bench.standing.demonstrations
        unsaid = [d for d in bench.demonstrations if d.valid is None]
        named |= {w["demo_id"] for w in wrong} | {d.demo_id for d in unsaid[:200]}
        demos = [standing[n] for n in named if n in standing]
        here = scene_id if scene_id in bench.standing.scenes else bench.scenes[0].scene_id
        count = None if known is None else len(known)
        return {
            "doubts": [d.to_json() for d in open_],
            "unsaid": [d.demo_id for d in unsaid],
            "wrong": wrong,
            "audited": audit,
            "demonstrations": {d.demo_id: small(d) for d in demos},
            "scenes": frames(bench, dict.fromkeys(d.scene_id for d in demos)),
            "steps": [vars(s) for s in steps_of(bench, here, type or bench.types[0], count)],
            "learning": known is None,
            "version": bench.version,
        }

    cards = Later(lambda: bench.version, lambda: _cards(bench))

    @router.get("/people", summary="Everybody side by side: sentence, lights, picture, what next")
    def get_people(wait: bool = True) -> dict[str, Any]:
        known = cards.now(None if wait else SOON_S)
        return {"people": known or [], "learning": known is None}

    @router.get("/history", summary="Who did what")
    def get_history(actor: str = "") -> dict[str, Any]:
        return {"history": history(bench, actor_of(actor))}

    @router.post("/change", summary="Judge, give to somebody else, or delete many paths")
    def post_change(new: Change, actor: str = "") -> dict[str, Any]:
        who = actor_of(actor)
        if new.delete:
            bench.delete_many(new.demo_ids, actor=who)
        else:
            given = new.model_dump(include=new.model_fields_set - {"demo_ids", "delete"})
            bench.change(new.demo_ids, given, actor=who)
        return {"changed": len(new.demo_ids)}

    @router.post("/keep", summary="Say that both sides of a contradiction are right")
    def post_keep(new: Kept, actor: str = "") -> dict[str, Any]:
        bench.keep(new.demo_ids, actor=actor_of(actor))
        return {"kept": len(new.demo_ids)}

    @router.post("/person", summary="Rename a person, or make two people one")
    def post_person(new: Renamed, actor: str = "") -> dict[str, Any]:
        mine = [d.demo_id for d in bench.demonstrations if d.type == new.type]
        if not mine:
            raise InputError("a person with paths", new.type, field="type")
        if not new.name.strip():
            raise InputError("a name", new.name, field="name")
        bench.change(mine, {"type": new.name.strip()}, actor=actor_of(actor))
        return {"changed": len(mine)}

    @router.post("/scene-merge", summary="Give all paths of a scene to another one")
    def post_merge(new: Merged, actor: str = "") -> dict[str, Any]:
        bench.merge_scenes(new.scene_id, new.into, actor=actor_of(actor))
        return {"scenes": [s.scene_id for s in bench.scenes]}

    incoming = Incoming()

    @router.post("/import", summary="Begin to bring recordings", status_code=201)
    def post_import() -> dict[str, Any]:
        return {"batch": incoming.begin()}

    @router.post(
        "/import/file",
        summary="A piece of a file: the body; pieces come in order",
        openapi_extra={
            "requestBody": {"required": True, "content": {
                "application/octet-stream": {"schema": {"type": "string", "format": "binary"}}
            }}
        },
    )  # fmt: skip
    async def post_file(request: Request, batch: str, name: str, offset: int = 0) -> dict[str, Any]:
        from starlette.concurrency import run_in_threadpool

        data = await request.body()  # the guard bounds its length
        await run_in_threadpool(incoming.put, batch, name, data, offset)
        return {"bytes": offset + len(data)}

    @router.get("/import/progress", summary="How far reading is")
    def get_progress(batch: str) -> dict[str, Any]:
        what, share = incoming.batch(batch).progress
        return {"what": what, "share": share}

    @router.post("/import/look", summary="Read recordings and keep nothing")
    def post_look(new: Dropped) -> dict[str, Any]:
        found, source = incoming.read(new.batch, new.how, pictures=False)
        fitted, problem, said = found.data, "", list[str]()
        try:
            fitted, changes = bench.fitted(found.data, new.onto)
            said += changes
        except InputError as error:
            problem = str(error)
        first = list(fitted.demonstrations)[:SHOWN]
        shown = {d.scene_id for d in first}
        return {
            **described(found),
            "source": source,
            "changes": said,
            "problem": problem,
            "demonstrations": [small(d) for d in first],
            "scenes": {s.scene_id: frame_of(s) for s in fitted.scenes if s.scene_id in shown},
            "existing": [s.scene_id for s in bench.scenes],
        }

    @router.post("/import/take", summary="Take recordings into the set", status_code=201)
    def post_take(new: Dropped, actor: str = "") -> dict[str, Any]:
        found, source = incoming.read(new.batch, new.how, pictures=True)
        ids = bench.take_in(found.data, actor=actor_of(actor), source=source, onto=new.onto)
        return {"taken": len(ids)}

    return router
