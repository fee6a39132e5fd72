"""The page Results: what a run found, and everything that can be taken away."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from markupsafe import Markup

from demospec.demonstrations import read_set
from demospec.errors import DemospecError, InputError
from demospec.scene import Scene
from demospec.studio.drawing._markup import element
from demospec.studio.results import _view as view
from demospec.studio.results._curves import curve_files, curves
from demospec.studio.results._export import FORMS, PLANNED, choices, export
from demospec.studio.results._plans import plans, videos
from demospec.studio.session._workspace import Workbench


def register(workbench: Workbench) -> None:
    """Registers the page at ``/results``, its downloads and its videos."""
    from nicegui import app, run, ui
    from starlette.concurrency import run_in_threadpool
    from starlette.requests import Request
    from starlette.responses import FileResponse, PlainTextResponse, Response

    from demospec.studio.server._frame import ADDRESS, page_frame

    @ui.page("/results", title="Results · demospec", response_timeout=60)
    async def page() -> None:
        ui.add_head_html(f'<link rel="stylesheet" href="{ADDRESS}/results.css">')
        with page_frame("Results", "results"):
            found = await run.io_bound(results_html, workbench) or ""
            element(Markup(found))  # noqa: S704  (escaped part by part)

    async def download(request: Request) -> Response:
        asked = request.query_params
        chosen = {key: asked.get(key, "") for key in ("rules", "scene", "type")}
        form = str(asked.get("form", ""))
        try:
            name, media, content = await run_in_threadpool(
                lambda: export(workbench, form, **chosen)
            )
        except DemospecError as error:
            return PlainTextResponse(f"Nothing to download: {error}\n", status_code=400)
        said = {"content-disposition": f'attachment; filename="{name}"'}
        return Response(content, media_type=media, headers=said)

    async def media(request: Request) -> Response:
        # Videos are asked for by number, so that no path ever comes from outside.
        files = view.videos_of(workbench.run_folder)
        number = int(request.path_params["number"])
        if not 0 <= number < len(files):
            return PlainTextResponse("no such video\n", status_code=404)
        return FileResponse(files[number])

    app.add_route("/results/download", download, methods=["GET"])
    app.add_route("/results/media/{number:int}", media, methods=["GET"])


def results_html(workbench: Workbench) -> str:
    """The page's content; what is absent is said, with the command that makes it."""
    folder = workbench.run_folder
    return f'<div class="results">{_head(folder)}{_take_away(workbench)}{_found(folder)}</div>'


def _head(folder: Path | None) -> str:
    if folder is None:
        return (
            '<section class="card"><h2>No run is shown</h2><p>A run takes a set the whole way: '
            "rules, causes, accuracy, plans. <code>demospec demo --out runs/demo</code> makes "
            "one; <code>demospec studio --run runs/demo</code> shows it here.</p></section>"
        )
    try:
        record = view.read_document(folder, "run") or {}
    except InputError as error:
        return f'<section class="card"><p class="re-wrong">{escape(str(error))}</p></section>'
    seconds = sum(float(s.get("seconds", 0)) for s in record.get("stages", {}).values())
    versions = record.get("versions", {})
    facts = [
        f"seed {record.get('seed', '?')}",
        f"{seconds:.0f} s of computing" if seconds else "",
        f"demospec {versions['demospec']}" if "demospec" in versions else "",
    ]
    return (
        f'<div class="re-head"><p class="re-run">{escape(folder.name)}</p><p class="soft">'
        f"{escape(' · '.join(f for f in facts if f))}</p></div>"
    )


def _found(folder: Path | None) -> str:
    if folder is None:
        return ""
    again = "demospec demo --out RUN"
    scenes = _scenes(folder)
    parts = [
        view.section(folder, "rules", "What they care about", view.rules, again),
        view.section(folder, "causes", "What changes their verdict", view.causes, again),
        view.section(folder, "accuracy", "How well the models judge", view.accuracy, again),
        *(
            view.section(
                folder, name, f"Accuracy with more demonstrations ({name.partition('-')[2]} draws)",
                lambda d: curves(d) + view.curve_table(d), again,
            )
            for name in curve_files(folder)
        ),
        view.section(folder, "plans", "Plans in new scenes", lambda d: plans(d, scenes), again),
        view.section(folder, "repairs", "Repaired paths", view.repairs, again),
        view.section(
            folder, "audit", "Demonstrations that look wrong", view.audit,
            "demospec audit SET --json > RUN/audit.json",
        ),
        f'<section class="card" id="video"><h2>Execution</h2>'
        f"{videos(view.videos_of(folder))}</section>",
    ]  # fmt: skip
    return "".join(parts)


def _scenes(folder: Path) -> dict[str, Scene]:
    try:
        return {s.scene_id: s for s in read_set(folder / "set").scenes}
    except DemospecError:  # a run without its set: the plans are counted, not drawn
        return {}


def _take_away(workbench: Workbench) -> str:
    """The export form: plain HTML, so that it works before any script does."""
    offered = choices(workbench)

    def select(name: str, words: str, values: list[Any]) -> str:
        options = "".join(f"<option>{escape(str(v))}</option>" for v in values)
        return f'<label>{words}<select class="plain-input" name="{name}">{options}</select></label>'

    def button(form: str) -> str:
        return f'<button class="plain-button" name="form" value="{form}">{FORMS[form]}</button>'

    whole = "".join(button(f) for f in FORMS if f not in PLANNED)
    planned = "".join(button(f) for f in PLANNED)
    return (
        '<section class="card re-take" id="take"><h2>Take it away</h2>'
        '<form action="/results/download" method="get">'
        f'<div class="re-row">{select("rules", "Rules", offered["rules"])}'
        f'<div class="re-buttons">{whole}</div></div>'
        f'<div class="re-row">{select("scene", "Planned in scene", offered["scenes"])}'
        f"{select('type', 'for', offered['types'])}"
        f'<div class="re-buttons">{planned}</div></div></form></section>'
    )
