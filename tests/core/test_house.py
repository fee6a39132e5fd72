"""The house: public names import, rooms stay light, the import contract holds."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

ROOMS = (
    "scene", "demonstrations", "rules", "perception", "specification", "causal", "planning",
    "execution", "experiments", "report", "studio", "cli",
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
