"""Types found, solutions, overlap and relevant symbols in a reproduction; met and not met."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from demospec.demonstrations import simulate_set
from demospec.experiments.paper._beside import (
    accuracy_rows,
    causes_rows,
    identification_rows,
    repair_rows,
)
from demospec.experiments.paper._page_solutions import (
    but_for_reading,
    first_k,
    identification_reading,
    relevance_reading,
)
from demospec.experiments.paper._solutions import (
    _overlap,
    _round_everything,
    _samples,
    identification,
)
from demospec.rules import ClearanceRule, RuleSet, TypeRules, rules_from_document


@pytest.fixture(scope="module")
def small():  # type: ignore[no-untyped-def]
    data, document = simulate_set(train_scenes=0, test_scenes=4, demonstrations=9, seed=4)
    return data, rules_from_document(document)


def test_the_truth_finds_types_more_often_from_more_demonstrations(small) -> None:  # type: ignore[no-untyped-def]
    data, truth = small
    found = identification(truth, data, 30, 0)
    assert found["n"] == 90
    assert found["k"] == list(range(1, 21))
    labelled = found["labelled"]
    assert labelled[0] < labelled[-1]
    assert labelled[-1] > 0.9
    # The paper's formula lets whoever accepts everything share the top: never all are found.
    printed = [v for v in found["printed"] if v is not None]
    assert max(printed) < 0.7
    # Few accepted demonstrations: nothing is said where somebody has too few.
    least = min(found["pool"]["accepted"].values())
    assert [v is None for v in found["accepted"]] == [k > least for k in range(1, 21)]


def test_solutions_of_the_truth_are_valid_and_overlaps_have_intervals(small) -> None:  # type: ignore[no-untyped-def]
    data, truth = small
    drawn = _samples(truth, data.scenes[:1], truth, 4, 0)
    assert all(v["n"] == v["valid_by_truth"] == 4 for v in drawn.values())
    assert all(v["regions"] == v["regions_of_truth"] for v in drawn.values())
    pairs = {tuple(p["types"]): p for p in _overlap(truth, data.scenes[:2], 0)}
    assert len(pairs) == 3
    for pair in pairs.values():
        assert pair["interval"][0] <= pair["overlap"] <= pair["interval"][1]
    # careful within normal within everything: the wider the other, the less is shared.
    assert pairs["careful", "aggressive"]["overlap"] <= pairs["careful", "normal"]["overlap"]


def test_without_causes_a_planner_keeps_the_largest_clearance_from_everything() -> None:
    rule = ClearanceRule({"glass": 4.0, "plate": 2.0}, {"glass": (3.0, 6.0), "plate": (1.0, 9.0)})
    rules = RuleSet({"a": TypeRules(rule), "b": TypeRules(ClearanceRule({}))})
    wide = _round_everything(rules, ("glass", "plate", "bowl"))
    for type_ in ("a", "b"):  # who keeps nothing gets the largest of the others
        clearance = wide.rules[type_].clearance
        assert clearance.value == {"glass": 4.0, "plate": 4.0, "bowl": 4.0}
        assert set(clearance.interval.values()) == {(4.0, 9.0)}


def _identified(shares: list[float | None], n: int = 600) -> dict[str, Any]:
    own = {"k": list(range(1, len(shares) + 1)), "n": n, "accepted": shares, "labelled": shares}
    return {"identification": own}


def test_the_printed_share_is_reached_where_no_later_one_lies_below_it() -> None:
    assert first_k(_identified([0.5, 0.99, 0.9, 0.985, 0.995]), "accepted", 0.99) == 4
    assert first_k(_identified([0.5, 0.6]), "accepted", 0.99) is None
    assert first_k(_identified([0.99, None]), "accepted", 0.99) == 1
    found = {m: _identified([0.5, v]) for m, v in
             (("paper", 0.4), ("field", 0.99), ("truth", 1.0))}  # fmt: skip
    told = identification_reading(found)
    assert "paper's model, refitted never, 50.0\u00a0% at best" in told[0]
    assert "field (ours) from k\u00a0=\u00a02 on" in told[0]
    assert [r.verdict for r in identification_rows(found)] == ["not met", "met", "met"]


def test_relevance_says_what_was_left_out_and_what_was_lost() -> None:
    def plans(kept: int, length: float) -> dict[str, Any]:
        return {"normal": {"scenes": 9, "planned": 9, "kept": kept, "length": length}}

    document: dict[str, Any] = {
        "rules": {"learned": plans(9, 1.2), "relevant": plans(9, 1.1), "everything": plans(9, 1.4)},
        "left_out": {"normal": ["plate", "bowl"]},
        "needed_by_truth": {"normal": ["glass"]},
    }
    told = relevance_reading(document)
    assert told[0] == "normal: left out of the cost map plate, bowl."
    assert "nothing is lost" in told[1]
    document["rules"]["relevant"] = plans(7, 1.0)
    document["needed_by_truth"] = {"normal": ["bowl"]}
    told = relevance_reading(document)
    assert "the true rule needs bowl" in told[0]
    assert "2 plans are lost" in told[1]


def test_rejected_paths_are_compared_with_the_true_rule_case_by_case() -> None:
    def case(demo: str, *causes: str) -> dict[str, Any]:
        kind = "one" if causes else "none"
        return {"demo_id": demo, "causes": list(causes), "kind": kind, "scene_id": "s",
                "sentence": "had it not been there."}  # fmt: skip

    found = {
        "truth": {"but_for": [case("a", "glass-0"), case("b")]},
        "field": {"but_for": [case("a", "glass-0"), case("b", "bowl-1")]},
    }
    told = but_for_reading(found)
    assert "same objects as the true rule in 1 of 2 cases" in told[0]
    assert told[1].startswith("One case, by the true rule, scene s:")


def test_verdicts_follow_the_numbers() -> None:
    def share(value: float | None, n: int = 200) -> dict[str, Any]:
        return {"vacuous": value is None, "n": n, "repaired_by_truth": value}

    def results(careful: float) -> dict[str, Any]:
        by = {"careful": share(careful), "normal": share(0.99), "aggressive": share(None, 0)}
        return {m: {"1": by} for m in ("paper", "field")}

    verdicts = [r.verdict for r in repair_rows(results(0.5))][:3]
    assert verdicts[:2] == ["not met", "met"]
    assert verdicts[2].startswith("not comparable, because")
    assert repair_rows(results(0.74))[0].verdict == "met"  # its interval reaches 75 %

    def curve(values: list[float]) -> list[dict[str, Any]]:
        types = ("a", "b")
        return [{"model": "full", "n": n, "type": t, "accuracies_seen": [v, v]}
                for n, v in zip((1, 9), values, strict=True) for t in types]  # fmt: skip

    assert [r.verdict for r in accuracy_rows(curve([0.8, 0.9]), "uniform")] == ["met", "not met"]
    assert [r.verdict for r in accuracy_rows(curve([0.6, 0.99]), "uniform")] == ["not met", "met"]


def test_causes_are_met_only_where_every_cell_is() -> None:
    printed = {("careful", s) for s in ("utensil", "plate", "bowl", "glass")}
    printed |= {("normal", "glass")}
    cells = [{"type": t, "symbol": s, "causal": (t, s) in printed}
             for t in ("careful", "normal", "aggressive")
             for s in ("utensil", "plate", "bowl", "glass")]  # fmt: skip
    types = [{"from": "careful", "to": "normal", "interval": [0.1, 0.3]}]
    base = {"careful": {"mean": 0.43}}
    good: dict[str, Any] = {"effects": cells, "types": types, "base": base}
    bad = {**good, "effects": [{**cells[0], "causal": False}, *cells[1:]],
           "types": [{**types[0], "interval": [0.3, 0.4]}]}  # fmt: skip
    rows = causes_rows({"paper": bad, "field": good, "truth": good})
    assert [r.verdict for r in rows[:4]] == ["not met", "not met", "met", "met"]
    assert rows[0].ours == "the same in 11 of 12"
    assert replace(rows[4]).verdict.startswith("not comparable")
