"""Footprints of several parts: exact distances, files, planning, drawing."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    read_set,
    write_set,
)
from demospec.errors import InputError
from demospec.geometry import (
    MultiPolygon,
    Polygon,
    nearest,
    path_distance,
    rectangle,
    rims,
    segment_distance,
    segments_keep,
    similar,
)
from demospec.planning import Plan, export_request, export_to, plan_path
from demospec.report import scene_svg
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Relation, Scene, SceneObject
from demospec.studio.explore._answers import outline_path

TWO = MultiPolygon([rectangle(0, 0, 10, 10), rectangle(30, 0, 10, 10)])
ABUTTING = MultiPolygon([rectangle(0, 0, 10, 10), rectangle(10, 0, 10, 10)])


PER_EDGE = 150


def sampled_rim(parts: list[Polygon]) -> np.ndarray:
    """Points of the parts' edges beside which something is in no part, (n, 2)."""
    angle = np.arange(16) * np.pi / 8 + 0.01
    around = 1e-6 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rim = np.concatenate(
        [
            a + (np.arange(PER_EDGE) + 0.5)[:, None] / PER_EDGE * (b - a)
            for part in parts
            for a, b in zip(part.vertices, np.roll(part.vertices, -1, axis=0), strict=True)
        ]
    )
    beside = rim[:, None] + around
    held = np.any([part.signed_distance(beside) <= 0 for part in parts], axis=0)
    return rim[~held.all(axis=1)]


boxes = st.builds(
    rectangle, st.integers(0, 20), st.integers(0, 20), st.integers(1, 15), st.integers(1, 15)
)
corners = st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20)), min_size=3, max_size=3)
triangles = corners.filter(
    lambda c: abs(np.linalg.det(np.array([np.subtract(c[1], c[0]), np.subtract(c[2], c[0])]))) > 5
).map(Polygon)


@settings(max_examples=40, deadline=None)
@given(st.lists(boxes | triangles, min_size=2, max_size=4), st.integers(0, 2**32 - 1))
def test_distance_is_that_to_the_rim_of_the_union(parts: list[Polygon], seed: int) -> None:
    shape = MultiPolygon(parts)
    points = np.random.default_rng(seed).uniform(-30, 45, (40, 2))
    found = shape.signed_distance(points)
    inside = np.any([part.signed_distance(points) < 0 for part in parts], axis=0)
    assert np.array_equal(found < 0, inside)
    rim = sampled_rim(parts)
    gap = np.hypot(*(points[:, None] - rim).transpose(2, 0, 1)).min(axis=1)
    step = (
        max(np.hypot(*(p.vertices - np.roll(p.vertices, 1, 0)).T).max() for p in parts) / PER_EDGE
    )
    assert (np.abs(np.abs(found) - gap) <= step + 1e-9).all()


def test_an_edge_between_parts_that_touch_is_no_rim() -> None:
    assert ABUTTING.signed_distance([10.0, 5.0]) == pytest.approx(-5.0)
    whole = rectangle(0, 0, 20, 10)
    points = np.random.default_rng(0).uniform(-10, 30, (200, 2))
    assert np.allclose(ABUTTING.signed_distance(points), whole.signed_distance(points))


def test_a_part_inside_another_adds_nothing() -> None:
    shape = MultiPolygon([rectangle(0, 0, 20, 20), rectangle(5, 5, 3, 3)])
    assert shape.signed_distance([6.0, 6.0]) == pytest.approx(-6.0)
    assert len(shape.edges[0]) == 4


def test_parts_far_from_the_origin_and_small() -> None:
    shape = MultiPolygon([rectangle(0, 0, 1e-3, 1e-3), rectangle(1e-3, 0, 1e-3, 1e-3)])
    assert shape.signed_distance([1e-3, 5e-4]) == pytest.approx(-5e-4)
    far = MultiPolygon([rectangle(1e6, 0, 1, 1), rectangle(1e6 + 1, 0, 1, 1)])
    assert far.signed_distance([1e6 + 1, 0.5]) == pytest.approx(-0.5)


def test_segments_and_gradients_see_every_part() -> None:
    a, b = np.array([[5.0, 20.0], [20.0, 20.0]]), np.array([[5.0, 15.0], [35.0, -5.0]])
    gaps = segment_distance(TWO, a, b)
    assert gaps[0] == pytest.approx(5.0)
    assert gaps[1] < 0  # it crosses the second part
    assert segments_keep(TWO, a[:1], b[:1], 5.0).tolist() == [True]
    assert segments_keep(TWO, a, b, 1.0).tolist() == [True, False]
    assert path_distance(TWO, np.array([[20.0, 20.0], [20.0, 5.0]]))[0] == pytest.approx(10.0)
    points = np.random.default_rng(1).uniform(-10, 50, (60, 2))
    gap, slope = nearest(TWO, points)
    assert np.allclose(gap, TWO.signed_distance(points))
    ahead = TWO.signed_distance(points + 1e-6 * slope)
    assert np.allclose((ahead - gap) / 1e-6, 1.0, atol=1e-4)


