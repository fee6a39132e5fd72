"""The page Table: picture, ruler, start and goal, objects with their names."""

from __future__ import annotations

from markupsafe import Markup

from demospec.studio.server._elements import element
from demospec.studio.session._workspace import Workbench

_GREETING = Markup("""
<div id="table" class="table-page">
  <p class="soft">Loading the table…</p>
  <noscript>This page needs JavaScript; everything is served from this machine.</noscript>
</div>
""")


def register(workbench: Workbench) -> None:
    """Registers the page at ``/table``; its end points are those of the API."""
    from nicegui import ui

    from demospec.studio.server._frame import page_frame

    @ui.page("/table", title="Table · demospec")
    def page() -> None:
        with page_frame("Table", "table", script="table.js"):
            element(_GREETING)
