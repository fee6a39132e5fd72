"""Execution: robots in MuJoCo that carry plans out, and what really happened."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from demospec.execution._results import Contact, Motion, Rollout

if TYPE_CHECKING:
    from demospec.execution._execute import ROBOTS, execute_plan
    from demospec.execution._video import save_strip, save_video

__all__ = ["ROBOTS", "Contact", "Motion", "Rollout", "execute_plan", "save_strip", "save_video"]

_HOME = {
    "ROBOTS": "_execute",
    "execute_plan": "_execute",
    "save_strip": "_video",
    "save_video": "_video",
}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
