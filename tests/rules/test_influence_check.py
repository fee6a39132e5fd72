"""No answer without a check: what a wrong engine says is withheld, and called our failure."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from rules_problems import random_problem

import demospec.rules
from demospec.cli import main
from demospec.rules import (
    InfluenceAnswer,
    RuleObject,
    RuleProblem,
    RuleScene,
    RuleTrajectory,
    answer_problem,
    evaluate_rule,
    solve,
)
from demospec.rules.influence import (
    CpSatEngine,
    ExactEngine,
    WrongAnswerError,
    check_answer,
    contradicted,
)
from demospec.testing import problem_document


@dataclass(frozen=True)
class Wrong:
    """The exact engine, but for one parameter of one end."""

    end: str
    place: int
    by: int

    def answer(
        self, problem: RuleProblem, listed: int, deadline: float, seed: int
    ) -> InfluenceAnswer:
        right = ExactEngine().answer(problem, listed, deadline, seed)
        values = list(getattr(right, self.end))
        values[self.place] += self.by
        return replace(right, **{self.end: tuple(values)})


def small() -> RuleProblem:
    """T_min is 3 or 4; the radius is below 8 (accepted path) and at least 6 (rejected path)."""
    scene = RuleScene((RuleObject("a", "a", (0.0, 0.0)),))
    paths = (
        RuleTrajectory(0, True, np.array([[5.0, 0.0], [0.0, 8.0]])),
        RuleTrajectory(0, False, np.array([[6.0, 0.0], [0.0, 6.0]])),
        RuleTrajectory(0, False, np.array([[3.0, 0.0]])),
    )
    return RuleProblem((scene,), paths, 12)


@pytest.mark.parametrize(
    ("engine", "row"),
    [
        (Wrong("min", 0, -1), "#1, #2"),  # T_min 2 does not touch the third path
        (Wrong("max", 0, 1), "#0"),  # T_min 5 touches the first
        (Wrong("min", 1, -1), "#1"),
        (Wrong("max", 1, 1), "#0"),
    ],
)
def test_an_answer_that_its_own_labels_contradict_is_withheld(engine, row):
    assert solve(small()).status == "optimal"
    with pytest.raises(WrongAnswerError, match=f"contradicts these trajectories: {row}"):
        solve(small(), engine)


def test_a_listed_tie_is_checked_too():
    problem = small()
    answer = solve(problem)
    beside = (answer.max[0] + 1, *answer.max[1:])
    with pytest.raises(WrongAnswerError, match="#0"):
        check_answer(problem, replace(answer, optima_max=(answer.max, beside)))


def test_a_tolerant_answer_must_contradict_what_it_says():
    problem = random_problem(3, flip=0.4)
    answer = solve(problem, tolerant=True)
    assert answer.contradicted
    assert check_answer(problem, answer) is answer
    for told in (answer.contradicted[1:], tuple(range(len(problem.trajectories)))):
        with pytest.raises(WrongAnswerError):
            check_answer(problem, replace(answer, contradicted=told))


def test_a_withheld_answer_is_exit_1_and_named_our_mistake(tmp_path, capsys, monkeypatch):
    file = tmp_path / "problem.json"
    file.write_text(json.dumps(problem_document(small())))

    def with_a_wrong_engine(path: Path, settings: dict, **options: object):
        return answer_problem(path, settings, **{**options, "engine": Wrong("max", 0, 1)})

    # The command line takes engines by name only.
    monkeypatch.setattr(demospec.rules, "answer_problem", with_a_wrong_engine, raising=False)
    with pytest.raises(SystemExit) as stopped:
        main(["rules", str(file), "--json"])
    out, err = capsys.readouterr()
    assert stopped.value.code == 1
    assert out == ""
    assert len(err.splitlines()) == 1
    assert "internal failure: WrongAnswerError" in err
    assert "this is our mistake" in err


@pytest.mark.parametrize("engine", [CpSatEngine("direct"), CpSatEngine("step"), ExactEngine()])
def test_engines_are_arguments(engine):
    assert solve(small(), engine).hull_radius == ((6, 7),)


def test_the_check_is_that_of_the_plain_evaluator_on_any_coordinates():
    """Whole, decimal and full-precision coordinates, three dimensions, features, arc weights."""
    for seed in range(60):
        problem = random_problem(seed)
        rng = np.random.default_rng(seed)
        if seed % 3 == 0:  # no grid that all coordinates are on
            paths = [replace(p, points=p.points / 3) for p in problem.trajectories]
            problem = replace(problem, trajectories=tuple(paths))
        if seed % 10 == 0:
            dims = {len(o.center) for s in problem.scenes for o in s.objects}
            if dims == {3}:
                scenes = [
                    replace(s, objects=tuple(replace(o, feature="height") for o in s.objects))
                    for s in problem.scenes
                ]
                problem = replace(problem, scenes=tuple(scenes))
        bounds = problem.bounds
        sets = [
            (
                int(rng.integers(bounds.T_min[0], bounds.T_min[1] + 1)),
                *rng.integers(
                    bounds.T_object[0], bounds.T_object[1] + 1, len(problem.parameters)
                ).tolist(),
            )
            for _ in range(5)
        ]
        for values, wrong in zip(sets, contradicted(problem, sets), strict=True):
            own = dict(zip(problem.parameters, values[1:], strict=True))
            verdicts = evaluate_rule(problem, values[0], own)
            paths = problem.trajectories
            pairs = enumerate(zip(verdicts, paths, strict=True))
            told = [i for i, (verdict, path) in pairs if verdict.valid != path.valid]
            assert list(wrong) == told, seed
