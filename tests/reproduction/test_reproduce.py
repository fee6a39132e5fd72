"""A small reproduction: everything is there, agrees with itself, and goes on where it stopped."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="pip install 'demospec[vision]' brings torch")

from demospec.errors import InputError
from demospec.experiments.paper import ReproduceSettings, reproduce

SMALL = ReproduceSettings(
    seeds=1, counts=(1,), clustered_counts=(1,), models=("full", "irl"), starts=4, particles=2,
    demonstrations=10, resamples=2, boundary_scenes=2, rejected=1, identified=4, samples=3,
)  # fmt: skip


def test_another_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    with pytest.raises(InputError, match="a new or empty folder"):
        reproduce(tmp_path, SMALL)


@pytest.mark.slow
def test_a_small_run(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    record = reproduce(folder, SMALL)
    assert not record.cached
    page = (folder / "reproduction.html").read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert page.count("data:image/png") >= 9
    verdicts = (folder / "beside-the-paper.csv").read_text(encoding="utf-8")
    for words in ("not met", "not comparable, because"):
        assert words in verdicts
        assert words in page
    for name in ("accuracy-as-printed", "accuracy-uniform", "accuracy-clustered", "transition"):
        assert (folder / f"{name}.svg").is_file()
    rows = json.loads((folder / "accuracy-uniform.json").read_text())["rows"]
    with (folder / "accuracy-uniform.csv").open(encoding="utf-8") as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == len(rows)
    for row, cells in zip(rows, table, strict=True):
        value = row["bacc_seen"]
        assert cells["bacc_seen"] == ("" if value is None else str(value))
    # Killed before the page: only what is missing is computed again, to the same numbers.
    before = (folder / "accuracy-uniform.json").read_bytes()
    (folder / "accuracy-uniform.json").unlink()
    grid = (folder / "grid-uniform.jsonl").read_bytes()
    again = reproduce(folder, SMALL)
    assert set(again.seconds) - set(again.cached) == {"accuracy-uniform.json"}
    assert (folder / "accuracy-uniform.json").read_bytes() == before
    assert (folder / "grid-uniform.jsonl").read_bytes() == grid
