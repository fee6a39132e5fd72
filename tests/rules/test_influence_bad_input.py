"""Bad and odd input: each a defined answer, or one line that says what is wrong where."""

from __future__ import annotations

import json

import numpy as np
import pytest
from rules_problems import pixel_problem

from demospec.errors import InputError
from demospec.rules import problem_from_document, read_problem, solve
from demospec.testing import problem_document


def base(**changes):
    top = {
        "F_max": 60,
        "bounds": {"T_min": [1, 12], "T_object": [1, 15]},
        "scenes": [{"objects": [{"id": "drill", "class": "drill", "center": [20, 20]}]}],
        "trajectories": [
            {"valid": True, "points": [[0, 40], [40, 40]]},
            {"valid": False, "points": [[0, 40], [20, 24]]},
        ],
    }
    return {**top, **changes}


ENGINES = ("exact", "step", "direct")


def answer(engine="exact", **changes):
    return solve(problem_from_document(base(**changes)), engine)


@pytest.mark.parametrize("engine", ENGINES)
def test_no_demonstration_leaves_everything_open(engine):
    found = answer(engine, trajectories=[])
    assert found.n_feasible == 12 * 15
    assert (found.L_min, found.L_max) == (2, 27)
    assert found.saturated == ("T_min", "drill")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("valid", [True, False])
def test_one_class_only(engine, valid):
    paths = [p for p in base()["trajectories"] if p["valid"] == valid]
    found = answer(engine, trajectories=paths)
    assert found.status == "optimal"
    assert (found.min == (1, 1)) == valid
    if not valid:
        assert found.max == (12, 15)


@pytest.mark.parametrize("engine", ENGINES)
def test_one_point_and_a_point_on_a_centre(engine):
    found = answer(engine, trajectories=[{"valid": False, "points": [[20, 20]]}])
    assert found.n_feasible == 12 * 15  # in contact whatever T_min is
    found = answer(engine, trajectories=[{"valid": True, "points": [[20, 20]]}])
    assert found.status == "infeasible"
    assert found.conflict == (0,)
    lone = [{"valid": True, "points": [[20, 60]]}]
    assert answer(engine, trajectories=lone, weights="arc").n_feasible == 12 * 15


@pytest.mark.parametrize("engine", ENGINES)
def test_contact_at_T_min_zero(engine):
    bounds = {"T_min": [0, 0], "T_object": [0, 5]}
    on = [{"valid": False, "points": [[20, 20]]}]
    beside = [{"valid": False, "points": [[20, 21]]}]
    assert answer(engine, trajectories=on, bounds=bounds).n_feasible == 6
    assert answer(engine, trajectories=beside, bounds=bounds).status == "infeasible"


@pytest.mark.parametrize("engine", ENGINES)
def test_no_object(engine):
    good = [{"valid": True, "points": [[0, 0]]}]
    found = answer(engine, scenes=[{"objects": []}], trajectories=good)
    assert (found.n_feasible, found.min, found.max) == (12, (1,), (12,))
    bad = [{"valid": False, "points": [[0, 0]]}]
    found = answer(engine, scenes=[{"objects": []}], trajectories=bad)
    assert (found.status, found.conflict) == ("infeasible", (0,))
    problem = problem_from_document(base(scenes=[{"objects": []}], trajectories=bad))
    assert solve(problem, tolerant=True).contradicted == (0,)


@pytest.mark.parametrize("engine", ENGINES)
def test_bounds_that_leave_one_choice(engine):
    found = answer(engine, bounds={"T_min": [5, 5], "T_object": [3, 3]})
    assert found.min == found.max == (5, 3)
    assert found.n_feasible == 1
    assert found.saturated == ("T_min", "drill")


def test_everything_collides():
    paths = [{"valid": v, "points": [[20, 20]]} for v in (True, False, True)]
    found = answer(trajectories=paths)
    assert found.status == "infeasible"
    assert len(found.conflict) == 1
    lenient = solve(problem_from_document(base(trajectories=paths)), tolerant=True)
    assert lenient.contradicted == (0, 2)


def test_coordinates_of_1e12():
    far = [{"valid": True, "points": [[1e12, 1e12], [1e12, -1e12]]}]
    for weights in ("points", "arc"):
        assert answer(trajectories=far, weights=weights).n_feasible == 12 * 15


