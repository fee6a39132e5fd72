"""The Results page: documents become tables, what is absent or damaged is said."""

from __future__ import annotations

import json
import re
from pathlib import Path

from demospec.demonstrations import simulate_set, write_set
from demospec.files import write_json
from demospec.rules import RuleSet
from demospec.studio.results._curves import curve_files, curves
from demospec.studio.results._export import export
from demospec.studio.results._page import results_html
from demospec.studio.results._view import (
    accuracy,
    audit,
    curve_table,
    effect,
    number,
    repairs,
    section,
)
from demospec.studio.session._workspace import Workbench


def score(balanced: float | None) -> dict[str, object]:
    return {
        "n": 40, "accuracy": 0.8, "balanced_accuracy": balanced, "majority": 0.6,
        "interval": [0.7, 0.9],
    }  # fmt: skip


def test_numbers_have_a_true_minus_and_no_negative_zero() -> None:
    assert number(-0.001) == "0.00"
    assert number(-0.25, sign=True) == "−0.25"
    assert number(0.25, sign=True) == "+0.25"
    assert number(None) == "–"
    assert "[−0.30, −0.20]" in effect({"effect": -0.25, "interval": [-0.3, -0.2]})


def test_a_type_of_one_class_is_not_given_a_score() -> None:
    html = accuracy({"field": {"seen": {"careful": score(0.75), "bold": score(None)}}})
    assert html.count("undefined: one class") == 2  # in the picture and in the table
    assert "75 %" in html.replace("\u00a0", " ")


def test_repairs_show_the_true_rule_beside_the_models_opinion() -> None:
    entry = {
        "n": 9, "vacuous": False, "repaired_by_truth": 0.5, "accepted_by_model": 0.9,
        "moved_px": 12.3,
    }  # fmt: skip
    html = repairs({"field": {"seen": {"careful": entry, "bold": {"vacuous": True}}}})
    assert "true rule accepts" in html
    assert "50\u00a0%" in html
    assert "90\u00a0%" in html
    assert "bold" not in html


def test_curves_rise_with_accuracy_and_leave_out_types_of_one_class(tmp_path: Path) -> None:
    rows = [
        {"model": model, "type": kind, "n": n, "fits": 3, "majority_seen": 0.6,
         "bacc_seen": None if kind == "bold" else share, "bacc_unseen": None}
        for model in ("full", "irl") for kind in ("careful", "bold")
        for n, share in ((1, 0.6), (4, 0.7), (16, 0.9))
    ]  # fmt: skip
    write_json(tmp_path / "accuracy-uniform.json", {"reading": "uniform", "rows": rows})
    (name,) = curve_files(tmp_path)
    html = curves(json.loads((tmp_path / f"{name}.json").read_text()))
    lines = re.findall(r'<polyline points="([^"]+)"', html)
    assert len(lines) == 2  # one for each model
    heights = [float(p.split(",")[1]) for p in lines[0].split()]
    assert heights == sorted(heights, reverse=True)
    assert "bold" not in html
    assert "90" in curve_table({"rows": rows})


def test_words_from_files_cannot_inject_markup() -> None:
    evil = "<script>alert(1)</script>"
    html = audit({"demonstrations": [{"demo_id": evil, "verdict": "review", "why": evil}]})
    assert "<script" not in html
    html = accuracy({evil: {evil: {evil: score(0.5)}}})
    assert "<script" not in html


def test_what_is_absent_or_damaged_is_said(tmp_path: Path) -> None:
    assert "demospec audit" in section(tmp_path, "audit", "Audit", audit, "demospec audit SET")
    (tmp_path / "audit.json").write_text("{", encoding="utf-8")
    assert "audit.json cannot be shown" in section(tmp_path, "audit", "Audit", audit, "x")
    (tmp_path / "audit.json").write_text('{"demonstrations": 3}', encoding="utf-8")
    assert "audit.json cannot be shown" in section(tmp_path, "audit", "Audit", audit, "x")


def test_without_a_run_the_set_can_still_be_taken_away(tmp_path: Path) -> None:
    data, truth = simulate_set(train_scenes=1, test_scenes=1, demonstrations=3, seed=2)
    folder = write_set(data, tmp_path / "set", documents={"truth.json": truth})
    workbench = Workbench(folder, out=tmp_path / "out")
    try:
        html = results_html(workbench)
        assert "No run is shown" in html
        assert "demospec demo --out runs/demo" in html
        assert set(workbench.rule_sets()) == {"understood so far", "truth"}
        name, media, content = export(workbench, "rules", rules="truth")
        assert (name, media) == ("rules.json", "application/json")
        told = json.loads(content)["types"]["careful"]["clearance"]["value"]
        assert told == truth["types"]["careful"]["clearance"]["value"]
        assert all(isinstance(m, RuleSet) for m in workbench.rule_sets().values())
    finally:
        workbench.close()
