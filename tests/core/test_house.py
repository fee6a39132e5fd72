"""The house: public names import, rooms stay light, the import contract holds."""

from __future__ import annotations

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOMS = (
    "scene", "demonstrations", "rules", "perception", "specification", "causal", "planning",
    "execution", "experiments", "report", "studio", "cli", "testing",
)  # fmt: skip
HEAVY = ("torch", "ortools", "mujoco", "nicegui", "ompl", "matplotlib", "pandas", "pyarrow")


@pytest.mark.parametrize("room", ["", *ROOMS])
def test_every_public_name_imports(room: str) -> None:
    module = importlib.import_module(f"demospec.{room}".rstrip("."))
    for name in getattr(module, "__all__", []):
        assert getattr(module, name) is not None, name


@pytest.mark.parametrize("room", ["", *ROOMS])
def test_importing_a_room_loads_nothing_heavy(room: str) -> None:
    name = f"demospec.{room}".rstrip(".")
    code = f"import {name}, sys; print([m for m in {HEAVY!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_import_contract() -> None:
    from importlinter.cli import lint_imports

    assert lint_imports(no_cache=True) == 0


def test_every_room_keeps_its_private_modules() -> None:
    root = Path(__file__).parents[2]
    contracts = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["importlinter"]
    kept = {
        contract["allowed_importers"][0]: contract["protected_modules"]
        for contract in contracts["contracts"]
        if contract["type"] == "protected"
    }
    rooms = [f"demospec.{f.parent.name}" for f in (root / "src/demospec").glob("*/__init__.py")]
    assert kept == {room: [f"{room}.**"] for room in rooms}
