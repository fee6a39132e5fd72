"""The page Results."""

from __future__ import annotations

from demospec.studio._workbench import Workbench


def register(workbench: Workbench) -> None:
    """Registers the page at ``/results``."""
    from nicegui import ui

    from demospec.studio._frame import page_frame

    @ui.page("/results", title="Results · demospec")
    def page() -> None:
        with page_frame("Results", "results"):
            ui.label(f"{len(workbench.scenes)} scenes")
