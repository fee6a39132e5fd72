"""The live monitor: does the robot keep the rule, and for how long still?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.monitor._results import Finding, Reading, Verdict

if TYPE_CHECKING:
    from demospec.monitor._check_run import (
        Deviation,
        Episode,
        RunCheck,
        check_run,
        plan_of_bag,
        plan_of_file,
    )
    from demospec.monitor._conditions import Condition, MonitorSettings, State
    from demospec.monitor._filter import Filtered, FilterSettings, VelocityFilter
    from demospec.monitor._monitor import Monitor, Sample
    from demospec.monitor.streams._events import Event, handle, readings_of
    from demospec.monitor.streams._frame import RobotFrame
    from demospec.monitor.streams._live import readings_of_lines
    from demospec.monitor.streams._outputs import Lines, McapFile
    from demospec.monitor.streams._recorded import recorded_events
    from demospec.monitor.streams._ros2 import readings_of_ros2
    from demospec.monitor.streams._scene_file import read_scene

__all__ = [
    "Condition",
    "Deviation",
    "Episode",
    "Event",
    "FilterSettings",
    "Filtered",
    "Finding",
    "Lines",
    "McapFile",
    "Monitor",
    "MonitorSettings",
    "Reading",
    "RobotFrame",
    "RunCheck",
    "Sample",
    "State",
    "VelocityFilter",
    "Verdict",
    "check_run",
    "handle",
    "plan_of_bag",
    "plan_of_file",
    "read_scene",
    "readings_of",
    "readings_of_lines",
    "readings_of_ros2",
    "recorded_events",
]

_HOME = {
    "Condition": "_conditions",
    "Deviation": "_check_run",
    "Episode": "_check_run",
    "Event": "streams._events",
    "FilterSettings": "_filter",
    "Filtered": "_filter",
    "Lines": "streams._outputs",
    "McapFile": "streams._outputs",
    "Monitor": "_monitor",
    "MonitorSettings": "_conditions",
    "RobotFrame": "streams._frame",
    "RunCheck": "_check_run",
    "Sample": "_monitor",
    "State": "_conditions",
    "VelocityFilter": "_filter",
    "check_run": "_check_run",
    "handle": "streams._events",
    "plan_of_bag": "_check_run",
    "plan_of_file": "_check_run",
    "read_scene": "streams._scene_file",
    "readings_of": "streams._events",
    "readings_of_lines": "streams._live",
    "readings_of_ros2": "streams._ros2",
    "recorded_events": "streams._recorded",
}

__getattr__ = names_of(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
