"""OR-tools is an extra: only the engines `direct` and `step` need it, and they name it."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from rules_problems import random_problem

from demospec.testing import problem_document

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"
WITHOUT = "import sys; sys.modules['ortools'] = None; from demospec.cli import main; main({})"


def run_without_ortools(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The command line in a process in which `import ortools` fails."""
    code = WITHOUT.format(list(arguments))
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


@pytest.fixture
def problem_file(tmp_path):
    file = tmp_path / "problem.json"
    file.write_text(json.dumps(problem_document(random_problem(1, "sum", "distance", flip=0.0))))
    return file


@pytest.mark.parametrize("engine", ["direct", "step"])
def test_an_engine_without_its_extra_names_it(problem_file, engine):
    done = run_without_ortools("rules", str(problem_file), "--engine", engine, "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    expected = f"engine {engine} needs ortools: run  pip install 'demospec[cpsat]'"
    assert done.stderr == f"demospec: {expected}\n"


def test_everything_else_works_without_it(problem_file):
    for extra in ([], ["--engine", "exact"], ["--tolerant"], ["--enough"]):
        done = run_without_ortools("rules", str(problem_file), "--json", *extra)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)


def test_the_core_does_not_require_it():
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
    core = {Requirement(line).name for line in project["dependencies"]}
    extra = {Requirement(line).name for line in project["optional-dependencies"]["cpsat"]}
    assert extra == {"ortools", "protobuf"}
    assert not core & extra
    (everything,) = project["optional-dependencies"]["all"]
    assert "cpsat" in Requirement(everything).extras
