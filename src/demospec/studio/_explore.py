"""The page Explore."""

from __future__ import annotations

from demospec.studio._workbench import Workbench


def register(workbench: Workbench) -> None:
    """Registers the page at ``/explore``."""
    from nicegui import ui

    from demospec.studio._frame import page_frame

    @ui.page("/explore", title="Explore · demospec")
    def page() -> None:
        with page_frame("Explore", "explore"):
            ui.label(f"{len(workbench.scenes)} scenes")