def test_an_F_max_of_nothing_makes_everything_bad():
    assert answer(F_max=0).status == "infeasible"
    bad = [{"valid": False, "points": [[0, 0]]}]
    assert answer(F_max=0, trajectories=bad).n_feasible == 12 * 15


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"F_max": 1.5}, "F_max: expected a whole number, found 1.5"),
        ({"F_max": True}, "F_max: expected a whole number, found True"),
        ({"F_max": -1}, "F_max: expected a whole number from 0 to 1e9, found -1"),
        ({"F_max": 1e400}, "F_max: expected a whole number, found inf"),
        ({"F_max": 10**30}, "F_max: expected a whole number from 0 to 1e9, found 1000000"),
        ({"scale": 0}, "scale: expected a whole number from 1 to 1000000, found 0"),
        ({"reading": "all"}, "reading: expected one of sum, nearest, nearest_active, max_active"),
        ({"penalty": 3}, "penalty: expected a word, found 3"),
        ({"preset": "best"}, "preset: expected one of the presets physical, found best"),
        ({"preset": "physical", "penalty": "count"}, "penalty: expected hinge (the preset says"),
        ({"family": "clearance"}, "family: expected family influence, found clearance"),
        ({"distance": "footprint"}, "distance: expected distance center"),
        ({"scenes": []}, "scenes: expected at least one scene, found none"),
        ({"scenes": 3}, "scenes: expected a list, found 3"),
        ({"trajectories": {}}, "trajectories: expected a list, found {}"),
        ({"bounds": {"T_min": [5, 4]}}, "bounds.T_min: expected [low, high] with 0 <= low"),
        ({"bounds": {"T_min": [-1, 4]}}, "bounds.T_min: expected [low, high] with 0 <= low"),
        ({"bounds": {"T_object": [1, 10**9]}}, "bounds.T_object: expected [low, high] with 0"),
        ({"bounds": {"T_object": [1]}}, "bounds.T_object: expected [low, high], found [1]"),
        ({"bounds": []}, "bounds: expected an object with T_min and T_object"),
    ],
)
def test_one_line_names_the_field(changes, message):
    with pytest.raises(InputError) as caught:
        problem_from_document(base(**changes))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ({"valid": True}, "trajectories[1]: expected the field points"),
        ({"points": [[0, 0]]}, "trajectories[1]: expected the field valid"),
        ({"valid": None, "points": [[0, 0]]}, "trajectories[1].valid: expected true or false"),
        ({"valid": True, "points": []}, "trajectories[1].points: expected at least one point"),
        ({"valid": True, "points": [[1]]}, "trajectories[1].points: expected at least one point"),
        ({"valid": True, "points": [[1, 2], [3]]}, "trajectories[1].points: expected a list of"),
        ({"valid": True, "points": [[1, "x"]]}, "trajectories[1].points: expected a list of"),
        ({"valid": True, "points": [["1", "2"]]}, "trajectories[1].points: expected a list of"),
        ({"valid": True, "points": [[1, float("nan")]]}, "points[0]: expected finite numbers"),
        ({"valid": True, "points": [[1, 2], [1, -1e308]]}, "trajectories[1].points[1]: expected"),
        (
            {"valid": True, "points": [[1, 2]], "scene": 7},
            "trajectories[1].scene: expected a scene",
        ),
        ({"valid": True, "points": [[1, 2]], "id": "a"}, "trajectories[1].id: expected ids that"),
        (5, "trajectories[1]: expected a trajectory (a JSON object), found 5"),
    ],
)
def test_one_line_names_the_trajectory(path, message):
    first = {"valid": True, "points": [[0, 0]], "id": "a"}
    with pytest.raises(InputError) as caught:
        problem_from_document(base(trajectories=[first, path]))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("objects", "message"),
    [
        ([{"id": "a"}], "scenes[0].objects[0]: expected the field center"),
        ([{"id": "a", "center": [1]}], "scenes[0].objects[0].center: expected 2 or 3 finite"),
        ([{"id": "a", "center": [1e200, 2]}], "center: expected 2 or 3 finite numbers of size at"),
        ([{"id": "a", "center": [1, 10**400]}], "scenes[0].objects[0].center: expected 2 or 3"),
        ([{"id": "a", "center": [1, "2"]}], "scenes[0].objects[0].center: expected 2 or 3"),
        ([{"id": "a", "center": [1, 2]}] * 2, "scenes[0].objects[1].id: expected ids that differ"),
        ([{"id": 4, "center": [1, 2]}], "scenes[0].objects[0].id: expected a name"),
        ([{"id": "a", "center": [1, 2], "feature": "smell"}], "expected one of the features"),
        ([{"id": "a", "center": [1, 2, 3]}], "trajectories[0].points: expected at least one point"),
    ],
)
def test_one_line_names_the_object(objects, message):
    with pytest.raises(InputError) as caught:
        problem_from_document(base(scenes=[{"objects": objects}]))
    assert message in str(caught.value)


def test_a_file_with_NaN_is_refused_by_name(tmp_path):
    file = tmp_path / "problem.json"
    file.write_text(json.dumps(base()).replace("24", "NaN"))
    with pytest.raises(InputError, match=r"problem.json.*finite number, found NaN"):
        read_problem(file)
    file.write_text(json.dumps(base(F_max="60")))
    with pytest.raises(InputError, match=r"problem\.json, F_max: expected a whole number"):
        read_problem(file)
    with pytest.raises(InputError, match="readable file"):
        read_problem(tmp_path / "absent.json")


def test_engines_refuse_what_they_cannot_do_exactly():
    problem = problem_from_document(base(reading="first"))
    with pytest.raises(InputError, match="engine direct or exact"):
        solve(problem, "step")
    with pytest.raises(InputError, match="one of auto, direct, step, exact"):
        solve(problem, "best")
    with pytest.raises(InputError, match="a known F_max"):
        solve(problem_from_document(base(F_max=None)))


def test_a_document_round_trips():
    problem = pixel_problem(3)
    again = problem_from_document(json.loads(json.dumps(problem_document(problem))))
    assert solve(again).to_json()["hull"] == solve(problem).to_json()["hull"]
    assert np.array_equal(again.trajectories[0].points, problem.trajectories[0].points)


def test_a_problem_counts_whole_units():
    """The settings of an answer in metres name a quantum; a problem has none."""
    with pytest.raises(InputError, match="quantum: expected no quantum: a problem counts whole"):
        problem_from_document(base(quantum=0.001))
