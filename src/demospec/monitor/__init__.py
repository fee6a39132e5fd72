"""The live monitor: does the robot keep the rule, and for how long still?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.monitor._results import Finding, Reading, Verdict

if TYPE_CHECKING:
    from demospec.monitor._conditions import Condition, MonitorSettings, State
    from demospec.monitor._monitor import Monitor, Sample

__all__ = [
    "Condition",
    "Finding",
    "Monitor",
    "MonitorSettings",
    "Reading",
    "Sample",
    "State",
    "Verdict",
]

_HOME = {
    "Condition": "_conditions",
    "Monitor": "_monitor",
    "MonitorSettings": "_conditions",
    "Sample": "_monitor",
    "State": "_conditions",
}

__getattr__ = names_of(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
