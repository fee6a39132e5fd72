"""The documentation site builds without a warning and asks nothing of other machines."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LOADED = re.compile(
    r"""<(?:script|img|iframe|source)[^>]*\ssrc=["']?(https?:)?//"""
    r"""|<link[^>]*rel=["']?(?:stylesheet|preconnect|preload|icon)[^>]*href=["']?(https?:)?//"""
    r"""|@import[^;]*//|url\(["']?https?:"""
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for package in ("mkdocs", "material", "mkdocstrings"):
        pytest.importorskip(package, reason="pip install 'demospec[dev]'")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_page_is_there(site: Path) -> None:
    for page in (ROOT / "docs").glob("*.md"):
        assert (site / f"{page.stem}.html").is_file(), page.name


def test_no_page_loads_anything_from_elsewhere(site: Path) -> None:
    for file in [*site.rglob("*.html"), *site.rglob("*.css")]:
        found = LOADED.search(file.read_text(encoding="utf-8"))
        assert found is None, f"{file.name}: {found and found.group(0)}"


def test_the_command_line_page_holds_every_command(site: Path) -> None:
    from demospec.cli._app import COMMANDS

    text = (site / "command-line.html").read_text(encoding="utf-8")
    written = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
    for command in COMMANDS:
        assert f'<h2 id="{command}"' in text
        assert f"`{command}`" in written
    assert "--clearance-px" in text


def test_the_library_page_holds_signatures(site: Path) -> None:
    text = (site / "api.html").read_text(encoding="utf-8")
    assert "read_set" in text
    assert "run_tasks" in text


def test_every_page_links_to_the_terms_that_it_uses(site: Path) -> None:
    for page in ("rules", "planning", "perception", "how-to-studio", "code"):
        text = (site / f"{page}.html").read_text(encoding="utf-8")
        assert 'href="glossary.html#' in text, page
