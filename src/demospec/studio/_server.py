"""Starts the studio on this machine only."""

from __future__ import annotations

from pathlib import Path

from demospec.demonstrations import read_set
from demospec.errors import MissingExtraError


def serve(
    set_folder: Path, *, host: str = "127.0.0.1", port: int = 8080, open_browser: bool = True
) -> None:
    """Serves the studio until interrupted.

    Raises:
        InputError: The set cannot be read.
        MissingExtraError: nicegui is absent.
    """
    data = read_set(set_folder)
    # Fonts, scripts and styles come from the installed package; nothing is fetched elsewhere.
    try:
        from nicegui import ui
    except ImportError as error:
        raise MissingExtraError("nicegui", "studio", "the studio") from error
    from demospec.studio._page import build_page

    build_page(data)
    ui.run(
        host=host, port=port, title="demospec studio", reload=False, show=open_browser,
        show_welcome_message=False,
    )  # fmt: skip
