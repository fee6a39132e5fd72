"""The same demonstrations with some columns exchanged."""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.demonstrations._trajectory import (
    Demonstrations,
)


def with_columns(d: Demonstrations, **changed: Any) -> Demonstrations:
    """The same demonstrations with some columns exchanged."""
    columns: dict[str, Any] = {
        "demo_id": d.demo_id, "scene_id": d.scene_id, "type": d.type,
        "demonstrator": d.demonstrator, "valid": d.valid, "flat": d.flat,
        "offsets": d.offsets, "t": d.t, "score": d.score,
    }  # fmt: skip
    for name, value in changed.items():
        if isinstance(value, list):
            column = np.empty(len(value), dtype=object)
            column[:] = value
            value = column
        columns[name] = value
    if d.score is not None and "valid" in changed and "score" not in changed:
        # A verdict that somebody changed takes the place of the score.
        columns["score"] = np.where(columns["valid"] == d.valid, d.score, np.nan)
    return Demonstrations(**columns)
