"""Markup put together from parts that are escaped, whoever they came from.

A `Markup` is a literal template of this code, filled by its own ``format``, which escapes; any
other string is text. The linter (S704) refuses a `Markup` made of anything but a literal.
"""

from __future__ import annotations

from collections.abc import Iterable

from markupsafe import Markup, escape


def joined(parts: Iterable[str | Markup], between: str | Markup = "") -> Markup:
    """The parts one after another; those that are no `Markup` are escaped."""
    return escape(between).join(parts)
