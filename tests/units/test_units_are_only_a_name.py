"""The same world in px, mm, cm and m: the same verdicts, classes, plans, exports and sentences."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from unit_worlds import as_set, units_a_metre, world

from demospec.demonstrations import DemonstrationSet
from demospec.rules import learn_rules, rules_document

UNITS = ("m", "cm", "mm", "px")
Answer = Callable[[DemonstrationSet, float], Any]


def same(found: Any, expected: Any, where: str = "") -> None:
    """Equal but for rounding: numbers to 1e-9 relative (of the largest in their array)."""
    assert type(found) is type(expected), where
    if isinstance(expected, dict):
        assert list(found) == list(expected), where
        for key, value in expected.items():
            same(found[key], value, f"{where}.{key}")
    elif isinstance(expected, (list, tuple)):
        assert len(found) == len(expected), where
        for i, value in enumerate(expected):
            same(found[i], value, f"{where}[{i}]")
    elif isinstance(expected, np.ndarray):
        assert found.shape == expected.shape, where
        size = float(np.abs(expected[np.isfinite(expected)]).max(initial=0.0))
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * size, err_msg=where)
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-12, nan_ok=True), where
    else:
        assert found == expected, where


LENGTHS = {"value", "interval", "at_most", "points", "position_noise", "decided", "draws"}
"""Fields of JSON documents that hold lengths in the unit of the set."""


def in_metres(document: Any, metre: float, lengths: bool = False) -> Any:
    """A JSON document with its lengths in metres; times are left out."""
    if isinstance(document, dict):
        return {
            key: in_metres(value, metre, lengths or key in LENGTHS)
            for key, value in document.items()
            if key not in ("seconds", "units", "metres_per_unit")
        }
    if isinstance(document, (list, tuple)):
        return [in_metres(value, metre, lengths) for value in document]
    if lengths and isinstance(document, float):
        return document / metre
    return document


def learned(data: DemonstrationSet, metre: float) -> Any:
    return in_metres(rules_document(learn_rules(data, influence=False)), metre)


def predicted(data: DemonstrationSet, metre: float) -> Any:
    from demospec.specification import predict

    found = predict(learn_rules(data, influence=False), data).to_json()
    return found["predictions"]


def audited(data: DemonstrationSet, metre: float) -> Any:
    from demospec.specification import audit_set

    return in_metres(audit_set(data).to_json(), metre)


def asked(data: DemonstrationSet, metre: float) -> Any:
    from demospec.rules import query_set

    return in_metres(query_set(data, type="first", pool=60).to_json(), metre)


def planned(data: DemonstrationSet, metre: float) -> Any:
    from demospec.planning import plan_path

    rules = learn_rules(data, influence=False)
    out = []
    for scene in data.scenes:
        for name in rules.types:
            for planner in ("grid", "latent"):
                plan = plan_path(rules, scene, name, planner=planner)
                document = plan.to_json()
                points = np.array(document["points"]).reshape(-1, 2) / metre
                lengths = {k: v / metre for k, v in document["clearance"].items()}
                kept = {k: document[k] for k in ("status", "obeys", "blocked_by", "uninformed")}
                out.append({**kept, "points": points, "clearance": lengths,
                            "length": plan.length / metre, "cost": plan.cost / metre})  # fmt: skip
    return out


def repaired(data: DemonstrationSet, metre: float) -> Any:
    from demospec.specification import repair_set

    rules = learn_rules(data, influence=False)
    found = repair_set(rules, data, "first", rules=rules).to_json()
    assert found["repairs"]
    for item in found["repairs"]:
        for name in ("points", "control", "trace"):
            item[name] = np.array(item[name]) / metre
        item["moved"] /= metre
    return found


def explained(data: DemonstrationSet, metre: float) -> Any:
    from demospec.specification import explain

    view = learn_rules(data, influence=False).see(data.scenes[0])
    unit = {"units": data.units, "metres_per_unit": data.metres_per_unit}
    shown = [d for d in data.demonstrations if d.scene_id == "s0"]
    return [explain(view, d.xy, "first", **unit).sentence for d in shown]


def exported(data: DemonstrationSet, metre: float) -> Any:
    """Everything that leaves in metres; the frame of the world has no picture."""
    import tempfile

    from demospec.planning import export_request, export_to
    from demospec.planning.exports._messages import Messages

    rules = learn_rules(data, influence=False)
    request = export_request(rules, data.scenes[0], "second", axes=data.axes)
    out: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for form in ("csv", "json", "moveit", "nav2"):
            export_to(request, form, folder / form)
        with (folder / "csv").open() as stream:
            rows = list(csv.DictReader(stream))
        out["csv"] = np.array([[float(r[k]) for k in ("t_s", "x_m", "y_m")] for r in rows])
        waypoints = json.loads((folder / "json").read_text())
        out["json"] = {k: waypoints[k] for k in ("frame_id", "t", "points_m")}
        out["moveit"] = json.loads((folder / "moveit" / "planning_scene.json").read_text())
        out["padding"] = json.loads((folder / "moveit" / "padding.json").read_text())
        import PIL.Image
        import yaml

        for name in ("map", "keepout", "speed"):
            out[name] = np.asarray(PIL.Image.open(folder / "nav2" / f"{name}.pgm")).astype(int)
            said = yaml.safe_load((folder / "nav2" / f"{name}.yaml").read_text())
            out[f"{name}.yaml"] = {k: said[k] for k in ("resolution", "origin", "mode")}
    poses = Messages(request).path().poses
    out["ros"] = np.array([[p.pose.position.x, p.pose.position.y] for p in poses])
    return out


def caused(data: DemonstrationSet, metre: float) -> Any:
    from demospec.causal import Settings, estimate, trials_of_set

    settings = Settings(placements=2, draws=20)
    rules = learn_rules(data, influence=False)
    found = estimate(trials_of_set(rules, data, settings=settings), settings).to_json()
    assert found["dose_response"]
    for point in (p for curve in found["dose_response"] for p in curve["points"]):
        for end in ("low", "high"):
            point[end] = None if point[end] is None else point[end] / metre
    return found


def carried_out(data: DemonstrationSet, metre: float) -> Any:
    pytest.importorskip("mujoco")
    from demospec.execution import ALLOWANCE_M, execute_plan
    from demospec.planning import plan_path

    rules = learn_rules(data, influence=False)
    plan = plan_path(rules, data.scenes[0], "second", allowance=ALLOWANCE_M * metre)
    done = execute_plan(plan, data.scenes[0], rules, robot="gantry").to_json()
    kept = {k: done[k] for k in ("status", "reached", "keeps_rule", "contacts", "clearance_m")}
    return {**kept, "error": done["tracking_error_m"]}


def reported(data: DemonstrationSet, metre: float) -> Any:
    """Every word of the report of a run folder, and those of its drawings."""
    import tempfile

    from demospec.demonstrations import write_set
    from demospec.planning import plan_path
    from demospec.report import build_report
    from demospec.specification import audit_set

    rules = learn_rules(data, influence=False)
    plans = [
        {**plan_path(rules, scene, name).to_json(), "type": name}
        for scene in data.scenes
        for name in rules.types
    ]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_set(data, folder / "set")
        for name, document in (
            ("rules", rules_document(rules)),
            ("audit", audit_set(data).to_json()),
            ("plans", {"plans": plans}),
        ):
            (folder / f"{name}.json").write_text(json.dumps(document))
        report = build_report(folder)
    people = [[p.sentence, [light.words for light in p.lights], p.facts, words_of(p.picture)]
              for p in report.people]  # fmt: skip
    sections = {s.title: [s.lead, [words_of(block) for block in s.blocks]]
                for s in report.sections if s.anchor != "computed"}  # fmt: skip
    return [report.summary, people, sections]


def words_of(block: Any) -> Any:
    """What can be read in a block: not the coordinates of a drawing."""
    if hasattr(block, "svg"):
        return [block.caption, re.findall(r"<(?:text|title)[^>]*>([^<]*)<", str(block.svg))]
    if hasattr(block, "png"):
        return [block.caption, block.alt]
    return None if block is None else str(block)


ANSWERS: dict[str, Answer] = {
    f.__name__: f
    for f in (learned, predicted, audited, asked, planned, repaired, explained, exported, caused,
              carried_out, reported)
}  # fmt: skip


QUICK = [name for name in ANSWERS if name not in ("carried_out", "asked")]


@pytest.mark.parametrize("name", QUICK)
def test_a_small_world_in_two_units(name: str) -> None:
    w = world(1, scenes=1, each=20)
    for unit in ("mm", "px"):
        found = ANSWERS[name](as_set(w, unit), units_a_metre(unit))
        same(found, ANSWERS[name](as_set(w, "m"), 1.0), f"{unit}:{name}")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", list(ANSWERS))
def test_answers(name: str, seed: int) -> None:
    w = world(seed, wrong=seed)
    expected = ANSWERS[name](as_set(w, "m"), 1.0)
    for unit in UNITS[1:]:
        same(ANSWERS[name](as_set(w, unit), units_a_metre(unit)), expected, f"{unit}:{name}")


@pytest.mark.parametrize("unit", ["m", "px"])
def test_a_stated_frame_moves_nothing(unit: str) -> None:
    """Without a picture there is nothing to turn over: y is written down as it came."""
    w = world(2, scenes=1, each=20)
    expected = exported(as_set(w, unit), units_a_metre(unit))
    for up in (True, False):
        same(exported(as_set(w, unit, up=up), units_a_metre(unit)), expected, f"up {up}")


def test_a_mirrored_world_is_judged_alike() -> None:
    """Its posterior is integrated over other points: verdicts are the same, not every digit."""
    w = world(3, scenes=1, each=20)
    ways = [as_set(w, "m", mirrored=mirrored) for mirrored in (False, True)]
    same(predicted(ways[1], 1.0), predicted(ways[0], 1.0))
    plain, mirrored = (learned(way, 1.0)["types"] for way in ways)
    for name in plain:
        for field in ("contradicted", "undecided"):
            assert mirrored[name]["evidence"][field] == plain[name]["evidence"][field]
