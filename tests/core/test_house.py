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


def test_no_circles_of_imports() -> None:
    """Imports inside functions count, those for type checkers do not; packages only list names."""
    import grimp
    import numpy as np
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    graph = grimp.build_graph("demospec", exclude_type_checking_imports=True, cache_dir=None)
    modules = sorted(m for m in graph.modules if not graph.find_children(m))
    number = {name: i for i, name in enumerate(modules)}
    pairs = [
        (number[a], number[b])
        for a in modules
        for b in graph.find_modules_directly_imported_by(a)
        if b in number
    ]
    rows, columns = np.array(pairs).T
    matrix = coo_matrix((np.ones(len(pairs)), (rows, columns)), shape=(len(modules),) * 2)
    count, circle = connected_components(matrix, directed=True, connection="strong")
    found = [
        [modules[i] for i in np.flatnonzero(circle == k)]
        for k in range(count)
        if (circle == k).sum() > 1
    ]
    assert found == []
