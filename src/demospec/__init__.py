"""demospec turns demonstrations into specifications that people can read, check and plan with.

``import demospec`` is light: rooms load on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet, read_set, write_set
    from demospec.errors import DemospecError, InputError

__all__ = ["DemonstrationSet", "DemospecError", "InputError", "read_set", "write_set"]

_HOME = {
    "DemonstrationSet": "demospec.demonstrations",
    "read_set": "demospec.demonstrations",
    "write_set": "demospec.demonstrations",
    "DemospecError": "demospec.errors",
    "InputError": "demospec.errors",
}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'demospec' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
