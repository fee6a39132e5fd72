"""Every export has an example, and every example runs."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
NEEDS = {
    "42_export_ompl": ("ompl", "planners"),
    "44_export_rosbag2": ("rosbags", "ros"),
    "45_export_mcap": ("mcap", "ros"),
    "47_export_stl": ("rtamt", "stl"),
    "48_execute_pr2": ("mink", "robot"),
}
SAYS = {
    "40_export_nav2": "cells of 167x167 are kept out of",
    "41_export_moveit": " as ",
    "42_export_ompl": "BIT*:",
    "43_export_numpy": "price at the start: 1.0",
    "44_export_rosbag2": "/plan nav_msgs/msg/Path 1",
    "45_export_mcap": "/cost_map nav_msgs/msg/OccupancyGrid",
    "46_export_waypoints": "way-points in",
    "47_export_stl": "robustness of the plan:",
    "48_execute_pr2": "the executed path keeps the rule: True",
    "47_export_tesseract": "tool keeps",
    "49_export_vda5050": "BLOCKED",
}


@pytest.mark.parametrize("name", sorted(p.stem for p in EXAMPLES.glob("4*.py")))
def test_example_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name in NEEDS:
        library, extra = NEEDS[name]
        pytest.importorskip(library, reason=f"pip install 'demospec[{extra}]' brings {library}")
    monkeypatch.setattr(sys, "argv", [name, str(tmp_path)])
    monkeypatch.setenv("MUJOCO_GL", "egl")
    runpy.run_path(str(EXAMPLES / f"{name}.py"))
    assert SAYS[name] in capsys.readouterr().out


def test_every_export_has_an_example() -> None:
    from demospec.planning.exports import FILES, FOLDERS

    text = "".join(p.read_text() for p in EXAMPLES.glob("4*.py"))
    for form in [*FOLDERS, *FILES]:
        assert f'export_to(request, "{form}"' in text