def test_segments_never_come_nearer_than_sampled() -> None:
    rng = np.random.default_rng(5)
    shape = MultiPolygon([rectangle(0, 0, 12, 8), rectangle(8, 4, 12, 12)])
    a, b = rng.uniform(-10, 30, (2, 50, 2))
    u = np.linspace(0, 1, 2001)[:, None, None]
    sampled = shape.signed_distance(a * (1 - u) + b * u).min(axis=0)
    found = segment_distance(shape, a, b)
    outside = sampled > 0
    assert (found[outside] <= sampled[outside] + 1e-9).all()
    assert (found[outside] >= sampled[outside] - 0.02).all()
    assert (found[~outside] <= 0).all()


def test_moved_turned_and_mirrored() -> None:
    assert TWO.moved((1, 2)).bounds == (1, 2, 41, 12)
    turned = similar(TWO, [[0, -1], [1, 0]], [100, 0])
    assert turned.bounds == pytest.approx((90, 0, 100, 40))
    assert len(rims(turned)) == 2
    points = np.random.default_rng(2).uniform(-10, 50, (50, 2))
    at = points @ np.array([[0, -1], [1, 0]]).T + [100, 0]
    assert np.allclose(turned.signed_distance(at), TWO.signed_distance(points))


def test_no_parts_are_refused() -> None:
    with pytest.raises(InputError, match="at least one polygon"):
        MultiPolygon([])


def scene_with(*objects: SceneObject, relations: tuple[Relation, ...] = ()) -> Scene:
    return Scene("s", (0.0, 50.0), (100.0, 50.0), objects, relations=relations)


def set_of(scene: Scene) -> DemonstrationSet:
    path = np.column_stack([np.linspace(0, 100, 20), np.full(20, 50.0)])
    symbols = tuple(sorted({o.symbol for o in scene.objects or ()}))
    return DemonstrationSet(
        (scene,), Demonstrations.of([Demonstration("d", "s", path, valid=True)]), symbols=symbols
    )


def test_parts_heading_height_and_relations_survive_the_file(tmp_path: Path) -> None:
    person = SceneObject("a", "person", (5.0, 5.0), None, None, heading_deg=90.0)
    shelf = SceneObject("b", "shelf", (20.0, 5.0), (0, 0, 40, 10), TWO, height=(0.5, 1.25))
    scene = scene_with(person, shelf, relations=(Relation("interact", ("a", "b")),))
    write_set(set_of(scene), tmp_path / "set")
    line = json.loads((tmp_path / "set/scenes/metadata.jsonl").read_text())
    assert "polygon" not in line["objects"][1]
    assert len(line["objects"][1]["polygons"]) == 2
    assert line["relations"] == [{"kind": "interact", "between": ["a", "b"]}]
    back = read_set(tmp_path / "set").scenes[0]
    assert back.objects == scene.objects
    assert back.relations == scene.relations


def test_an_empty_table_is_not_an_unlisted_one(tmp_path: Path) -> None:
    write_set(set_of(scene_with()), tmp_path / "empty")
    line = json.loads((tmp_path / "empty/scenes/metadata.jsonl").read_text())
    assert (line["objects"], line["listed"]) == ([], True)
    assert read_set(tmp_path / "empty").scenes[0].objects == ()
    unlisted = Scene("s", (0.0, 50.0), (100.0, 50.0), None)
    write_set(set_of(unlisted), tmp_path / "unlisted")
    assert "listed" not in json.loads((tmp_path / "unlisted/scenes/metadata.jsonl").read_text())
    assert read_set(tmp_path / "unlisted").scenes[0].objects is None


def with_line(folder: Path, **changes: object) -> Path:
    write_set(set_of(scene_with(SceneObject("a", "cup", (5.0, 5.0)))), folder)
    file = folder / "scenes" / "metadata.jsonl"
    line = json.loads(file.read_text())
    file.write_text(json.dumps({**line, **changes}) + "\n")
    return folder


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"listed": False}, "listed"),
        ({"relations": [{"kind": "interact", "between": ["a", "nobody"]}]}, "relations.between"),
        ({"relations": [{"kind": "interact", "between": ["a"]}]}, "relations.0.between"),
    ],
)
def test_what_contradicts_the_list_is_refused(
    tmp_path: Path, changes: dict[str, object], field: str
) -> None:
    with pytest.raises(InputError, match=r"metadata\.jsonl") as caught:
        read_set(with_line(tmp_path / "set", **changes))
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"polygons": []}, "objects.0.polygons"),
        ({"polygons": [[[0, 0], [1, 1]]]}, "objects.0.polygons.0"),
        ({"height": [2, 1]}, "objects.0.height"),
        ({"heading_deg": "north"}, "objects.0.heading_deg"),
    ],
)
def test_objects_that_cannot_be_read_are_refused(
    tmp_path: Path, changes: dict[str, object], field: str
) -> None:
    thing = {"id": "a", "symbol": "cup", "center": [5, 5], **changes}
    with pytest.raises(InputError, match=r"metadata\.jsonl") as caught:
        read_set(with_line(tmp_path / "set", objects=[thing]))
    assert caught.value.field == field


