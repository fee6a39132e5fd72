"""A release: one version, a changelog of every fragment, a wheel that holds every file."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


def gather() -> ModuleType:
    spec = importlib.util.spec_from_file_location("gather", ROOT / "changelog.d" / "gather.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def declared() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_citation_has_the_version_of_the_package() -> None:
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited is not None
    assert cited[1] == declared()["version"]


def test_fragments_are_gathered_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    version = declared()["version"]
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    (tmp_path / "changelog.d").mkdir()
    (tmp_path / "changelog.d" / "b.md").write_text("- Second.\n")
    (tmp_path / "changelog.d" / "a.md").write_text("- First\n  of two lines.\n")
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## 0.1.0 (then)\n\nOld.\n")
    run = gather().main
    assert run(["9.9.9"], tmp_path) == 2
    assert run([version, "--date", "2026-12-01"], tmp_path) == 0
    assert (tmp_path / "CHANGELOG.md").read_text() == (
        f"# Changelog\n\n## {version} (2026-12-01)\n\n- First\n  of two lines.\n- Second.\n\n"
        "## 0.1.0 (then)\n\nOld.\n"
    )
    assert not list((tmp_path / "changelog.d").iterdir())
    assert run([version], tmp_path) == 2
    assert "already" in capsys.readouterr().err


def test_every_fragment_is_a_list() -> None:
    for file in (ROOT / "changelog.d").glob("*.md"):
        assert file.read_text(encoding="utf-8").startswith("- "), file.name


def test_no_dependency_of_the_core_has_an_upper_bound() -> None:
    assert not [line for line in declared()["dependencies"] if "<" in line or "==" in line]


@pytest.mark.slow
def test_the_wheel_holds_every_file_and_runs_from_an_empty_folder(tmp_path: Path) -> None:
    pytest.importorskip("build", reason="pip install 'demospec[dev]'")
    uv = Path(sys.executable).with_name("uv")
    if not uv.is_file():
        pytest.skip("uv is absent: pip install 'demospec[dev]'")
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--installer", "uv", "-o", tmp_path, ROOT],
        check=True, capture_output=True,
    )  # fmt: skip
    (wheel,) = tmp_path.glob("*.whl")
    tracked = subprocess.run(
        ["git", "ls-files", "src/demospec"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split("\n")
    expected = {line.removeprefix("src/") for line in tracked if line}
    held = {n for n in zipfile.ZipFile(wheel).namelist() if n.startswith("demospec/")}
    assert held == expected
    python = tmp_path / "venv" / "bin" / "python"
    subprocess.run([uv, "venv", "-q", "--python", sys.executable, tmp_path / "venv"], check=True)
    subprocess.run([uv, "pip", "install", "-q", "--python", python, wheel], check=True)
    empty = tmp_path / "empty"
    empty.mkdir()
    command = python.with_name("demospec")

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([command, *arguments], cwd=empty, capture_output=True, text=True)

    done = run("simulate", "--out", "set", "--train-scenes", "2", "--test-scenes", "1")
    assert (done.returncode, done.stderr.count("Warning")) == (0, 0), done.stderr
    done = run("rules", "set", "--out", "rules.json", "--picture", "rules.png")
    assert (done.returncode, done.stderr.count("Warning")) == (0, 0), done.stderr
    # What the core lacks is named with the extra that brings it.
    done = run("demo", "--out", "demo")
    assert done.returncode == 2
    assert "demospec[vision]" in done.stderr
    assert "Traceback" not in done.stderr
