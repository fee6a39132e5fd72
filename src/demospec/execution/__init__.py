"""Execution: robots in MuJoCo that carry plans out, and what really happened."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.execution._results import Contact, Motion, Rollout

if TYPE_CHECKING:
    from demospec.execution._execute import ALLOWANCE_M, ROBOTS, execute_plan
    from demospec.execution._video import save_strip, save_video

__all__ = [
    "ALLOWANCE_M",
    "ROBOTS",
    "Contact",
    "Motion",
    "Rollout",
    "execute_plan",
    "save_strip",
    "save_video",
]

_HOME = {
    "ALLOWANCE_M": "_execute",
    "ROBOTS": "_execute",
    "execute_plan": "_execute",
    "save_strip": "_video",
    "save_video": "_video",
}


__getattr__ = names_of(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
