"""How much of a person's answers a rule explains: size under chance, suspects, and verdicts."""

from __future__ import annotations

import importlib.util
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet
from demospec.rules import learn_rules
from demospec.rules._goodness import goodness_of_fit
from demospec.rules._residuals import Covariate, scan_residuals


def worlds() -> ModuleType:
    """The generator of simulated people in benchmarks/worlds.py."""
    if "people_worlds" not in sys.modules:
        file = Path(__file__).parents[2] / "benchmarks" / "worlds.py"
        spec = importlib.util.spec_from_file_location("people_worlds", file)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules["people_worlds"] = module
        spec.loader.exec_module(module)
    return sys.modules["people_worlds"]


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_permuted_labels_are_seldom_called_more_than_not(share: float) -> None:
    rng = np.random.default_rng(int(100 * share))
    called = Counter()
    for _ in range(120):
        safe = rng.exponential(10.0, (40, 3))
        valid = rng.random(40) < share
        fit = goodness_of_fit(
            safe, valid, predicted=np.full(40, 0.5), wrong=valid & False, margin=safe.min(axis=1)
        )
        called[fit.verdict] += 1
    # At most 2 % are meant: 7 of 120 would happen by chance once in a thousand times.
    assert called["partly"] + called["explains"] <= 7


def test_a_rule_that_separates_is_told_from_chance() -> None:
    rng = np.random.default_rng(0)
    safe = rng.exponential(10.0, (40, 3))
    valid = safe[:, 1] >= 6.0
    margin = safe[:, 1] - 6.0
    fit = goodness_of_fit(
        safe, valid, predicted=valid.astype(float), wrong=valid & False, margin=margin
    )
    assert fit.verdict == "explains"
    assert fit.explained == 1.0
    assert fit.p_chance <= 0.01


def test_more_distance_that_is_rejected_is_not_explained() -> None:
    rng = np.random.default_rng(1)
    safe = rng.exponential(10.0, (60, 2))
    valid = safe[:, 0] <= 6.0
    fit = goodness_of_fit(
        safe,
        valid,
        predicted=np.full(60, valid.mean()),
        wrong=~valid,
        margin=np.full(60, np.inf),
        covariates=lambda: [Covariate("distance", "glass", safe[:, 0])],
    )
    assert fit.verdict == "not"
    assert [s.feature for s in fit.suspects] == ["near"]


def test_labels_of_one_kind_are_neither_explained_nor_contradicted() -> None:
    safe = np.ones((5, 1))
    fit = goodness_of_fit(
        safe,
        np.ones(5, dtype=bool),
        predicted=np.ones(5),
        wrong=np.zeros(5, dtype=bool),
        margin=np.full(5, np.inf),
    )
    assert fit.verdict == "partly"
    assert fit.explained is None


def test_noise_that_grows_near_the_threshold_accuses_nothing() -> None:
    """The margin goes with the covariate, and errors with the margin; nothing else is there."""
    accused = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        margin = rng.normal(0.0, 5.0, 120)
        p = 1 / (1 + np.exp(-1.5 * margin))
        valid = rng.random(120) < p
        covariate = Covariate("length", None, margin + rng.normal(0, 1.0, 120))
        residual = valid - (margin >= 0).astype(float)
        accused += len(scan_residuals(residual, margin, [covariate], seed=seed))
    assert accused <= 3


CONSTRAINED = {"speed": "speed", "one side": "distance", "must come near": "near"}
"""Kinds of people whose rule a constraint states: its feature."""


@pytest.mark.parametrize(
    "kind", ["one class", "sd 1", "coin 50 %", "two people", "crowd", *CONSTRAINED]
)
def test_people_are_understood_or_not(kind: str) -> None:
    w = worlds()
    data = w.sample(kind, 3)
    assert isinstance(data, DemonstrationSet)
    (rules,) = learn_rules(data, influence=False).rules.values()
    fit = rules.fit
    assert fit is not None
    named = [c.feature for c in rules.constraints]
    if kind in CONSTRAINED:
        assert named == [CONSTRAINED[kind]]
        assert fit.verdict == "explains"
        return
    assert named == []
    expected = {"in": {"explains"}, "noisy": {"explains"}, "coin": {"not"}}
    assert fit.verdict in expected.get(w.KINDS[kind].family, {"partly", "not"})
    if w.KINDS[kind].family == "out":
        assert fit.suspects[0].feature == w.KINDS[kind].suspect
