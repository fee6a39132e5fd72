"""The page Teach."""

from __future__ import annotations

from demospec.studio._workbench import Workbench


def register(workbench: Workbench) -> None:
    """Registers the page at ``/teach``."""
    from nicegui import ui

    from demospec.studio._frame import page_frame

    @ui.page("/teach", title="Teach · demospec")
    def page() -> None:
        with page_frame("Teach", "teach"):
            ui.label(f"{len(workbench.scenes)} scenes")
