"""Effects of learned rules hold what else the answers allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_withheld_claims import simulated

from demospec.causal import Settings, find_causes
from demospec.errors import InputError
from demospec.rules import (
    ClearanceRule,
    RuleSet,
    TypeRules,
    learn_rules,
    rules_document,
    rules_from_document,
)

SETTINGS = Settings(placements=2, draws=30)


def with_share(share: float) -> RuleSet:
    """Normal's rule, with glasses in this share of the posterior's rules only."""
    glass = {"glass": 3.0}
    draws = tuple(glass if k < 40 * share else {} for k in range(40))
    return RuleSet({"normal": TypeRules(ClearanceRule(glass, draws=draws))})


@pytest.mark.parametrize(
    ("share", "verdict"),
    [(1.0, "causal"), (0.975, "causal"), (0.9, "undecided"), (0.5, "undecided")],
)
def test_a_claim_needs_the_rules_of_the_posterior(share: float, verdict: str) -> None:
    """However many scenes are asked: a rule that may not be there makes no cause."""
    data = simulated(coin=False)
    cell = find_causes(with_share(share), data.scenes, ["glass"],
                       settings=SETTINGS).effects[0]  # fmt: skip
    assert cell.verdict == verdict
    whole = find_causes(with_share(1.0), data.scenes, ["glass"], settings=SETTINGS)
    assert cell.effect == pytest.approx(share * whole.effects[0].effect, abs=1e-12)
    assert cell.interval is not None
    if share <= 0.9:
        assert cell.interval[0] <= whole.effects[0].effect
        assert cell.interval[1] >= -1e-12


def test_one_certain_rule_is_the_rule_itself() -> None:
    data = simulated(coin=False)
    plain = RuleSet({"normal": TypeRules(ClearanceRule({"glass": 3.0}))})
    sure = with_share(1.0)
    first, second = (find_causes(r, data.scenes, settings=SETTINGS) for r in (plain, sure))
    for a, b in zip(first.effects, second.effects, strict=True):
        assert a.effect == pytest.approx(b.effect, abs=1e-12)
        assert a.interval == pytest.approx(b.interval, abs=1e-12)
        assert (a.verdict, a.p_corrected) == (b.verdict, b.p_corrected)


def test_few_answers_give_wider_effects_than_many() -> None:
    data = simulated(coin=False)
    d = data.demonstrations
    rng = np.random.default_rng(1)
    widths = {}
    for n in (12, len(d)):
        rows = np.sort(rng.permutation(len(d))[:n])
        some = replace(data, demonstrations=d.rows(rows))
        found = find_causes(learn_rules(some, influence=False), data.scenes, ["glass"], ["careful"],
                            settings=SETTINGS)  # fmt: skip
        low, high = found.effects[0].interval or (0.0, 0.0)
        widths[n] = high - low
    assert widths[12] > 1.2 * widths[len(d)]


def test_of_what_the_answers_do_not_speak_nothing_is_said() -> None:
    data = simulated(coin=False)
    rules = learn_rules(data, influence=False)
    normal = rules.rules["normal"]
    assert normal.clearance is not None
    silent = replace(normal, clearance=replace(normal.clearance, uninformed=("bowl",)))
    found = find_causes(replace(rules, rules={"normal": silent}), data.scenes, settings=SETTINGS)
    assert found.effect("normal", "bowl").verdict == "undecided"
    assert "For normal, the answers say nothing about bowls." in found.sentences


def test_draws_are_written_and_read() -> None:
    data = simulated(coin=False)
    rules = learn_rules(data, influence=False)
    document = rules_document(rules)
    assert (
        rules_from_document(document).rules["normal"].clearance == rules.rules["normal"].clearance
    )
    draws = document["types"]["normal"]["clearance"]["draws"]
    assert len(draws) == 40
    low, high = document["types"]["normal"]["clearance"]["interval"]["glass"]
    inside = [low - 1e-9 <= draw["glass"] <= high + 1e-9 for draw in draws]
    assert np.mean(inside) >= 0.9


@pytest.mark.parametrize(
    ("draws", "says"),
    [
        ("all", "draws: expected a list of at most"),
        ([1], "draws.0: expected an object"),
        ([{"glass": "far"}], "draws.0.glass: expected a finite number"),
        ([{"glass": 1e400}], "draws.0.glass: expected a finite number"),
    ],
)
def test_spoilt_draws_are_refused(draws: object, says: str) -> None:
    clearance = {"value": {"glass": 3.0}, "draws": draws}
    with pytest.raises(InputError, match=says):
        rules_from_document({"types": {"normal": {"clearance": clearance}}})
