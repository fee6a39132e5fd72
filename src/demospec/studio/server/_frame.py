"""The frame around every page: navigation, theme, style. Everything is served from here."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from markupsafe import Markup

from demospec.studio.server._elements import element

STATIC = Path(__file__).parents[1] / "static"
ADDRESS = "/studio-static"
REPORT_STYLES = "/report-static"
"""Style sheets of the report: scenes look the same here and there."""

PAGES = (
    ("table", "Table", "/table"),
    ("teach", "Teach", "/teach"),
    ("check", "Check", "/check"),
    ("demonstrations", "Demonstrations", "/demonstrations"),
    ("explore", "Explore", "/explore"),
    ("results", "Results", "/results"),
    ("docs", "API", "/docs"),
)


WAY = ("table", "teach", "check", "results")
"""Pages that show the steps of the way."""


@contextmanager
def page_frame(title: str, active: str, *, script: str | None = None) -> Iterator[Any]:
    """Header with navigation, and an element to build the page in (nicegui's is the ``main``).

    Light or dark as the system has it. Call it inside a function under ``ui.page``.

    Args:
        title: Heading of the page, for screen readers.
        active: Key of `PAGES` that is shown as chosen.
        script: A JavaScript file of ``static/`` (a module), and of the same name a ``.css``. It
            calls ``prepared`` of ``connection.js`` when it listens.

    The element is inert until the tab has reached the studio and the script listens, and while
    the connection is lost; ``body`` then has ``data-ready=yes``.
    """
    from nicegui import ui

    styles = f'<link rel="stylesheet" href="{REPORT_STYLES}/scene.css">'
    styles += f'<link rel="stylesheet" href="{ADDRESS}/studio.css">'
    ui.add_head_html(styles + '<meta name="color-scheme" content="light dark">')
    scripts = ["connection.js"]
    if script is not None:
        scripts.append(script)
        if (STATIC / script).with_suffix(".css").is_file():
            name = Path(script).with_suffix(".css").name
            ui.add_head_html(f'<link rel="stylesheet" href="{ADDRESS}/{name}">')
    for name in scripts:
        ui.add_body_html(f'<script type="module" src="{ADDRESS}/{name}"></script>')
    ui.dark_mode(None)
    ui.query(".nicegui-content").classes("studio-content")
    with ui.element("header").classes("studio-header"):
        element(Markup('<a class="brand" href="/teach">demospec <span>studio</span></a>'))
        with ui.element("nav").props('aria-label="Pages"'):
            for key, words, path in PAGES:
                here = Markup(' aria-current="page"') if key == active else ""
                element(Markup('<a href="{}"{}>{}</a>').format(path, here, words))
    if active in WAY:
        with ui.element("div").classes("steps-bar"):
            element(tag="ol").props(f'id=steps data-active={active} aria-label="The way"')
            element(tag="p").props("id=steps-missing")
    with ui.element("div").classes(f"studio-main page-{active}") as main:
        element(title, "h1").classes("out-of-sight")
        main.props("inert" if script is None else "inert data-prepares")
        yield main
