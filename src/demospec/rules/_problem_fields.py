"""Top-level fields of a problem file that nothing reads: named, never passed over in silence.

Documents of other programs may hold more than ours (a name, a date): such a field is named in
a note. A field that is misspelt, or that belongs to a scene, an object or a trajectory, would
have changed the answer: it is an error.
"""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from demospec.errors import InputError

_BOTH = ("family", "distance", "scenes", "trajectories", "units", "metres_per_unit")
_INFLUENCE = (
    "F_max", "scale", "reading", "penalty", "weights", "thresholds", "bounds", "preset",
)  # fmt: skip
KNOWN: Mapping[str, tuple[str, ...]] = {
    "influence": (*_BOTH, *_INFLUENCE),
    "clearance": (*_BOTH, "sharing"),
}
"""Family → fields that are read."""

_INSIDE = {
    "feature": "an object", "center": "an object", "class": "an object", "symbol": "an object",
    "polygon": "an object", "polygons": "an object", "radius": "an object", "objects": "a scene",
    "points": "a trajectory", "valid": "a trajectory", "scene": "a trajectory",
    "T_min": "bounds", "T_object": "bounds",
}  # fmt: skip


def unread_fields(document: Mapping[str, Any], family: str) -> tuple[str, ...]:
    """Top-level fields that the family does not read, in order.

    Raises:
        InputError: One of them belongs elsewhere, or is nearly one that is read.
    """
    known = KNOWN[family]
    others = [name for name in document if name not in known]
    for name in others:
        if name in _INSIDE:
            raise InputError(f"{name} inside {_INSIDE[name]}", "it at top level", field=name)
        if name in _INFLUENCE:
            continue  # read by the other family: harmless
        folded = {field.lower(): field for field in known}
        close = get_close_matches(name.lower(), folded, 1, 0.8)
        if close:
            raise InputError(f"{folded[close[0]]}", name, field=name)
    return tuple(others)


def unread_note(document: Mapping[str, Any], family: str) -> str | None:
    """A line for people where there are such fields."""
    names = unread_fields(document, family)
    if not names:
        return None
    return f"not read by rules of the family {family}: {', '.join(names)}"
