"""Rules learned from pairs: which of two paths somebody would rather have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet, Pair
from demospec.rules import RuleSet, learn_rules, nearest_approach
from demospec.testing import demonstrator_set, with_labels

KEPT = 5.0


def compared(seed: int, count: int, prefers: str, labels: int = 0) -> DemonstrationSet:
    """A person who keeps 5 from glasses and was shown pairs of paths.

    Args:
        prefers: ``kept`` the one that keeps the rule, else either; ``farther`` the farther one,
            whatever the rule; ``either`` by a coin.
        labels: How many demonstrations have a label besides.
    """
    rng = np.random.default_rng(seed)
    data = demonstrator_set(rng, {"anna": {"glass": KEPT}}, scenes=6, each=12)
    d = data.demonstrations
    near = np.empty(len(d))
    for name, rows in data.rows_by_scene().items():
        near[rows] = nearest_approach(data.scene(name), d.paths_xy(rows), ["glass"])[:, 0]
    pairs = []
    for _ in range(count):
        one, two = rng.choice(len(d), 2, replace=False).tolist()
        better = rng.random() < 0.5
        if prefers == "farther":
            better = near[one] > near[two]
        elif prefers == "kept" and (near[one] >= KEPT) != (near[two] >= KEPT):
            better = near[one] >= KEPT
        one, two = (one, two) if better else (two, one)
        pairs.append(Pair(str(d.demo_id[one]), str(d.demo_id[two])))
    known = np.where(np.arange(len(d)) < labels, d.valid, -1)
    return replace(with_labels(data, known), pairs=tuple(pairs))


def learnt(data: DemonstrationSet) -> RuleSet:
    return learn_rules(data, influence=False)


def test_pairs_alone_recover_a_distance() -> None:
    held, off = 0, []
    for seed in range(6):
        rules = learnt(compared(seed, 100, "kept")).rules["anna"]
        assert rules.clearance is not None
        assert rules.fit is not None
        assert rules.clearance.relevant == ("glass",)
        low, high = rules.clearance.interval["glass"]
        held += low <= KEPT <= high
        off.append(abs(rules.clearance.value["glass"] - KEPT))
        assert rules.fit.verdict == "explains"
        assert rules.fit.n == 100
        assert rules.evidence["pairs"] == 100
        assert rules.evidence["interval"] == "95 % credible"
        assert "nothing else is needed" in rules.sentence
    assert held >= 5
    assert np.median(off) < 0.6


def test_pairs_narrow_the_interval_of_labels() -> None:
    widths: list[list[float]] = []
    held = 0
    for count in (0, 150):
        widths.append([])
        for seed in range(4):
            rule = learnt(compared(seed, count, "kept", labels=14)).rules["anna"].clearance
            assert rule is not None
            low, high = rule.interval["glass"]
            held += low <= KEPT <= high
            widths[-1].append(high - low)
    assert held >= 7
    assert np.median(np.array(widths[1]) / np.array(widths[0])) < 0.8


@pytest.mark.parametrize("seed", [0, 1])
def test_who_always_prefers_the_farther_path_says_of_no_distance_that_it_is_enough(
    seed: int,
) -> None:
    rule = learnt(compared(seed, 100, "farther")).rules["anna"].clearance
    assert rule is not None
    assert rule.relevant == ("glass",)
    low, high = rule.interval["glass"]
    assert high - low > 8.0


def test_pairs_of_a_coin_are_not_explained() -> None:
    verdicts = []
    for seed in range(8):
        fit = learnt(compared(seed, 60, "either")).rules["anna"].fit
        assert fit is not None
        verdicts.append(fit.verdict)
    assert verdicts.count("not") >= 7


def test_a_pair_may_be_somebody_elses_than_the_demonstrations() -> None:
    data = compared(0, 100, "kept", labels=0)
    pairs = tuple(replace(p, type="ben") for p in data.pairs)
    found = learnt(replace(data, types=("anna", "ben"), pairs=pairs))
    assert set(found.rules) == {"ben"}
    assert "no demonstration to learn from for type anna" in found.notes


def test_a_contradicting_pair_is_named() -> None:
    data = compared(2, 100, "kept")
    before = learnt(data).rules["anna"]
    assert before.evidence["contradicted_pairs"] == []
    # The one pair of the clearest difference, said the other way round.
    rule = before.clearance
    assert rule is not None
    d = data.demonstrations
    near = dict.fromkeys(d.demo_id.tolist(), 0.0)
    for name, rows in data.rows_by_scene().items():
        values = nearest_approach(data.scene(name), d.paths_xy(rows), ["glass"])[:, 0]
        near.update(zip(d.demo_id[rows].tolist(), values.tolist(), strict=True))
    decided = [
        i for i, p in enumerate(data.pairs)
        if near[p.preferred] > KEPT + 2 and near[p.other] < KEPT - 2
    ]  # fmt: skip
    wrong = data.pairs[decided[0]]
    swapped = list(data.pairs)
    swapped[decided[0]] = Pair(wrong.other, wrong.preferred)
    after = learnt(replace(data, pairs=tuple(swapped))).rules["anna"]
    assert after.evidence["contradicted_pairs"] == [[wrong.other, wrong.preferred]]
