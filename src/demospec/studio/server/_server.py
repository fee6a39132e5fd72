"""Starts the studio: one workbench, its pages, on this machine only unless told otherwise."""

from __future__ import annotations

import asyncio
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote

from demospec.errors import DemospecError, InputError, MissingExtraError
from demospec.studio.session._workspace import Workbench

LOOPBACK = ("127.0.0.1", "localhost", "::1")


def serve(
    set_folder: Path | None = None,
    model: Path | None = None,
    run: Path | None = None,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    token: str | None = None,
    out: Path | None = None,
    scenes_only: bool = False,
    show: bool = True,
    started: Callable[[str, Path], None] = lambda address, out: None,
) -> None:
    """Serves the studio until interrupted.

    Args:
        set_folder, model, run, out, scenes_only: See `Workbench`.
        host: Address to listen at. Any other than this machine's own needs a token.
        token: A secret that every request must bring, as ``?token=``, cookie or header.
        show: Open the page in a browser.
        started: Told the address, with the token, and the folder of the set that is written,
            once the studio answers there.

    Raises:
        InputError: The set cannot be read; a foreign host without a token; the port is taken.
        MissingExtraError: nicegui is absent.
    """
    if token == "":
        raise InputError("a secret that is not empty", "nothing", field="--token")
    if host not in LOOPBACK and not token:
        raise InputError("a token (--token) where others can reach the studio", "none", field=host)
    _must_be_free(host, port)
    # Fonts, scripts and styles come from the installed package; nothing is fetched elsewhere.
    try:
        from nicegui import app, background_tasks, ui
    except ImportError as error:
        raise MissingExtraError("nicegui", "studio", "the studio") from error
    from fastapi.responses import RedirectResponse

    from demospec.report import STYLES
    from demospec.studio.explore import _page as _explore
    from demospec.studio.results import _page as _results
    from demospec.studio.review import _page as _review
    from demospec.studio.server import _api
    from demospec.studio.server._frame import ADDRESS, REPORT_STYLES, STATIC
    from demospec.studio.server._guard import Guard
    from demospec.studio.server._policy import Policy
    from demospec.studio.table import _page as _table
    from demospec.studio.teach import _page as _teach

    workbench = Workbench(set_folder, model, run, out=out, scenes_only=scenes_only)
    # Asked for each time: a script of yesterday's version does not fit today's page.
    app.add_static_files(ADDRESS, STATIC, max_cache_age=0)
    app.add_static_files(REPORT_STYLES, STYLES, max_cache_age=0)
    app.get("/", include_in_schema=False)(lambda: RedirectResponse("/teach"))
    app.add_middleware(Policy)
    app.add_middleware(Guard, token=token)  # the last one added comes first
    for page in (_table, _teach, _review, _explore, _results, _api):
        page.register(workbench)
    keep_written(workbench)
    first = "/teach" if not token else f"/teach?token={quote(token, safe='')}"
    shown = f"[{host}]" if ":" in host else host

    async def announce() -> None:
        await _answering(host, port)
        started(f"http://{shown}:{port}{first}", workbench.out)

    app.on_startup(lambda: background_tasks.create(announce()))
    ui.run(
        host=host, port=port, title="demospec studio", reload=False, show=first if show else False,
        show_welcome_message=False, language="en-US",
        reconnect_timeout=30.0,  # a busy machine must not make a tab start anew
    )  # fmt: skip


def _must_be_free(host: str, port: int) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((host, port))
        except OSError as error:
            said = f"{host}:{port}: {error.strerror or error}"
            raise InputError("an address and port that are free", said, field="--port") from error


async def _answering(host: str, port: int) -> None:
    """Returns once somebody listens there: the server does so only after its start-up."""
    while True:
        try:
            _, writer = await asyncio.open_connection(host, port)
        except OSError:
            await asyncio.sleep(0.02)
        else:
            writer.close()
            return


def keep_written(workbench: Workbench) -> None:
    """Writes the set from the journal soon after the last change, and at the end."""
    from nicegui import app, run

    written = {"version": -1, "seen": -1}

    def write() -> None:
        version = workbench.version
        if workbench.demonstrations and version != written["version"]:
            try:
                workbench.write()
            except DemospecError as error:  # the journal has everything; say so and go on
                sys.stderr.write(f"{error}\n")
            written["version"] = version

    async def when_quiet() -> None:
        quiet, written["seen"] = written["seen"] == workbench.version, workbench.version
        if quiet:
            await run.io_bound(write)

    def finish() -> None:
        write()
        workbench.close()

    app.timer(2.0, when_quiet)
    app.on_shutdown(finish)
