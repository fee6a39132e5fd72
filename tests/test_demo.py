"""The whole way on a tiny set: every stage leaves its artefact, the report is one whole page."""

from __future__ import annotations

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import pytest

from demospec.cli import main
from demospec.errors import InputError
from demospec.files import read_json
from demospec.pipeline import DemoSettings, run_demo
from demospec.report import build_report, write_markdown

pytest.importorskip("torch", reason="pip install 'demospec[vision]'")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demo") / "run"
    settings = DemoSettings(train_scenes=4, test_scenes=2, demonstrations=4, models=("paper",))
    run_demo(folder, settings)
    return folder


def test_second_run_computes_nothing(run: Path) -> None:
    settings = DemoSettings(train_scenes=4, test_scenes=2, demonstrations=4, models=("paper",))
    before = (run / "report.html").read_bytes()
    record = run_demo(run, settings)
    assert set(record.cached) == set(record.seconds)
    assert (run / "report.html").read_bytes() == before


class _Page(HTMLParser):
    """Collects what a page would fetch, and its headings."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name in ("src", "srcset", "data") or (name == "href" and tag == "link"):
                self.fetched.append(str(value))


def test_report_is_self_contained(run: Path) -> None:
    text = (run / "report.html").read_text(encoding="utf-8")
    page = _Page()
    page.feed(text)
    assert page.tags.count("img") >= 4
    assert all(url.startswith("data:image/png;base64,") for url in page.fetched)
    assert "script" not in page.tags
    assert not re.search(r"url\(\s*['\"]?http", text)


def test_report_keeps_seen_and_unseen_scenes_apart(run: Path) -> None:
    text = (run / "report.html").read_text(encoding="utf-8")
    assert "<td>seen</td>" in text
    assert "<td>unseen</td>" in text
    assert "undefined: one class" in text
    assert "demospec demo" in text


def test_plans_and_repairs_are_judged_by_the_truth(run: Path) -> None:
    """Recomputed here from truth.json, which no model reads."""
    import numpy as np

    from demospec import read_rules, read_set

    truth = read_rules(run / "set" / "truth.json")
    data = read_set(run / "set")
    plans = read_json(run / "plans.json")["plans"]
    assert len(plans) == 2 * 3
    for plan in plans:
        if plan["status"] == "found":
            judge = truth.see(data.scene(plan["scene"]))
            p = judge.p_valid([np.asarray(plan["points"])], plan["type"])[0]
            # `obeys` is exact between points; the dense curve may forgive 0.01 px.
            assert plan["true_obeys"] <= (p > 0.5)
    repairs = read_json(run / "repairs.json")["paper"]["unseen"]
    assert repairs["aggressive"]["vacuous"]
    for type_, result in repairs.items():
        for example in result["examples"]:
            judge = truth.see(data.scene(example["scene"]))
            last = np.asarray(example["steps"][-1])
            assert example["rule_valid"] == (judge.p_valid([last], type_)[0] > 0.5)


def test_markdown_has_the_same_sections(run: Path, tmp_path: Path) -> None:
    report = build_report(run)
    text = write_markdown(report, tmp_path / "md").read_text(encoding="utf-8")
    for section in report.sections:
        assert f"## {section.title}" in text
    assert len(list((tmp_path / "md").glob("*.png"))) >= 4


def test_report_of_no_run_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match="run folder"):
        build_report(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["report", str(tmp_path)])
    assert stop.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_report_of_a_damaged_run_is_one_line(run: Path, tmp_path: Path) -> None:
    import shutil

    broken = tmp_path / "run"
    shutil.copytree(run, broken)
    (broken / "plans.json").write_text(json.dumps({"plans": [{}]}))
    with pytest.raises(InputError, match=r"plans\.json, plans\.0\.scene: expected a value"):
        build_report(broken)


def test_the_report_asks_for_the_next_demonstration(run: Path) -> None:
    questions = read_json(run / "query.json")
    assert set(questions) == {"careful", "normal", "aggressive"}
    section = next(s for s in build_report(run).sections if s.anchor == "sure")
    captions = " ".join(getattr(b, "caption", "") + getattr(b, "words", "") for b in section.blocks)
    asked = [q for q in questions.values() if q["status"] == "ask"]
    assert ("What to demonstrate next" in captions) == bool(asked)


def test_a_report_of_what_single_commands_wrote(run: Path, tmp_path: Path) -> None:
    """No run.json: one model's causes and one question, as `--out` writes them."""
    shutil.copytree(run / "set", tmp_path / "set")
    shutil.copy(run / "rules.json", tmp_path)
    causes = next(iter(read_json(run / "causes.json").values()))
    (tmp_path / "causes.json").write_text(json.dumps(causes))
    question = {**read_json(run / "query.json")["careful"], "type": "careful"}
    (tmp_path / "query.json").write_text(json.dumps(question))
    titles = [s.title for s in build_report(tmp_path).sections]
    assert titles[0] == "What was demonstrated"
    assert "How sure that is" in titles


def test_an_unknown_catalogue_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["demo", "--catalogue", "bogus", "--out", str(tmp_path / "run")])
    assert stop.value.code == 2
    said = capsys.readouterr().err
    assert len(said.strip().splitlines()) == 1
    assert "bogus" in said
    assert "builtin" in said
    assert not (tmp_path / "run").exists()
