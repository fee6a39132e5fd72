"""What nothing is known about is let be, listed, and never called kept; bad rules are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, write_set
from demospec.errors import InputError
from demospec.geometry import path_distance
from demospec.planning import plan_path
from demospec.rules import learn_rules, read_rules, rules_document, rules_in_unit
from demospec.scene import Disc, Picture, Scene, SceneObject

GLASS = SceneObject("glass-0", "glass", (50.0, 20.0), None, Disc((50.0, 20.0), 5.0))
LAPTOP = SceneObject("laptop-0", "laptop", (50.0, 60.0), None, Disc((50.0, 60.0), 4.0))
TABLE = Scene("t", (0.0, 60.0), (100.0, 60.0), objects=(GLASS,))
NEW = Scene("t", (0.0, 60.0), (100.0, 60.0), objects=(GLASS, LAPTOP))
HEIGHTS = np.array([18.0, 22.0, 25.0, 27.0, 29.0, 33.0, 35.0, 40.0, 45.0, 50.0, 55.0, 65.0])


def taught(valid: np.ndarray, heights: np.ndarray = HEIGHTS) -> DemonstrationSet:
    items = [
        Demonstration(f"d{i}", "t", np.array([[0.0, y], [100.0, y]]), type="me", valid=bool(ok))
        for i, (y, ok) in enumerate(zip(heights, valid, strict=True))
    ]
    return DemonstrationSet(
        (TABLE,),
        Demonstrations.of(items),
        metres_per_unit=0.01,
        symbols=("glass",),
        types=("me",),
    )


def careful() -> DemonstrationSet:
    return taught(HEIGHTS >= 31.0)


def coin() -> DemonstrationSet:
    rng = np.random.default_rng(0)
    return taught(rng.random(60) < 0.5, np.linspace(15.0, 75.0, 60))


def test_a_plan_keeps_the_largest_known_clearance_from_what_it_does_not_know() -> None:
    rules = learn_rules(careful(), influence=False)
    plan = plan_path(rules, NEW, "me")
    assert plan.uninformed == ("laptop-0",)
    assert plan.unknown_clearance is not None
    known = rules.rules["me"].clearance
    assert known is not None
    assert plan.unknown_clearance >= max(known.value.values())
    assert path_distance(LAPTOP.outline, plan.points)[0] >= plan.unknown_clearance - 1e-6
    assert plan.to_json()["unknown"] == ["laptop-0"]
    assert plan.to_json()["obeys"] is True
    wide = plan_path(rules, NEW, "me", unknown_clearance=12.0)
    assert path_distance(LAPTOP.outline, wide.points)[0] >= 12.0 - 1e-6


def test_a_default_clearance_gives_way_where_it_leaves_none() -> None:
    rules = learn_rules(careful(), influence=False)
    walls = tuple(
        SceneObject(f"wall-{i}", "wall", (50.0, y), None, Disc((50.0, y), 4.0))
        for i, y in enumerate(np.arange(5.0, 80.0, 10.0))
    )
    picture = Picture(array=np.zeros((80, 100, 3), dtype=np.uint8))
    tight = NEW.with_changes(objects=walls, picture=picture)
    through = plan_path(rules, tight, "me", unknown_clearance=20.0)
    assert through.found
    assert through.unknown_clearance is None


def test_nothing_rejected_decides_nothing() -> None:
    rules = learn_rules(taught(np.ones(12, dtype=bool)), influence=False)
    assert plan_path(rules, NEW, "me").to_json()["obeys"] is None


def test_a_rule_that_explains_nothing_is_refused_unless_asked_for() -> None:
    rules = learn_rules(coin(), influence=False)
    with pytest.raises(InputError, match="explains the answers"):
        plan_path(rules, TABLE, "me")
    assert plan_path(rules, TABLE, "me", anyway=True).found


@pytest.mark.parametrize(
    "command", [("plan", "--scene", "t"), ("export", "--scene", "t", "--to", "json"),
                ("sample", "--scene", "t", "--type", "me"), ("repair", "--type", "me")],
)  # fmt: skip
def test_commands_refuse_it_in_one_line(
    command: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = coin()
    write_set(data, tmp_path / "set")
    document = rules_document(learn_rules(data, influence=False))
    (tmp_path / "r.json").write_text(json.dumps(document))
    name, *options = command
    arguments = [name, str(tmp_path / "r.json"), str(tmp_path / "set"), *options,
                 "--out", str(tmp_path / "out.json")]  # fmt: skip
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "--anyway" in line
    assert not (tmp_path / "out.json").exists()
    with pytest.raises(SystemExit) as stop:
        main([*arguments, "--anyway"])
    assert not stop.value.code


def test_rules_in_metres_are_not_taken_for_pixels(tmp_path: Path) -> None:
    file = tmp_path / "r.json"
    rule = {"clearance": {"value": {"glass": 0.03}, "interval": {"glass": [0.02, 0.04]}}}
    file.write_text(json.dumps({"types": {"me": rule}, "units": "m"}))
    rules = rules_in_unit(read_rules(file), "px", 0.005)
    clearance = rules.rules["me"].clearance
    assert clearance is not None
    assert clearance.value["glass"] == pytest.approx(6.0)
    assert clearance.interval["glass"] == pytest.approx((4.0, 8.0))
    with pytest.raises(InputError, match="units"):
        rules_in_unit(read_rules(file), "px", None)
    file.write_text(json.dumps({"types": {"me": rule}}))
    unnamed = rules_in_unit(read_rules(file), "px", None).rules["me"].clearance
    assert unnamed is not None
    assert unnamed.value["glass"] == 0.03


def test_pixels_of_another_picture_go_through_metres() -> None:
    rules = learn_rules(careful(), influence=False)
    small = rules_in_unit(rules, "px", None)
    assert small.rules["me"] == rules.rules["me"]  # no scale on one side: pixels are pixels
    known = rules_in_unit(rules, "px", 0.001).rules["me"]
    before = rules.rules["me"].clearance
    assert before is not None
    assert known.clearance is not None
    assert known.clearance.value["glass"] == pytest.approx(10 * before.value["glass"])
    assert known.evidence["at_most"]["glass"] == pytest.approx(
        10 * rules.rules["me"].evidence["at_most"]["glass"]
    )
