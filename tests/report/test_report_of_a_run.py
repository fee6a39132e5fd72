"""The report of a person's own run: some documents, no truth; page and Markdown say the same."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from demospec.cli import main
from demospec.demonstrations import read_set, simulate_set, write_set
from demospec.files import read_json, write_json
from demospec.frames import describe_length
from demospec.report import (
    Figure,
    Lines,
    Report,
    Section,
    Table,
    Text,
    build_report,
    render_html,
    share,
    wilson,
    write_html,
    write_markdown,
)
from demospec.rules import learn_rules, rules_document

METRES = 0.0082
"""Of a unit of simulated sets."""


def table_length(tried: list[dict[str, float]]) -> str:
    return describe_length(sum(r["moved"] for r in tried) / len(tried), METRES)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A set and its rules, and nothing else: no model, no truth, no record."""
    folder = tmp_path_factory.mktemp("own") / "run"
    data, _ = simulate_set(train_scenes=4, test_scenes=1, demonstrations=5, seed=3)
    write_set(data, folder / "set")
    write_json(folder / "rules.json", rules_document(learn_rules(data.of_split("train"))))
    return folder


class _Cells(HTMLParser):
    """The text of every table cell, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.cells: list[str] = []
        self.inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("td", "th"):
            self.inside = True
            self.cells.append("")

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th"):
            self.inside = False

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.cells[-1] += data


def test_a_set_and_rules_are_enough(run: Path) -> None:
    report = build_report(run)
    assert [s.anchor for s in report.sections] == ["shown", "cares", "sure", "computed"]
    rules = read_json(run / "rules.json")["types"]
    sure = next(s for s in report.sections if s.anchor == "sure")
    table = next(b for b in sure.blocks if isinstance(b, Table))
    told = {(row[0], row[1]): row[2] for row in table.rows}
    for type_, rule in rules.items():
        for symbol, value in rule["clearance"]["value"].items():
            if symbol in rule["clearance"]["relevant"]:
                ends = [math.inf if v is None else v for v in rule["clearance"]["interval"][symbol]]
                words = describe_length(value, METRES, interval=(ends[0], ends[1]))
                assert told[type_, symbol] == words
    assert any(rule["sentence"] in s for rule in rules.values() for s in report.summary)


def test_thresholds_that_a_bound_has_set_are_marked(run: Path) -> None:
    report = build_report(run)
    sure = next(s for s in report.sections if s.anchor == "sure")
    table = next(b for b in sure.blocks if isinstance(b, Table) and "paper's rule" in b.caption)
    cells = {(row[0], row[1]): row[2:] for row in table.rows}
    marked = 0
    for type_, rule in read_json(run / "rules.json")["types"].items():
        answer = rule["influence"]
        if answer is None or answer["hull"] is None:
            continue
        for name, (low, high) in answer["hull"]["radius"].items():
            least, most, both = cells[type_, f"radius of {name}"]
            assert both == f"{low} – {high}"
            for end, cell in (("min", least), ("max", most)):
                value = answer[end]["T_min"] + answer[end]["T_object"][name]
                bound = name in answer[f"saturated_{end}"]
                marked += bound
                assert cell == f"{value} †" if bound else cell == str(value)
    assert marked
    assert "set by the bound, not by data" in table.note


def test_a_known_truth_is_told_and_an_unknown_one_is_not(run: Path, tmp_path: Path) -> None:
    import shutil

    assert "simulated" not in render_html(build_report(run))
    own = tmp_path / "run"
    shutil.copytree(run, own)
    _, truth = simulate_set(train_scenes=4, test_scenes=1, demonstrations=5, seed=3)
    write_json(own / "set" / "truth.json", truth)
    words = [b.words for b in build_report(own).sections[0].blocks if isinstance(b, Text)]
    assert "careful keeps" in words[1]
    assert "2.5 cm" in words[1]
    assert "from utensils, plates, bowls and glasses; normal keeps" in words[1]


def test_page_and_markdown_hold_the_same_cells_and_words(run: Path, tmp_path: Path) -> None:
    report = build_report(run)
    page = _Cells()
    page.feed(render_html(report))
    lines = write_markdown(report, tmp_path / "md").read_text(encoding="utf-8").splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")]
    cells = [cell.strip("*") for row in rows for cell in row]
    assert cells == page.cells
    every = [b for s in report.sections for b in s.blocks]
    words = [b.words for b in every if isinstance(b, Text)]
    words += [w for b in every if isinstance(b, Lines) for w in b.sentences]
    assert words
    told = [line.replace("\u00a0", " ") for line in lines]
    assert all(any(w.replace("\u00a0", " ") in line for line in told) for w in words)
    assert not any(" %" in line for line in lines)  # no line may end between number and sign


def test_sentences_stand_below_each_other_and_intervals_stay_whole() -> None:
    blocks = (
        Lines(("One & only.", "Two.")),
        Table(("share",), (("50.0 % [40.0,\u00a060.0], n = 9",), ("none",))),
    )
    page = render_html(Report("t", "s", (), (Section("a", "A", blocks),)))
    assert re.findall("<li>(.*?)</li>", page) == ["One &amp; only.", "Two."]
    assert '<td>50.0\u00a0% <span class="ends">[40.0,\u00a060.0], n = 9</span></td>' in page
    assert "<td>none</td>" in page


@pytest.mark.parametrize("dpi", [75, 150])
def test_letters_of_a_picture_keep_their_size_whatever_its_resolution(dpi: int) -> None:
    from matplotlib.figure import Figure as Drawn

    from demospec.report.pictures._scene import to_png

    drawn = Drawn(figsize=(5, 2))
    drawn.add_axes((0, 0, 1, 1)).set_axis_off()
    picture = Figure(to_png(drawn, dpi=dpi), "c", "a")
    page = render_html(Report("t", "s", (), (Section("a", "A", (picture,)),)))
    width = re.search(r'width="(\d+)"', page)
    assert width
    assert 480 <= int(width.group(1)) <= 490  # five inches of 96 CSS pixels, and a margin


def test_accepted_shares_have_n_and_interval(run: Path) -> None:
    shown = build_report(run).sections[0]
    table = next(b for b in shown.blocks if isinstance(b, Table))
    for row in table.rows:
        assert re.fullmatch(r"[\d.]+ % \[[\d.]+,\s[\d.]+\], n\s=\s25", row[4])


@pytest.mark.parametrize(
    ("hits", "n", "low", "high"),
    # Newcombe 1998, table I, method 3 (score without continuity correction).
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611),
     (1, 29, 0.0061, 0.1718)],
)  # fmt: skip
def test_intervals_of_shares_are_wilsons(hits: int, n: int, low: float, high: float) -> None:
    assert wilson(hits, n) == pytest.approx((low, high), abs=5e-5)
    assert wilson(n - hits, n) == pytest.approx((1 - high, 1 - low), abs=5e-5)


def test_nothing_tried_is_a_dash() -> None:
    assert share(0, 0) == "–"


def test_causes_of_one_model_and_one_question(run: Path, tmp_path: Path) -> None:
    """What `demospec causes --out` and `demospec query --out` wrote is read as it is."""
    import shutil

    from demospec.causal import Settings, find_causes
    from demospec.demonstrations import read_set
    from demospec.rules import query_set, read_rules

    own = tmp_path / "run"
    shutil.copytree(run, own)
    data = read_set(own / "set")
    found = find_causes(
        read_rules(own / "rules.json"), data.scenes, settings=Settings(draws=20, placements=1)
    )
    write_json(own / "causes.json", found.to_json())
    write_json(own / "query.json", query_set(data.of_split("train"), type="normal").to_json())
    report = build_report(own)
    cares = next(s for s in report.sections if s.anchor == "cares")
    table = next(b for b in cares.blocks if isinstance(b, Table))
    assert "n = 5 scenes" in table.caption
    assert table.header[2] == "the given model"
    for row in table.rows:  # every number has its interval, the placebo too
        assert all(re.fullmatch(r"-?[\d.]+ \[-?[\d.]+,\s-?[\d.]+\]", cell) for cell in row[2:])


@pytest.mark.browser
def test_the_page_asks_nothing_of_a_network_and_fits_a_phone(
    run: Path, tmp_path: Path, chromium_page: Callable[..., Any]
) -> None:
    write_html(build_report(run), tmp_path / "report.html")
    page = chromium_page(width=390)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    wrong: list[str] = []
    page.on("console", lambda message: wrong.append(message.text))
    page.goto((tmp_path / "report.html").as_uri())
    assert [u for u in asked if not u.startswith(("file:", "data:"))] == []
    assert wrong == []
    broken = "[...document.images].filter(i => !i.naturalWidth).length"
    assert page.evaluate(broken) == 0
    assert page.evaluate("document.images.length") >= 1
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_the_command_writes_markdown_beside_the_run(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["report", str(run), "--markdown", "--out", str(tmp_path / "md")])
    assert not stop.value.code
    assert capsys.readouterr().out.strip() == str((tmp_path / "md" / "report.md").resolve())
    text = (tmp_path / "md" / "report.md").read_text(encoding="utf-8")
    for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text):
        assert (tmp_path / "md" / name).is_file()


def test_documents_of_single_commands_are_read(run: Path, tmp_path: Path) -> None:
    """`plan`, `evaluate` and `repair` with --out, as a person would gather them."""
    import shutil

    own = tmp_path / "run"
    shutil.copytree(run, own)
    rules, data = str(own / "rules.json"), str(own / "set")
    for name, arguments in {
        "plans": ["plan", rules, data, "--scene", "0004", "--type", "normal"],
        "accuracy": ["evaluate", rules, data],
        "repairs": ["repair", rules, data, "--type", "careful"],
    }.items():
        with pytest.raises(SystemExit) as stop:
            main([*arguments, "--out", str(own / f"{name}.json")])
        assert not stop.value.code
    report = build_report(own)
    tables = {s.anchor: [b for b in s.blocks if isinstance(b, Table)] for s in report.sections}
    scores = read_json(own / "accuracy.json")["types"]
    assert [row[2:4] for row in tables["accuracy"][0].rows] == [
        (type_, str(score["n"])) for type_, score in scores.items()
    ]
    tried = read_json(own / "repairs.json")["repairs"]
    row = tables["repairs"][0].rows[0]
    believed = sum(r["p_valid"] > 0.5 for r in tried) / len(tried)
    assert row[2:] == (
        "careful", "not judged", f"{100 * believed:.1f} %", table_length(tried),
    )  # fmt: skip
    found = read_json(own / "plans.json")
    assert tables["plans"][0].rows[0][:3] == ("normal", "1", str(int(found["status"] == "found")))
    fate = "found; it keeps the learned rule" if found["obeys"] else "none found"
    assert report.summary[-1] == f"1 plan: {fate}."


def test_doubtful_demonstrations_are_shown(run: Path, tmp_path: Path) -> None:
    """Two of the set, and one that the set no longer has."""
    import shutil

    own = tmp_path / "run"
    shutil.copytree(run, own)
    names = [*read_set(own / "set").demonstrations.demo_id[:2], "gone"]
    audit = [{"demo_id": str(n), "verdict": "review", "why": "too near"} for n in names]
    write_json(own / "audit.json", {"conflict": None, "demonstrations": audit})
    section = next(s for s in build_report(own).sections if s.anchor == "doubts")
    (table,) = (b for b in section.blocks if isinstance(b, Table))
    assert [row[0] for row in table.rows] == names
    assert sum(isinstance(b, Figure) for b in section.blocks) == 1


def test_a_rule_by_hand_and_a_plan_where_nothing_is_listed(tmp_path: Path) -> None:
    """No sentence, no evidence, no objects, no type: the page says what there is."""
    from dataclasses import replace

    data, _ = simulate_set(train_scenes=2, test_scenes=0, demonstrations=2, seed=3)
    bare = tuple(replace(scene, objects=None) for scene in data.scenes)
    data.demonstrations.type[:] = None
    write_set(replace(data, scenes=bare, types=()), tmp_path / "set")
    by_hand = {"types": {"me": {"clearance": {"value": {"glass": 3.0, "plate": 3.0}}}}}
    write_json(tmp_path / "rules.json", by_hand)
    plan = {
        "scene_id": bare[0].scene_id, "type": "me", "status": "found", "obeys": True,
        "points": [list(bare[0].start), list(bare[0].goal)], "length": 113.0,
    }  # fmt: skip
    write_json(tmp_path / "plans.json", plan)
    report = build_report(tmp_path)
    assert report.summary[0].startswith("me: keeps")
    assert "from glasses and plates" in report.summary[0]
    assert [s.anchor for s in report.sections] == ["shown", "cares", "sure", "plans", "computed"]
    sure = next(s for s in report.sections if s.anchor == "sure")
    table = next(b for b in sure.blocks if isinstance(b, Table))
    assert table.rows[0][:3] == ("me", "glass", "2.5 cm")


def _own_plan(run: Path, folder: Path, judged_by: str) -> Path:
    """The run with one plan, as `demospec plan --out` writes it."""
    import shutil

    from demospec.planning import plan_path

    shutil.copytree(run, folder)
    learned = learn_rules(read_set(run / "set").of_split("train"))
    scene = read_set(run / "set").of_split("test").scenes[0]
    plan = plan_path(learned, scene, "normal")
    assert plan.found
    write_json(folder / "plans.json", {**plan.to_json(), "judged_by": judged_by})
    return folder


@pytest.mark.parametrize("judged_by", ["rule", "model"])
def test_a_plan_judged_by_its_own_model_is_said_to_be(
    run: Path, tmp_path: Path, judged_by: str
) -> None:
    report = build_report(_own_plan(run, tmp_path / "run", judged_by))
    section = next(s for s in report.sections if s.anchor == "plans")
    table = next(b for b in section.blocks if isinstance(b, Table))
    said = [words for words in (*report.summary, table.note) if "own reading" in words]
    assert len(said) == (2 if judged_by == "model" else 0)


def test_the_plan_picture_names_who_judged() -> None:
    from dataclasses import replace

    from demospec.planning import plan_path
    from demospec.report.pictures._plan import verdict

    data, _ = simulate_set(train_scenes=4, test_scenes=1, demonstrations=5, seed=3)
    plan = plan_path(learn_rules(data), data.scenes[0], "normal")
    assert verdict(plan) == "keeps the rule"
    assert "in the model's own opinion" in verdict(replace(plan, judged_by="model"))
