"""Every Python block of the README and of docs/ runs as it stands; links lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what `make demo` leaves: a simulated set at runs/demo/set, only smaller."""
    from demospec.demonstrations import simulate_set, write_set

    folder = tmp_path_factory.mktemp("pages")
    data, truth = simulate_set(train_scenes=6, test_scenes=2, demonstrations=4, seed=0)
    write_set(data, folder / "runs" / "demo" / "set", documents={"truth.json": truth})
    return folder


@pytest.mark.parametrize("page", PAGES, ids=[p.name for p in PAGES])
def test_code_blocks_run(page: Path, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of one page share their names, as a reader would type them."""
    monkeypatch.chdir(place)
    names: dict[str, object] = {"__name__": "page"}
    for block in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(block, str(page), "exec"), names)


@pytest.mark.parametrize("page", PAGES, ids=[p.name for p in PAGES])
def test_links_to_files_exist(page: Path) -> None:
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if not target.startswith(("http:", "https:", "mailto:")):
            assert (page.parent / target).exists(), target


def test_the_page_on_the_code_names_files_that_exist() -> None:
    text = (ROOT / "docs" / "code.md").read_text(encoding="utf-8")
    paths = {p for p in re.findall(r"`([a-z_]+/[\w/]*(?:\.py)?)`", text) if "NAME" not in p}
    assert len(paths) > 30
    for path in paths:
        rooms = ROOT / "src" / "demospec"
        assert (ROOT / path).exists() or any(rooms.rglob(path.rstrip("/"))), path
