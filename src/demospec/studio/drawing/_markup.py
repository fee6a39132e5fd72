"""HTML and SVG from templates: what is put into one is escaped, whoever it came from.

The pages hold no HTML in plain strings. A `Markup` is a literal template of this code, filled by
its own ``format``, which escapes; any other string is text. The linter (S704) refuses a `Markup`
made of anything but a literal.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from markupsafe import Markup, escape


def joined(parts: Iterable[str | Markup], between: str | Markup = "") -> Markup:
    """The parts one after another; those that are no `Markup` are escaped."""
    return escape(between).join(parts)


def element(content: str | Markup = "", tag: str = "div") -> Any:
    """A page element with this content; text that is no `Markup` is shown as it stands."""
    from nicegui import ui

    return ui.html(str(escape(content)), sanitize=False, tag=tag)


def fill(place: Any, content: str | Markup) -> None:
    """Puts other content into an element that `element` made."""
    place.set_content(str(escape(content)))