def test_a_relation_goes_with_its_object() -> None:
    scene = scene_with(
        SceneObject("a", "person", (0.0, 0.0)), SceneObject("b", "person", (9.0, 0.0)),
        relations=(Relation("interact", ("a", "b")),),
    )  # fmt: skip
    assert scene.objects is not None
    assert scene.with_changes(objects=scene.objects[:1], picture=None).relations == ()
    assert scene.with_changes(objects=scene.objects, picture=None).relations == scene.relations


def test_heading_turns_with_the_object_and_height_scales() -> None:
    thing = SceneObject("a", "cup", (5.0, 5.0), (4, 4, 2, 2), None, 30.0, (1.0, 2.0))
    doubled = thing.mapped(2 * np.eye(2))
    assert (doubled.heading_deg, doubled.height) == (30.0, (2.0, 4.0))
    mirrored = thing.mapped([[1, 0], [0, -1]], [0, 100])
    assert mirrored.heading_deg == pytest.approx(-30.0)
    assert mirrored.bbox == pytest.approx((4, 94, 2, 2))
    assert thing.moved((1, 1)).heading_deg == 30.0
    assert thing.mapped([[-1, 0], [0, -1]]).heading_deg == pytest.approx(-150.0)


def gate_plan() -> tuple[MultiPolygon, Scene, Plan, RuleSet]:
    gate = MultiPolygon([rectangle(40, 0, 10, 45), rectangle(40, 65, 10, 35)])
    scene = scene_with(SceneObject("gate", "gate", (45.0, 50.0), None, gate))
    rule = ClearanceRule(value={"gate": 4.0}, interval={"gate": (4.0, 4.0)})
    rules = RuleSet({"all": TypeRules(clearance=rule)})
    return gate, scene, plan_path(rules, scene, "all"), rules


def test_a_plan_keeps_clear_of_every_part_and_may_pass_between() -> None:
    gate, _, found, _ = gate_plan()
    assert found.obeys
    points = np.asarray(found.points)[:, :2]
    assert path_distance(gate, points)[0] >= 4.0 - 1e-9
    # The gap between the parts is free: a box or a hull around them would close it.
    assert np.abs(points[:, 1] - 55.0).max() < 20.0


def test_exports_hold_one_shape_a_part(tmp_path: Path) -> None:
    gate, scene, _, rules = gate_plan()
    rules = replace(rules, units="m", metres_per_unit=1.0)
    request = export_request(rules, scene, "all")
    export_to(request, "moveit", tmp_path / "moveit")
    document = json.loads((tmp_path / "moveit/planning_scene.json").read_text())
    assert len(document["world"]["collision_objects"][0]["meshes"]) == 2
    export_to(request, "ompl", tmp_path / "callables")
    made: dict[str, object] = {}
    for file in (tmp_path / "callables").rglob("*.py"):
        exec(compile(file.read_text(), str(file), "exec"), made)  # our own file
    points = np.random.default_rng(0).uniform(-20, 120, (300, 2))
    measure = made["clearance"]
    assert callable(measure)
    assert np.allclose(measure(points), gate.signed_distance(points))


def test_every_part_is_drawn() -> None:
    _, scene, _, _ = gate_plan()
    assert scene_svg(scene, []).count("<polygon") == 2
    gate = scene.listed_objects()[0].outline
    assert outline_path(gate).count("M") == 2


def test_learning_from_a_set_with_an_empty_table() -> None:
    from demospec.rules import learn_rules

    thing = scene_with(SceneObject("a", "cup", (50.0, 50.0), None, rectangle(45, 45, 10, 10)))
    empty = Scene("empty", (0.0, 50.0), (100.0, 50.0), ())
    lines = [(s, y) for s in ("s", "empty") for y in (10.0, 30.0, 44.0, 50.0, 56.0, 70.0)]
    demonstrations = [
        Demonstration(
            f"{s}-{y}", s, np.column_stack([np.linspace(0, 100, 20), np.full(20, y)]),
            valid=s == "empty" or abs(y - 50) > 12,
        )
        for s, y in lines
    ]  # fmt: skip
    data = DemonstrationSet((thing, empty), Demonstrations.of(demonstrations), symbols=("cup",))
    rules = learn_rules(data, influence=False)
    rule = next(iter(rules.rules.values())).clearance
    assert rule is not None
    assert rule.relevant == ("cup",)
