"""The page Explore: drag a path's control point or any object, and watch the verdict move."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from markupsafe import Markup

from demospec.demonstrations import ValidityModel
from demospec.errors import DemospecError, InputError
from demospec.rules import RuleSet
from demospec.studio.explore._answers import look, mend, put_down, scene_document, solutions
from demospec.studio.explore._state import Edits, Explorer, Question
from demospec.studio.server._elements import element
from demospec.studio.session._workspace import Workbench

TRUTH = "truth"
MOST_BYTES = 64_000
"""Longest request; the largest that the page makes has a few kB."""

_GREETING = Markup("""
<div id="explore" class="explore" data-ready="no">
  <p class="soft">Loading the scenes and the models…</p>
  <noscript>This page needs JavaScript; everything is served from this machine.</noscript>
</div>
""")


def register(workbench: Workbench) -> None:
    """Registers the page at ``/explore`` and what it asks, under ``/explore/api/``."""
    from nicegui import app, ui

    from demospec.studio.server._frame import page_frame

    @ui.page("/explore", title="Explore · demospec")
    def page() -> None:
        with page_frame("Explore", "explore", script="explore.js"):
            element(_GREETING)

    table = _Table(workbench)
    answers: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
        "open": table.open,
        "look": lambda asked: look(
            table.explorer, Question.from_json(asked),
            has=asked.get("has"), moving=asked.get("moving") is True,
        ),
        "repair": lambda asked: mend(table.explorer, Question.from_json(asked)),
        "sample": lambda asked: solutions(table.explorer, Question.from_json(asked)),
        "put": lambda asked: put_down(
            table.explorer, Question.from_json(asked), str(asked.get("symbol"))
        ),
    }  # fmt: skip
    for name, answer in answers.items():
        app.add_route(f"/explore/api/{name}", _endpoint(answer), methods=["POST"])


class _Table:
    """The explorer of the workbench as it stands; made anew when somebody taught something."""

    def __init__(self, workbench: Workbench) -> None:
        self._workbench = workbench
        self._made: tuple[int, Explorer] | None = None

    @property
    def explorer(self) -> Explorer:
        version = self._workbench.version
        if self._made is None or self._made[0] != version:
            self._made = (version, _explorer_of(self._workbench))
        return self._made[1]

    def open(self, asked: dict[str, Any]) -> dict[str, Any]:
        """What a tab needs to begin: scenes, models with their types, symbols, a first path."""
        explorer = self.explorer
        if not explorer.scenes:
            raise InputError("a set with scenes", "none", field="set")
        scene = str(asked.get("scene") or next(iter(explorer.scenes)))
        with explorer.lock:
            models: list[dict[str, Any]] = [
                {"name": n, "types": list(m.types), "rule": isinstance(m, RuleSet)}
                for n, m in explorer.models.items()
            ]
            types = models[0]["types"] if models else []
            kind = str(asked.get("type") or (types[0] if types else ""))
            shown = explorer.scene(scene, Edits())
            control = explorer.first_control(scene, kind)
            symbols = [
                {"name": s, "fits": explorer.fits(scene, s)}
                for s in self._workbench.symbols
                if explorer.editor.templates(s, shown)
            ]
            return {
                "scenes": list(explorer.scenes),
                "models": models,
                "symbols": symbols,
                "control": list(control),
                "scene": scene_document(shown, Edits()),
                "units": explorer.units,
                "metres_per_unit": explorer.scale_of(scene),
            }


def _explorer_of(workbench: Workbench) -> Explorer:
    # A fitted model is shown pictures only: what it knows of objects it has to see.
    pictures = all(scene.picture is not None for scene in workbench.scenes)

    def at(name: str, scene_id: str) -> ValidityModel:
        from demospec.experiments import PicturesOnly

        model = workbench.model_at(name, scene_id)
        return PicturesOnly(model) if pictures and not isinstance(model, RuleSet) else model

    scales = {workbench.scale_of(s.scene_id) for s in workbench.scenes}
    return Explorer(
        workbench.scenes,
        workbench.models(),
        workbench.demonstrations,
        truth=TRUTH,
        units=workbench.units,
        metres_per_unit=next(iter(scales)) if len(scales) == 1 else None,
        scale_of=workbench.scale_of,
        at=at,
    )


def _endpoint(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[..., Any]:
    """A route that takes a JSON object and gives one; what is refused comes as ``error``."""
    from starlette.concurrency import run_in_threadpool
    from starlette.requests import Request
    from starlette.responses import JSONResponse

    async def endpoint(request: Request) -> JSONResponse:
        # Browsers send JSON to another origin only after asking, and nobody here says yes.
        if not request.headers.get("content-type", "").startswith("application/json"):
            return JSONResponse({"error": "expected application/json"}, status_code=415)
        body = bytearray()
        async for part in request.stream():
            body += part
            if len(body) > MOST_BYTES:
                return JSONResponse({"error": "the request is too long"}, status_code=413)
        try:
            asked = json.loads(bytes(body) or b"{}")
            if not isinstance(asked, dict):
                raise InputError("a JSON object", type(asked).__name__)
            return JSONResponse(await run_in_threadpool(answer, asked))
        except (DemospecError, ValueError, RecursionError) as error:
            return JSONResponse({"error": str(error)}, status_code=400)

    return endpoint
