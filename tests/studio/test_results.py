"""The Results page: it is the report, of a run or of what was taught; what is missing is said."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from demospec.demonstrations import bezier_points, simulate_set, write_set
from demospec.errors import InputError
from demospec.files import write_json
from demospec.report import build_report, render_parts
from demospec.rules import RuleSet, learn_rules, rules_document
from demospec.studio.results._export import choices, export, report_of, subjects
from demospec.studio.results._page import Parts, page_markup, videos_of
from demospec.studio.results._run import label_changes, taught_run
from demospec.studio.session._workspace import Workbench

EVIL = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data, truth = simulate_set(train_scenes=2, test_scenes=1, demonstrations=3, seed=2)
    place = tmp_path_factory.mktemp("results")
    return write_set(data, place / "set", documents={"truth.json": truth})


@pytest.fixture
def bench(folder: Path, tmp_path: Path) -> Iterator[Workbench]:
    bench = Workbench(folder, out=tmp_path / "out")
    yield bench
    bench.close()


def test_a_run_is_shown_by_the_report_itself(folder: Path, tmp_path: Path) -> None:
    from demospec.demonstrations import read_set

    run = tmp_path / "run"
    data = read_set(folder)
    write_set(data, run / "set")
    rules = learn_rules(data, split=None, influence=False)
    write_json(run / "rules.json", rules_document(rules))
    bench = Workbench(None, None, run, out=tmp_path / "taught")
    assert list(subjects(bench)) == ["run", "taught"]
    parts = Parts(bench)
    assert parts.of("run") == render_parts(build_report(run))
    assert parts.of("run") is parts.of("run")  # written once
    (run / "rules.json").write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match=r"rules\.json"):
        report_of(bench, "run")
    assert videos_of(run) == []
    bench.close()


def test_what_was_taught_becomes_a_report_with_the_same_numbers(bench: Workbench) -> None:
    run = taught_run(bench)
    assert run is not None
    rules = bench.rules()
    assert rules is not None
    report = build_report(run)
    assert [p.name for p in report.people] == list(rules.rules)
    for person in report.people:
        sentence = rules.rules[person.name].sentence
        assert person.sentence.rstrip(".").lower() == sentence.lower()
    assert {s.anchor for s in report.sections} >= {"shown", "sure", "doubts", "plans", "computed"}
    assert {light.name for p in report.people for light in p.lights if light.state != "unknown"}
    name, media, content = export(bench, "report", of="taught")
    assert (name, media) == ("report.html", "text/html")
    assert report.people[0].sentence in unescape(content.decode())


def test_labels_that_were_changed_are_in_the_report(bench: Workbench) -> None:
    first = bench.demonstrations[0]
    assert first.valid is not None
    scene = bench.scenes[0]
    path = bezier_points(scene.start[:2], scene.goal[:2], [[[50.0, 50.0]]], 20)[0]
    drawn = bench.draw(scene.scene_id, path, actor="tab", type="careful")
    bench.label(drawn.demo_id, True, actor="tab")  # a first label is no change
    assert label_changes(bench) == ()
    bench.label(first.demo_id, not first.valid, actor="tab")
    (change,) = label_changes(bench)
    assert (change.demo_id, change.before, change.after) == (
        first.demo_id, first.valid, not first.valid
    )  # fmt: skip
    run = taught_run(bench)
    assert run is not None
    assert "1 label changed after being given." in build_report(run).summary
    bench.undo("tab")
    assert label_changes(bench) == ()


def test_what_cannot_be_had_is_said_beforehand(tmp_path: Path) -> None:
    bench = Workbench(out=tmp_path / "new")
    offered = choices(bench)
    assert set(offered.missing) == {"set", "rules", "report", "nav2", "moveit", "mcap"}
    assert all(words.endswith(".") for words in offered.missing.values())
    with pytest.raises(InputError):
        export(bench, "report")
    html = page_markup(bench)
    assert "Nothing to report yet" in html
    assert "Draw a path first" in html
    bench.close()


def test_the_set_and_the_rules_can_be_taken_along(bench: Workbench, folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text())
    assert set(bench.rule_sets()) == {"understood so far", "truth"}
    name, media, content = export(bench, "rules", rules="truth")
    assert (name, media) == ("rules.json", "application/json")
    told = json.loads(content)["types"]["careful"]["clearance"]["value"]
    assert told == truth["types"]["careful"]["clearance"]["value"]
    assert all(isinstance(m, RuleSet) for m in bench.rule_sets().values())
    assert choices(bench).missing.keys() <= {"mcap"}


def test_names_are_text_on_the_page(tmp_path: Path) -> None:
    data, _ = simulate_set(train_scenes=1, test_scenes=0, demonstrations=1, seed=2)
    data.demonstrations.type[:] = EVIL
    from dataclasses import replace

    folder = write_set(replace(data, types=(EVIL,)), tmp_path / "set")
    bench = Workbench(folder, out=tmp_path / "out")
    html: Any = page_markup(bench)
    assert "<script" not in html
    bench.close()


def test_while_rules_are_learned_what_needs_them_is_said_to_come(bench: Workbench) -> None:
    html = page_markup(bench, learning=True)
    assert "data-learning" in html
    assert "Learning from the labels" in html
    assert "data-learning" not in page_markup(bench)
