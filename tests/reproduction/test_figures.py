"""Figures of repairs and of items: three scenes by every type, unseen items beside the others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from demospec.demonstrations import simulate_set
from demospec.experiments.paper._pictures import _common_scenes, draw_items, draw_repairs


def _study(*scenes: str) -> dict[str, Any]:
    line = [[10.0, 90.0], [50.0, 40.0], [90.0, 10.0]]
    examples = [{"scene": s, "steps": [line] * 4, "rule_valid": True} for s in scenes]
    return {"vacuous": not scenes, "examples": examples}


def test_scenes_in_which_most_types_have_something_to_repair_come_first() -> None:
    study = {"careful": _study("0", "1", "2", "3"), "normal": _study("3", "1"), "bold": _study()}
    assert _common_scenes(study) == ["1", "3", "0"]
    assert _common_scenes({"bold": _study()}) == []


def test_repairs_are_drawn_where_a_type_rejects_nothing(tmp_path: Path) -> None:
    data, _ = simulate_set(train_scenes=2, test_scenes=0, demonstrations=1, seed=0)
    study = {"careful": _study("0000", "0001"), "aggressive": _study()}
    draw_repairs(data, study, tmp_path / "repairs.svg")
    text = (tmp_path / "repairs.svg").read_text()
    assert text.count("aggressive: rejects nothing") == 2
    assert text.count("careful: true rule accepts") == 2
    draw_repairs(data, {"aggressive": _study()}, tmp_path / "none.svg")


def test_training_and_unseen_items_share_none(tmp_path: Path) -> None:
    from demospec.scene import load_catalogue

    draw_items(("glass",), "builtin", tmp_path / "items.svg")
    text = (tmp_path / "items.svg").read_text()
    assert "in training scenes" in text
    assert "unseen" in text
    parts = [{i.name for i in load_catalogue("builtin", p).of_symbol("glass")}  # type: ignore[arg-type]
             for p in ("train", "test")]  # fmt: skip
    assert not parts[0] & parts[1]
