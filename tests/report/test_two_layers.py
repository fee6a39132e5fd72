"""The first layer of a report, what its documents must hold, and one look for each meaning."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, read_set, simulate_set, write_set
from demospec.errors import InputError
from demospec.files import write_json
from demospec.report import (
    AuditEntry,
    PlanEntry,
    QueryEntry,
    Report,
    Run,
    build_report,
    look_of,
    read_run,
    render_html,
    write_html,
)
from demospec.rules import RuleSet, learn_rules, rules_document

EVIL = "<img src=x onerror=alert(1)>'\"</style><script>"


@pytest.fixture(scope="module")
def made() -> tuple[DemonstrationSet, RuleSet]:
    data, _ = simulate_set(train_scenes=3, test_scenes=1, demonstrations=8, seed=3)
    return data, learn_rules(data.of_split("train"), influence=False)


@pytest.fixture(scope="module")
def run(made: tuple[DemonstrationSet, RuleSet]) -> Run:
    return Run(made[0], rules=made[1])


@pytest.fixture(scope="module")
def folder(
    made: tuple[DemonstrationSet, RuleSet], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    folder = tmp_path_factory.mktemp("layers") / "run"
    write_set(made[0], folder / "set")
    write_json(folder / "rules.json", rules_document(made[1]))
    return folder


def lights(report: Report, name: str) -> dict[str, tuple[str, str]]:
    (person,) = (p for p in report.people if p.name == name)
    return {light.name: (light.state, light.words) for light in person.lights}


def test_three_lights_stand_beside_the_sentence_of_each_person(run: Run) -> None:
    report = build_report(run)
    assert [p.name for p in report.people] == list(run.data.types)
    assert run.rules is not None
    said = run.rules.rules["careful"].sentence
    assert report.people[0].sentence.lower().startswith(said[:20].lower())
    found = lights(report, "aggressive")
    assert found["Enough shown"][0] == "bad"
    assert "nothing was rejected" in found["Enough shown"][1]
    # Where nothing was rejected, no plan can be right about a rule, and what to show is known.
    assert "nothing was rejected" in found["Plans keep the rule"][1]
    (aggressive,) = (p for p in report.people if p.name == "aggressive")
    assert dict(aggressive.facts)["Show next:"] == "a path that is too close, and reject it."
    assert lights(report, "careful")["Plans keep the rule"][0] == "unknown"
    assert lights(report, "careful")["Enough shown"][0] == "unknown"


def test_lights_follow_the_documents(run: Run) -> None:
    scene = run.data.scenes[0]
    plan = PlanEntry(scene=scene.scene_id, type="careful", status="found", obeys=True, length=99.0,
                     points=((0.0, 0.0), (9.0, 9.0)))  # fmt: skip
    mine = [d.demo_id for d in run.data.demonstrations if d.type == "careful"]
    asked = QueryEntry(status="ask", scene=scene.scene_id, points=plan.points, bits=0.9, total=16.0)

    def shown(**parts: Any) -> dict[str, tuple[str, str]]:
        return lights(build_report(replace(run, **parts)), "careful")

    good = shown(
        plans=(plan,), query={"careful": QueryEntry(status="settled")},
        audit=tuple(AuditEntry(demo_id=n, verdict="pass") for n in mine),
    )  # fmt: skip
    assert {state for state, _ in good.values()} == {"good"}
    doubted = tuple(AuditEntry(demo_id=n, verdict="review", why="near") for n in mine[:1])
    broken = plan.model_copy(update={"obeys": False})
    bad = shown(plans=(plan, broken), query={"careful": asked}, audit=doubted)
    assert bad["Plans keep the rule"] == ("bad", "1 of 2 break it")
    assert bad["Enough shown"] == ("mixed", "about 6 more answers would settle it")
    assert bad["Answers agree"][0] == "mixed"
    assert mine[0] in bad["Answers agree"][1]
    assert run.rules is not None
    careful = run.rules.rules["careful"]
    assert careful.fit is not None
    chance = replace(careful, fit=replace(careful.fit, verdict="not"))
    doubtful = shown(rules=RuleSet({"careful": chance}))["Answers agree"]
    assert doubtful == ("mixed", "too few answers to tell the rule from chance")
    # Nothing known decides: that is neither kept nor broken.
    open_ = shown(plans=(plan.model_copy(update={"obeys": None}),))
    assert open_["Plans keep the rule"][0] == "unknown"


def test_what_is_not_known_is_said_and_drawn(run: Run) -> None:
    assert run.rules is not None
    rules = run.rules.rules["normal"]
    assert rules.clearance is not None
    there = {o.symbol for s in run.data.scenes for o in s.listed_objects()}
    symbol = next(s for s in sorted(there) if s not in rules.clearance.relevant)
    unsure = replace(rules, clearance=replace(rules.clearance, uninformed=(symbol,)))
    report = build_report(replace(run, rules=RuleSet({"normal": unsure})))
    (person,) = report.people
    assert symbol in dict(person.facts)["Not known:"]
    assert person.picture is not None
    assert ("ring-unknown" in person.picture.svg) == ("?: not known" in person.picture.caption)


def test_a_label_that_a_tool_changed_is_named(folder: Path, tmp_path: Path) -> None:
    own = tmp_path / "run"
    shutil.copytree(folder, own)
    name = str(read_set(own / "set").demonstrations.demo_id[0])
    shutil.rmtree(own / "set")
    with pytest.raises(SystemExit) as stop:
        main(["edit", "relabel", str(folder / "set"), "--flip", name, "--out", str(own / "set")])
    assert not stop.value.code
    report = build_report(own)
    facts = {heading: words for p in report.people for heading, words in p.facts}
    assert name in facts["Labels that were changed:"]
    assert "demospec edit relabel" in facts["Labels that were changed:"]
    assert "1 label changed after being given." in report.summary
    assert "1 label changed afterwards" in report.sections[0].lead


@pytest.mark.parametrize(
    ("name", "content", "place"),
    [
        ("plans", {"points": []}, "scene"),
        ("plans", {"plans": [{"scene": "nowhere", "status": "found"}]}, "scene"),
        ("plans", {"scene": "0000", "status": "found", "points": [[1, "x"]]}, "points"),
        ("accuracy", {"field": {"seen": {"careful": {"n": 3}}}}, "accuracy"),
        ("accuracy", {"field": 3}, "field"),
        ("audit", {"demonstrations": 3}, "audit.json"),
        ("audit", {"demonstrations": [{"verdict": "pass"}]}, "demo_id"),
        ("query", {"careful": {"points": []}}, "status"),
        ("repairs", {"repairs": [{"demo_id": "x", "p_valid": 1, "moved": 1}]}, "demo_id"),
        ("repairs", {"field": {"seen": {"careful": {"vacuous": True}}}}, "n"),
        ("run", {"stages": {"set": {"seconds": "long"}}}, "seconds"),
        ("causes", {"effects": 3}, "causes.json"),
        ("rules", {"types": {"me": {"clearance": {"value": {"glass": "x"}}}}}, "glass"),
        ("accuracy-uniform", {"rows": [{"model": "x"}]}, "type"),
    ],
)  # fmt: skip
def test_a_damaged_document_is_refused_with_its_file_and_field(
    folder: Path, tmp_path: Path, name: str, content: Any, place: str
) -> None:
    own = tmp_path / "run"
    shutil.copytree(folder, own)
    (own / f"{name}.json").write_text(json.dumps(content))
    with pytest.raises(InputError) as refused:
        read_run(own)
    assert f"{name}.json" in str(refused.value)
    assert place in str(refused.value)


def test_evidence_that_is_damaged_is_refused_too(run: Run) -> None:
    assert run.rules is not None
    rules = replace(run.rules.rules["careful"], evidence={"n": "many"})
    with pytest.raises(InputError, match="evidence"):
        build_report(replace(run, rules=RuleSet({"careful": rules})))


def test_a_model_has_one_look_wherever_it_is_shown() -> None:
    known = ("paper", "field", "truth", "autoencoder", "classifier", "irl")
    assert len({look_of(name)[0] for name in known}) == len(known)
    for others in (("paper", "field"), ("field", "paper"), ("irl", "paper")):
        assert look_of("paper", others) == look_of("paper")
    assert look_of("full") == look_of("paper")  # the same network, by its name among ablations
    own = ("mine", "field", "yours")
    assert look_of("mine", own) != look_of("yours", own)


def test_curves_rise_with_accuracy_and_leave_out_types_of_one_class(
    folder: Path, tmp_path: Path
) -> None:
    from demospec.report.pictures._accuracy import points_of_curve

    rows = [
        {"model": model, "type": kind, "n": n, "fits": 3, "majority_seen": 0.6,
         "bacc_seen": None if kind == "bold" else share, "bacc_unseen": None}
        for model in ("full", "irl") for kind in ("careful", "bold")
        for n, share in ((16, 0.9), (1, 0.6), (4, 0.7))
    ]  # fmt: skip
    own = tmp_path / "run"
    shutil.copytree(folder, own)
    write_json(own / "accuracy-uniform.json", {"reading": "uniform", "rows": rows})
    run = read_run(own)
    (curve,) = run.curves.values()
    assert points_of_curve(curve, "irl", "careful", "seen") == [(1, 60), (4, 70), (16, 90)]
    assert points_of_curve(curve, "irl", "bold", "seen") == []
    section = next(s for s in build_report(run).sections if s.anchor == "accuracy")
    assert any("uniform draws" in getattr(b, "words", "") for b in section.blocks)


def test_names_from_files_are_text(made: tuple[DemonstrationSet, RuleSet]) -> None:
    data, rules = made
    d = data.demonstrations
    scenes = tuple(
        replace(s, objects=tuple(replace(o, id=EVIL + o.id) for o in s.listed_objects()))
        for s in data.scenes
    )
    some = d.rows([0, 1])
    some.type[:] = some.demonstrator[:] = EVIL
    evil = replace(data, scenes=scenes, name=EVIL, types=(EVIL,), demonstrations=some)
    said = replace(rules.rules["careful"], sentence=EVIL)
    page = render_html(build_report(Run(evil, rules=RuleSet({EVIL: said}))))
    assert "<img src=x" not in page
    assert "<script" not in page
    assert page.count("<style>") == page.count("</style>") == 3


def test_one_unit_is_used_for_people_who_know_the_scale(
    made: tuple[DemonstrationSet, RuleSet],
) -> None:
    data, rules = made
    report = build_report(Run(data, rules=rules))
    assert report.people[0].picture is not None
    assert " cm</text>" in report.people[0].picture.svg
    unknown = replace(data, metres_per_unit=None)
    report = build_report(Run(unknown, rules=rules))
    assert report.people[0].picture is not None
    assert " px</text>" in report.people[0].picture.svg


@pytest.mark.browser
def test_folded_parts_open_print_and_are_accessible(
    folder: Path, tmp_path: Path, chromium_page: Callable[..., Any]
) -> None:
    base = pytest.importorskip("axe_playwright_python.base")
    write_html(build_report(folder), tmp_path / "report.html")
    for scheme in ("light", "dark"):
        page = chromium_page(width=390, color_scheme=scheme)
        page.goto((tmp_path / "report.html").as_uri() + "#sure")
        assert page.locator("#sure").is_visible()  # a link opens what it leads to
        assert not page.locator("#shown").is_visible()
        page.emulate_media(media="print", color_scheme=scheme)
        tall = "document.querySelector('#shown').getBoundingClientRect().height"
        assert page.evaluate(tall) > 100
        page.emulate_media(media="screen", color_scheme=scheme)
        page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.evaluate(Path(base.AXE_FILE_PATH).read_text(encoding="utf-8"))
        found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
        assert [(v["id"], [n["html"][:120] for n in v["nodes"]]) for v in found] == []


def test_a_large_picture_travels_as_jpeg() -> None:
    from demospec.report import data_url
    from demospec.scene import Picture, Scene

    small, large = (
        Scene("a", (0, 0), (9, 9), None, Picture(array=np.zeros((n, n, 3), np.uint8)))
        for n in (40, 900)
    )
    assert data_url(small).startswith("data:image/png")
    assert data_url(large).startswith("data:image/jpeg")
