"""Faults put into the engines on purpose: each must be caught by brute force.

A mutated copy of the room is imported beside the real one, and a battery of problems is
solved with it. A mutation that no problem notices fails the test.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import itertools
import sys
from pathlib import Path

import numpy as np
import pytest
from rules_oracle import answer_of
from rules_problems import random_problem

import demospec.rules
from demospec.rules import Bounds, RuleObject, RuleProblem, RuleScene, RuleTrajectory
from demospec.testing import problem_document

ROOM = "demospec.rules.influence.engines"
FOLDER = Path(demospec.rules.__file__).parent / "influence" / "engines"

# ruff: noqa: E501
# (module, as written, mutated, engine)
MUTATIONS = [
    ("_arithmetic", "level = np.ceil(root)", "level = np.floor(root)", "exact"),
    ("_arithmetic", "level = np.ceil(root)", "level = np.floor(root) + 1", "exact"),
    ("_arithmetic", "            root += 0.5\n", "", "exact"),
    ("_arithmetic", "return root if root * root == square else root + 1", "return root + 1", "direct"),
    ("_arithmetic", "(isqrt(four.numerator // four.denominator) + 1) // 2",
     "isqrt(four.numerator // four.denominator) // 2", "direct"),
    ("_presolve", "(floor >= limit)", "(floor >= limit - 1)", "exact"),
    ("_presolve", "(limit - 1) - floor[tops]", "(limit - 2) - floor[tops]", "exact"),
    ("_presolve", "ceiling < limit)", "ceiling <= limit)", "exact"),
    ("_presolve", "int(nearest.min()) - 1)", "int(nearest.min()))", "exact"),
    ("_enumerate", 'side="left")[::-1]', 'side="right")[::-1]', "exact"),
    ("_enumerate", 'T, side="right")', 'T, side="left")', "exact"),
    ("_enumerate", "np.maximum(least, self.low)", "np.maximum(least + 1, self.low)", "exact"),
    ("_boxes", "(floor[:, :v] < limit)", "(floor[:, :v] <= limit)", "search"),
    ("_boxes", "ceiling[:, v:] < limit", "ceiling[:, v:] <= limit", "search"),
    ("_branch_and_bound", "self.rows.closest <= boxes.T_low", "self.rows.closest < boxes.T_low", "search"),
    ("_branch_and_bound", "(ceiling[:, :v] < limit)", "(ceiling[:, :v] <= limit)", "search"),
    ("_points", "sure, maybe = level <= r_low, level <= r_high",
     "sure, maybe = level < r_low, level <= r_high", "exact"),
    ("_points", "open_ &= ~sure", "open_ &= ~maybe", "exact"),
    ("cp_sat._direct", "    model.add(variable <= level - 1).only_enforce_if(~literal)\n", "", "direct"),
    ("cp_sat._direct", "    model.add(variable >= level).only_enforce_if(literal)\n", "", "direct"),
    ("cp_sat._direct", "model.add(total <= limit - 1)\n        return", "model.add(total <= limit)\n        return", "direct"),
    ("cp_sat._direct", "model.add(total >= limit).only_enforce_if(heavy)", "model.add(total >= 0)", "direct"),
    ("cp_sat._direct", "    model.add(depth == 0).only_enforce_if(~literal)\n", "", "direct"),
    ("cp_sat._direct", "            model.add_bool_or([~inside[k], *(inside[j] for j in earlier), picked])\n",
     "", "direct"),
    ("cp_sat._steps", "            model.add(variable <= value - 1).only_enforce_if(~literal)\n", "",
     "step"),
    ("cp_sat._steps", "            model.add(variable >= value).only_enforce_if(literal)\n", "",
     "step"),
    ("cp_sat._steps", "encoding.T_min <= level - 1", "encoding.T_min <= level", "step"),
    ("cp_sat._steps", "low + 1 + int(step)", "low + int(step)", "step"),
    ("_counting", "for s in range(length)", "for s in range(length - 1)", "search"),
    ("_arithmetic", "level, penalty = np.ceil(root)", "level, penalty = np.floor(root)", "exact"),
    ("_arithmetic", "np.floor(root * scale + 0.5)", "np.floor(root * scale)", "exact"),
    ("_step_tables", "nearest <= reach * reach", "nearest < reach * reach", "exact"),
    ("_step_tables", "reach * reach + 1, out=squares", "reach * reach, out=squares", "exact"),
    ("_step_tables", "level[nearest], FAR", "level[nearest] + 1, FAR", "exact"),
    ("_boxes", "limit - 1, floor[:, :v]", "limit - 2, floor[:, :v]", "search"),
    ("_boxes", "ceiling[:, v:], limit, out", "ceiling[:, v:], limit + 1, out", "search"),
    ("_enumerate", "steps[upper] >= need", "steps[upper] > need", "exact"),
    ("_enumerate", "running[at] = _reached(steps, need[at])", "running[at] = _reached(steps, need[at]) + 1", "exact"),
]  # fmt: skip


class _Mutant(importlib.abc.Loader):
    def __init__(self, path: Path, old: str, new: str) -> None:
        self.path, self.old, self.new = path, old, new

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        source = self.path.read_text(encoding="utf-8")
        exec(compile(source.replace(self.old, self.new), str(self.path), "exec"), module.__dict__)


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, module: str, old: str, new: str) -> None:
        self.name = f"{ROOM}.{module}"
        self.loader = _Mutant(FOLDER / f"{module.replace(chr(46), chr(47))}.py", old, new)

    def find_spec(self, name, path=None, target=None):
        if name != self.name:
            return None
        return importlib.util.spec_from_file_location(name, self.loader.path, loader=self.loader)


@pytest.fixture
def mutated():
    """Imports a mutated room; puts the real one back afterwards."""
    import demospec

    kept = {n: m for n, m in sys.modules.items() if n.startswith("demospec.rules")}
    room = demospec.rules
    finders = []

    def install(module: str, old: str, new: str):
        for name in kept:
            sys.modules.pop(name, None)
        finder = _Finder(module, old, new)
        # Here, since a mutant that cannot even be imported counts as noticed.
        path = finder.loader.path
        assert old in path.read_text(encoding="utf-8"), f"{path.name} no longer has: {old}"
        finders.append(finder)
        sys.meta_path.insert(0, finders[-1])
        return importlib.import_module("demospec.rules")

    yield install
    for finder in finders:
        sys.meta_path.remove(finder)
    for name in [n for n in sys.modules if n.startswith("demospec.rules")]:
        del sys.modules[name]
    sys.modules.update(kept)
    demospec.rules = room


def edges():
    """One object, one trajectory: d = T, Σ = F_max, Σ = F_max − 1, halves."""
    scene = RuleScene((RuleObject("a", "a", (0.0, 0.0)),))
    for points, F_max in itertools.product(
        ([[3, 4]], [[0, 7]], [[2.5, 0]], [[0, 3], [0, 7]], [[2, 2]], [[5, 12]]),
        (3, 4, 5, 7, 8, 20),
    ):
        for valid in (True, False):
            for bounds in (
                Bounds((1, 1), (1, 12)),
                Bounds((1, 9), (2, 4)),
                Bounds((1, 1), (9, 12)),
                Bounds((1, 13), (0, 0)),
            ):
                path = RuleTrajectory(0, valid, np.array(points, dtype=float))
                yield RuleProblem((scene,), (path,), F_max, 1, bounds=bounds)


@pytest.fixture(scope="module")
def battery():
    """Documents of problems, with brute-force answers; short ones for CP-SAT."""
    problems = [*edges(), *(random_problem(seed) for seed in range(100))]
    return [(p.reading, problem_document(p), answer_of(p)) for p in problems]


def notices(rules, battery, engine) -> bool:
    """Whether any problem is answered differently from brute force (or not at all)."""
    influence = importlib.import_module("demospec.rules.influence")
    effort = influence.Effort(sweep_cells=-1 if engine == "search" else 10**8)
    for reading, top, expected in battery:
        if engine == "step" and reading not in ("sum", "nearest"):
            continue
        try:
            problem = rules.problem_from_document(top)
            answer = rules.solve(
                problem, "exact" if engine == "search" else engine, listed=10**6, time_limit_s=1,
                effort=effort,
            )  # fmt: skip
        except Exception:
            return True
        for name, value in expected.items():
            got = getattr(answer, name)
            if (list(got) if isinstance(value, list) else got) != value:
                return True
    return False


QUICK = {0, 2, 5, 7, 9, 12, 16, 18, 21, 24, 29, 30}
"""Mutations tried every time: strictness, rounding, ceil, half a reification; the rest is slow."""


@pytest.mark.parametrize(
    ("module", "old", "new", "engine"),
    [
        pytest.param(
            *mutation, id=f"{mutation[0]}-{i}", marks=() if i in QUICK else pytest.mark.slow
        )
        for i, mutation in enumerate(MUTATIONS)
    ],
)
def test_a_fault_is_noticed(mutated, battery, module, old, new, engine):
    assert notices(mutated(module, old, new), battery, engine)


@pytest.mark.parametrize("engine", ["exact", "search"])
def test_the_unmutated_copy_passes(mutated, battery, engine):
    assert not notices(mutated("_exact", "def ", "def "), battery, engine)
