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
        "offsets": d.offsets, "t": d.t,
    }  # fmt: skip
    for name, value in changed.items():
        if isinstance(value, list):
            column = np.empty(len(value), dtype=object)
            column[:] = value
            value = column
        columns[name] = value
    return Demonstrations(**columns)
