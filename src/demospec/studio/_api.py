"""The page API."""

from __future__ import annotations

from demospec.studio._workbench import Workbench


def register(workbench: Workbench) -> None:
    """Registers the page at ``/docs``."""
    from nicegui import ui

    from demospec.studio._frame import page_frame

    @ui.page("/docs", title="API · demospec")
    def page() -> None:
        with page_frame("API", "docs"):
            ui.label(f"{len(workbench.scenes)} scenes")
