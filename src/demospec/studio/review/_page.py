"""The pages Check and Demonstrations; their end points are those of the API."""

from __future__ import annotations

from markupsafe import Markup

from demospec.studio.server._elements import element
from demospec.studio.session._workspace import Workbench

_GREETING = Markup("""
<div id="{}" class="review">
  <p class="soft">Looking at what was taught…</p>
  <noscript>This page needs JavaScript; everything is served from this machine.</noscript>
</div>
""")


def register(workbench: Workbench) -> None:
    """Registers ``/check`` and ``/demonstrations``."""
    from nicegui import ui

    from demospec.studio.server._frame import REPORT_STYLES, page_frame

    @ui.page("/check", title="Check · demospec")
    def check() -> None:
        ui.add_head_html(f'<link rel="stylesheet" href="{REPORT_STYLES}/report.css">')
        with page_frame("Check", "check", script="check.js"):
            element(_GREETING.format("check"))

    @ui.page("/demonstrations", title="Demonstrations · demospec")
    def demonstrations() -> None:
        with page_frame("Demonstrations", "demonstrations", script="demonstrations.js"):
            element(_GREETING.format("demonstrations"))
