"""Page elements with markup in them; text that is no `Markup` is shown as it stands."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup, escape


def element(content: str | Markup = "", tag: str = "div") -> Any:
    """A page element with this content."""
    from nicegui import ui

    return ui.html(str(escape(content)), sanitize=False, tag=tag)


def fill(place: Any, content: str | Markup) -> None:
    """Puts other content into an element that `element` made."""
    place.set_content(str(escape(content)))
