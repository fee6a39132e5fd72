"""Generic words for objects: what one looks like where no set says what it is called."""

from __future__ import annotations

KINDS = ("flat", "hollow", "clear", "long", "tool", "block", "round")
