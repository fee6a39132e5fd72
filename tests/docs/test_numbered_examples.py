"""Every numbered example runs and says what its first lines promise."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
SAYS = {
    "01_three_lines": "aggressive: no demonstration was rejected",
    "02_your_own_arrays": "the labels allow",
    "03_check_and_audit": "demonstrations to look at again",
    "10_rules_with_intervals": "normal: glass",
    "11_rules_of_the_paper": "optimal consistent parameter sets",
    "12_ask_next": "question 10:",
    "20_judge_pictures": "aggressive undefined: one class",
    "21_repair_sample_explain": "repaired by moving the control point",
    "22_whose_demonstrations": "normal-1: normal",
    "30_causes": "normal looks out for glasses",
    "31_had_it_not_been_there": "had glass-0 not been there, normal would accept it",
    "39_plan": "keeps the demonstrator's rule: True",
    "50_own_model": "normal looks out for glasses",
    "51_own_point_feature": "optimal: rejected once tilted more than 30 to 39 degrees",
    "61_monitor_ros2": "heard: ok, violation, warn",
    "60_monitor": "without: ok from 0.00 s, warn from 2",
}
NAMES = sorted(p.stem for p in EXAMPLES.glob("*.py") if not p.stem.startswith("4"))


@pytest.mark.parametrize("name", NAMES)
def test_example_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name == "60_monitor":
        pytest.importorskip("qpsolvers", reason="pip install 'demospec[filter]'")
    if name == "61_monitor_ros2":
        pytest.importorskip("rclpy", reason="pip install 'demospec[ros2]'")
    if name == "20_judge_pictures":
        pytest.importorskip("torch", reason="pip install 'demospec[vision]' brings torch")
    monkeypatch.setattr(sys, "argv", [name, str(tmp_path)])
    runpy.run_path(str(EXAMPLES / f"{name}.py"))
    assert SAYS[name] in capsys.readouterr().out


LONG = ("61_what_the_paper_model_learns",)  # trains the paper's model


@pytest.mark.parametrize(
    "notebook",
    [
        pytest.param(p, id=p.stem, marks=pytest.mark.slow if p.stem in LONG else ())
        for p in sorted(EXAMPLES.glob("*.ipynb"))
    ],
)
def test_notebook_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a fresh kernel, in an empty folder."""
    monkeypatch.delenv("MPLBACKEND", raising=False)  # the notebook's own: pictures in the page
    nbclient = pytest.importorskip("nbclient", reason="pip install nbclient ipykernel")
    nbformat = pytest.importorskip("nbformat", reason="pip install nbclient ipykernel")
    pytest.importorskip("ipykernel", reason="pip install nbclient ipykernel")
    pytest.importorskip("torch", reason="pip install 'demospec[vision]' brings torch")
    content = nbformat.read(notebook, as_version=4)
    resources = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(content, timeout=240, resources=resources).execute()
    assert any(
        "image/png" in output.get("data", {})
        for cell in content.cells
        for output in cell.get("outputs", [])
    )
