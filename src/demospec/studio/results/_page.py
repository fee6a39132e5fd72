"""The page Results: the report itself, and everything that can be downloaded."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from markupsafe import Markup

from demospec.errors import DemospecError
from demospec.report import joined
from demospec.studio.results._export import (
    FORMS,
    PLANNED,
    Choices,
    choices,
    export,
    report_of,
    subjects,
)
from demospec.studio.server._elements import element
from demospec.studio.session._later import SOON_S, Later
from demospec.studio.session._workspace import Workbench

VIDEOS = (".gif", ".mp4")


def register(workbench: Workbench) -> None:
    """Registers the page at ``/results``, the report's parts, its downloads and its videos."""
    from nicegui import app, ui
    from starlette.concurrency import run_in_threadpool
    from starlette.requests import Request
    from starlette.responses import (
        FileResponse,
        HTMLResponse,
        JSONResponse,
        PlainTextResponse,
        Response,
    )

    from demospec.studio.server._frame import REPORT_STYLES, page_frame

    parts = Parts(workbench)
    offered = Later(lambda: workbench.version, lambda: choices(workbench))

    @ui.page("/results", title="Results · demospec")
    def page(of: str = "") -> None:
        ui.add_head_html(f'<link rel="stylesheet" href="{REPORT_STYLES}/report.css">')
        with page_frame("Results", "results", script="results.js"):
            element(page_markup(workbench, of, learning=offered.now(SOON_S) is None))

    async def choose(request: Request) -> Response:
        return JSONResponse(
            asdict(await run_in_threadpool(lambda: offered.now() or choices(workbench)))
        )

    async def download(request: Request) -> Response:
        asked = request.query_params
        chosen = {key: asked.get(key, "") for key in ("rules", "scene", "type", "of")}
        form = str(asked.get("form", ""))
        try:
            name, media, content = await run_in_threadpool(
                lambda: export(workbench, form, **chosen)
            )
        except DemospecError as error:
            return PlainTextResponse(str(error), status_code=400)
        said = {"content-disposition": f'attachment; filename="{name}"'}
        return Response(content, media_type=media, headers=said)

    async def report(request: Request) -> Response:
        of = request.query_params.get("of", "")
        try:
            return HTMLResponse(await run_in_threadpool(parts.of, of))
        except DemospecError as error:
            return PlainTextResponse(str(error), status_code=400)

    async def media(request: Request) -> Response:
        # Videos are asked for by number, so that no path ever comes from outside.
        files = videos_of(workbench.run_folder)
        number = int(request.path_params["number"])
        if not 0 <= number < len(files):
            return PlainTextResponse("no such video\n", status_code=404)
        return FileResponse(files[number])

    app.add_route("/results/choices", choose, methods=["GET"])
    app.add_route("/results/download", download, methods=["GET"])
    app.add_route("/results/report", report, methods=["GET"])
    app.add_route("/results/media/{number:int}", media, methods=["GET"])


class Parts:
    """The report's parts as markup, written once for each state of the table."""

    def __init__(self, workbench: Workbench) -> None:
        self._workbench = workbench
        self._lock = threading.Lock()
        self._known: dict[str, tuple[int, Markup]] = {}

    def of(self, subject: str) -> Markup:
        """The parts of the report on a subject (`subjects`); InputError where there is none."""
        from demospec.report import render_parts

        with self._lock:
            version = self._workbench.version
            if self._known.get(subject, (-1,))[0] != version:
                made = render_parts(report_of(self._workbench, subject))
                self._known[subject] = (version, made)
            return self._known[subject][1]


def page_markup(workbench: Workbench, of: str = "", *, learning: bool = False) -> Markup:
    """What can be downloaded, the place of the report, videos.

    Args:
        of: One of `subjects`.
        learning: Rules are being learned: what needs them is said to come.
    """
    known = subjects(workbench)
    of = of if of in known else next(iter(known), "")
    return Markup('<div class="results">{}{}{}</div>').format(
        _downloads(choices(workbench, learned=not learning), of, learning),
        _place(known, of),
        _videos(workbench.run_folder),
    )


def _place(known: Mapping[str, str], of: str) -> Markup:
    if not known:
        return Markup(
            '<section class="card"><h2>Nothing to report yet</h2><p>Draw a path under '
            '<a href="/teach">Teach</a> and accept or reject it: the report is about what was '
            "taught. Or start the studio with a run, as <code>demospec demo --out RUN</code> makes "
            "one: <code>demospec studio --run RUN</code>.</p></section>"
        )
    links = joined(
        Markup('<a class="plain-button small" href="/results?of={}"{}>{}</a>').format(
            key, Markup(' aria-current="true"') if key == of else "", words
        )
        for key, words in known.items()
    )
    chosen = Markup('<p class="re-of">Report on {}</p>').format(links)
    return Markup(
        '{}<div id="report" data-of="{}" aria-live="polite" aria-busy="true">'
        '<p class="soft">Writing the report…</p></div>'
    ).format(chosen, of)


def _downloads(offered: Choices, of: str, learning: bool) -> Markup:
    def select(name: str, words: str, values: tuple[str, ...]) -> Markup:
        options = joined(Markup("<option>{}</option>").format(v) for v in values)
        return Markup('<label>{}<select class="plain-input" name="{}">{}</select></label>').format(
            words, name, options
        )

    def button(form: str) -> Markup:
        return Markup(
            '<button type="button" class="plain-button" data-form="{}">{}</button>'
        ).format(form, FORMS[form])

    types = tuple(dict.fromkeys(t for each in offered.rules.values() for t in each))
    whole = joined(button(form) for form in FORMS if form not in PLANNED)
    planned = joined(button(form) for form in PLANNED)
    return Markup(
        '<section class="card re-take" id="take" data-choices="{}" data-of="{}"{}>'
        '<h2>Download</h2><div class="re-row">{}<div class="re-buttons">{}</div></div>'
        '<div class="re-row">{}{}<div class="re-buttons">{}</div></div>'
        '<p class="re-why soft" id="take-why"></p><p class="re-said" role="status"></p></section>'
    ).format(
        json.dumps(asdict(offered)), of, Markup(" data-learning") if learning else "",
        select("rules", "Rules", tuple(offered.rules)), whole,
        select("scene", "A plan for the robot, in scene", offered.scenes),
        select("type", "for", types), planned,
    )  # fmt: skip


def videos_of(run: Path | None) -> list[Path]:
    """Videos of executions, anywhere in the run folder; in the order of their names."""
    if run is None:
        return []
    return sorted(p for p in run.rglob("*") if p.suffix.lower() in VIDEOS and p.is_file())


def _videos(run: Path | None) -> Markup:
    """Players for GIF and MP4 files, addressed by their number."""
    if run is None:
        return Markup()
    figures = []
    for i, file in enumerate(videos_of(run)):
        player = (
            Markup('<img src="/results/media/{}" alt="Video of the execution {}">')
            if file.suffix.lower() == ".gif"
            else Markup(
                '<video src="/results/media/{}" controls muted loop aria-label="{}"></video>'
            )
        ).format(i, file.name)
        figures.append(
            Markup("<figure>{}<figcaption>{}</figcaption></figure>").format(player, file.name)
        )
    none = Markup(
        '<p class="soft">This run has no video. <code>demospec execute RULES SET --scene ID '
        "--out RUN/execution</code> makes one.</p>"
    )
    shown = Markup('<div class="re-videos">{}</div>').format(joined(figures)) if figures else none
    return Markup('<section class="card" id="video"><h2>Execution</h2>{}</section>').format(shown)
