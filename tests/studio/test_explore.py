"""What the Explore page answers: exact verdicts, faithful maps, edits that are seen."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet, simulate_set
from demospec.errors import InputError
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Capsule, Disc, Footprint, Polygon, Scene, SceneObject
from demospec.specification import ValidityMap, validity_map
from demospec.studio.explore._answers import look, mend, outline_path, put_down, solutions
from demospec.studio.explore._map import boundary_path, explore_map
from demospec.studio.explore._state import Edits, Explorer, NoPlace, Question, path_of


@pytest.fixture(scope="module")
def made() -> tuple[DemonstrationSet, RuleSet]:
    data, truth = simulate_set(train_scenes=3, test_scenes=1, demonstrations=4, seed=3)
    return data, rules_from_document(truth)


@pytest.fixture(scope="module")
def explorer(made: tuple[DemonstrationSet, RuleSet]) -> Explorer:
    data, rule = made
    return Explorer(
        data.scenes, {"truth": rule}, data.demonstrations, truth="truth",
        metres_per_unit=data.metres_per_unit,
    )  # fmt: skip


def question(explorer: Explorer, type: str = "careful", **more: Any) -> Question:
    scene = next(iter(explorer.scenes))
    control = more.pop("control", explorer.first_control(scene, type))
    return Question(scene, "truth", type, control, **more)


@pytest.mark.parametrize("type", ["careful", "normal", "aggressive"])
def test_the_quick_map_agrees_with_the_exact_one_away_from_the_boundary(
    made: tuple[DemonstrationSet, RuleSet], type: str
) -> None:
    data, rule = made
    for scene in data.scenes[:2]:
        view = rule.see(scene)
        quick, exact = explore_map(view, type, 21).accepted, validity_map(view, type, size=21)
        differs = (quick.logits >= 0) != (exact.logits > 0)
        # Half a pixel of margin: 50 points of the exact map miss more than the quick one.
        assert not differs[np.abs(exact.logits) > 0.5].any()
        assert differs.mean() < 0.01


def inside(d: str, x: float, y: float) -> bool:
    """Even-odd test of a point against an SVG path of straight lines."""
    crossed = False
    for part in d.split("Z"):
        corners = [tuple(map(float, p.split())) for p in part.removeprefix("M").split("L") if p]
        for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
            if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
                crossed = not crossed
    return crossed


def test_the_drawn_region_holds_exactly_the_accepted_cells(
    made: tuple[DemonstrationSet, RuleSet],
) -> None:
    data, rule = made
    found = explore_map(rule.see(data.scenes[0]), "careful", 21).accepted
    d = boundary_path(found)
    assert 0 < found.valid_share < 1
    for i in range(1, 20):
        for j in range(1, 20):
            if abs(found.logits[i, j]) > 0.3:
                assert inside(d, found.x[j], found.y[i]) == (found.logits[i, j] > 0)


def test_a_region_with_a_hole_keeps_its_hole() -> None:
    x = np.linspace(0.0, 10.0, 41)
    radius = np.hypot(*np.meshgrid(x - 5, x - 5))
    logits = np.where(radius < 2, radius - 2, 1.0) * 3 + 0.01
    ring = ValidityMap("t", x, x, logits, (logits > 0) * 1.0, (0, 0), (9, 9))
    d = boundary_path(ring)
    assert d.count("M") == 2
    assert inside(d, 0.5, 0.5)
    assert not inside(d, 5.0, 5.0)


def test_verdicts_are_those_of_the_rule_on_the_path(
    explorer: Explorer, made: tuple[DemonstrationSet, RuleSet]
) -> None:
    rng = np.random.default_rng(0)
    for control in rng.uniform(0, 100, (8, 2)):
        asked = question(explorer, control=(float(control[0]), float(control[1])))
        scene = explorer.scenes[asked.scene_id]
        path = path_of(scene, asked.control)
        for said in look(explorer, asked)["verdicts"]:
            clearance = made[1].of_type(said["type"]).clearance
            assert clearance is not None
            kept = clearance.margins(scene, path[None])[0] >= 0
            assert said["verdict"] == ("accept" if kept else "reject")


def test_moving_the_offending_object_away_frees_the_path(explorer: Explorer) -> None:
    asked = question(explorer)
    before = look(explorer, asked)
    assert not before["why"]["valid"]
    scene = explorer.scenes[asked.scene_id]
    corner = Edits({item.id: (95.0, 95.0) for item in scene.listed_objects()})
    after = look(explorer, question(explorer, edits=corner))
    assert after["why"]["valid"]
    assert after["map"]["region"] != before["map"]["region"]
    assert after["map"]["share"] > before["map"]["share"]
    assert after["scene"]["picture"] != before["scene"]["picture"]
    assert look(explorer, question(explorer))["scene"]["picture"] == before["scene"]["picture"]


def test_a_removed_object_leaves_list_and_picture(explorer: Explorer) -> None:
    asked = question(explorer)
    names = [o.id for o in explorer.scenes[asked.scene_id].listed_objects()]
    gone = question(explorer, edits=Edits(removed=(names[0],)))
    found = look(explorer, gone)["scene"]
    assert [o["id"] for o in found["objects"]] == names[1:]
    assert found["picture"] != look(explorer, asked)["scene"]["picture"]


def test_what_is_put_down_lowers_what_careful_accepts_and_nothing_of_aggressive(
    explorer: Explorer,
) -> None:
    asked = question(explorer)
    thing = put_down(explorer, asked, "plate")
    more = question(explorer, edits=Edits(added=((thing["symbol"], thing["x"], thing["y"]),)))
    found = look(explorer, more)
    now = {v["type"]: v["share"] for v in found["verdicts"]}
    then = {v["type"]: v["share"] for v in found["before"]["verdicts"]}
    assert now["careful"] < then["careful"]
    assert now["aggressive"] == then["aggressive"] == 1.0
    assert now["normal"] == then["normal"]  # a plate is no glass
    assert [o["added"] for o in found["scene"]["objects"]][-1] == 0
    assert len(found["before"]["scene"]["objects"]) == len(found["scene"]["objects"]) - 1


def test_a_repair_ends_valid_and_near(explorer: Explorer) -> None:
    asked = question(explorer)
    found = mend(explorer, asked)
    assert found["holds"]
    assert found["true_valid"] is True
    assert found["steps"][0] == pytest.approx(asked.control, abs=1e-3)
    assert found["steps"][-1] == pytest.approx(found["control"], abs=1e-3)
    # The curve of order 2 moves half as far as its control point.
    assert found["moved"] == pytest.approx(found["control_moved"] / 2, rel=0.01)
    after = look(explorer, question(explorer, control=tuple(found["control"])))
    assert after["why"]["valid"]


def test_solutions_are_valid_and_come_from_every_region(explorer: Explorer) -> None:
    found = solutions(explorer, question(explorer), 12)
    assert len(found["paths"]) == 12
    assert {p["mode"] for p in found["paths"]} == set(range(min(found["modes"], 12)))
    assert all(p["true_valid"] for p in found["paths"])


def test_a_scene_without_a_picture_is_explored_from_its_list() -> None:
    items = tuple(
        SceneObject(f"glass-{i}", "glass", (x, 50.0), None, Disc((x, 50.0), 5.0))
        for i, x in enumerate((40.0, 60.0))
    )
    scene = Scene("a", (0.0, 50.0), (100.0, 50.0), items)
    rule = rules_from_document(
        {"types": {"t": {"clearance": {"relevant": ["glass"], "value": {"glass": 3.0}}}}}
    )
    explorer = Explorer([scene], {"r": rule})
    found = look(explorer, Question("a", "r", "t", (50.0, 50.0)))
    assert not found["why"]["valid"]
    assert found["scene"]["picture"] is None
    moved = Edits({"glass-0": (40.0, 90.0), "glass-1": (60.0, 90.0)})
    assert look(explorer, Question("a", "r", "t", (50.0, 50.0), moved))["why"]["valid"]


@pytest.fixture(scope="module")
def taught(made: tuple[DemonstrationSet, RuleSet]) -> Explorer:
    """Rules learned from two classes only: about plates nothing was shown."""
    from demospec.rules import learn_rules

    data, _ = made
    rules = learn_rules(data, split=None, influence=False)
    return Explorer(data.scenes, {"rules": rules}, data.demonstrations)


def test_three_verdicts_are_those_of_the_rule_and_of_its_map(
    taught: Explorer, made: tuple[DemonstrationSet, RuleSet]
) -> None:
    rng = np.random.default_rng(1)
    rules = taught.models["rules"]
    said = set()
    for scene in made[0].scenes[:2]:
        view = rules.see(scene)
        for kind in ("careful", "normal"):
            found = explore_map(view, kind, 21)
            assert 0 <= found.share <= found.share + found.unknown <= 1
            for i, j in rng.integers(0, 21, (25, 2)):
                control = (float(found.accepted.x[i]), float(found.accepted.y[j]))
                asked = Question(scene.scene_id, "rules", kind, control)
                answer = look(taught, asked, has="")
                verdict = next(v for v in answer["verdicts"] if v["type"] == kind)["verdict"]
                path = path_of(scene, control)
                assert verdict == view.verdicts(path[None], kind)[0]
                accept, reject = found.accepted.logits[j, i], -found.possible.logits[j, i]
                if min(abs(accept), abs(reject)) > 0.5:
                    drawn = "accept" if accept > 0 else "reject" if reject > 0 else "unknown"
                    assert drawn == verdict
                said.add(verdict)
                if verdict == "unknown":
                    assert answer["why"]["sentence"].startswith("Not known")
    assert said == {"accept", "reject", "unknown"}


def test_what_does_not_matter_never_decides(made: tuple[DemonstrationSet, RuleSet]) -> None:
    """Explore named the nearest object, whether the rule speaks of it or not."""
    data, truth = made
    explorer = Explorer(data.scenes, {"truth": truth}, metres_per_unit=data.metres_per_unit)
    for scene in data.scenes:
        for kind in ("normal", "aggressive"):
            rule = truth.of_type(kind).clearance
            assert rule is not None
            for control in ((50.0, 50.0), (20.0, 30.0), (80.0, 90.0)):
                why = look(explorer, Question(scene.scene_id, "truth", kind, control))["why"]
                assert why["symbol"] is None or why["symbol"] in rule.relevant
                if why["symbol"] is None:
                    assert "nothing that is listed here is known to matter" in why["sentence"]


def test_what_has_no_place_is_known_beforehand(explorer: Explorer) -> None:
    scene = next(iter(explorer.scenes))
    assert explorer.fits(scene, "glass")
    crowd = tuple(
        SceneObject(f"plate-{i}-{j}", "plate", (float(x), float(y)), None, Disc((x, y), 9.0))
        for i, x in enumerate(range(5, 100, 15)) for j, y in enumerate(range(5, 100, 15))
    )  # fmt: skip
    full = replace(explorer.scenes[scene], objects=crowd, picture=None, recipe=None)
    packed = Explorer([full], explorer.models)
    assert not packed.fits(scene, "plate")
    with pytest.raises(NoPlace, match="There is no free place for another plate here"):
        put_down(packed, Question(scene, "truth", "careful", (50.0, 50.0)), "plate")


@pytest.mark.parametrize(
    "document",
    [
        [],
        {},
        {"scene": "a", "model": "r", "type": "t", "control": ["x", 1]},
        {"scene": "a", "model": "r", "type": "t", "control": [float("nan"), 1]},
        {"scene": "a", "model": "r", "type": "t", "control": [1, 2], "moved": {"g": [1]}},
        {"scene": "a", "model": "r", "type": "t", "control": [1, 2], "added": [{"x": 1, "y": 2}]},
        {"scene": "a", "model": "r", "type": "t", "control": [1, 2], "removed": ["g"] * 99},
    ],
)
def test_bad_requests_are_refused_in_words(document: Any) -> None:
    with pytest.raises(InputError, match="expected"):
        Question.from_json(document)


def test_unknown_names_are_answered_with_the_known_ones(explorer: Explorer) -> None:
    for change in ({"model": "x"}, {"type": "x"}, {"scene": "x"}):
        asked = {"scene": "0000", "model": "truth", "type": "careful", "control": [1, 2], **change}
        with pytest.raises(InputError, match="expected"):
            look(explorer, Question.from_json(asked))


@pytest.mark.parametrize(
    "shape",
    [
        Disc((50.0, 40.0), 6.0),
        Capsule((30.0, 30.0), (60.0, 45.0), 4.0),
        Polygon(np.array([[10.0, 10.0], [30.0, 12.0], [20.0, 30.0]])),
    ],
)
def test_outlines_are_closed_paths(shape: Footprint) -> None:
    d = outline_path(shape)
    assert d.startswith("M")
    assert d.endswith("Z")
    if isinstance(shape, Capsule):
        rng = np.random.default_rng(1)
        for x, y in rng.uniform(15, 75, (200, 2)):
            gap = float(shape.signed_distance(np.array([x, y])))
            if abs(gap) > 0.3:
                assert inside(d, x, y) == (gap < 0)
