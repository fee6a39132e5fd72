"""Identification, sampled solutions, overlap of types, and plans by relevant symbols alone.

Everything is in unseen scenes and judged by the truth; the truth asked as a model is the limit
that the demonstrations themselves set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any, Final

import numpy as np

from demospec.experiments.paper._by_model import MODELS, model_of, set_of, truth_of
from demospec.progress import Progress

SHOWN: Final = tuple(range(1, 21))
"""Numbers of demonstrations from which somebody's type is to be found."""


@dataclass(frozen=True)
class SolutionsTask:
    """What one model is asked.

    Args:
        draws: Demonstrators of each type for each number of demonstrations.
        scenes: Unseen scenes in which solutions are sampled.
        samples: Solutions a scene and type.
    """

    folder: Path
    model: str
    draws: int
    scenes: int
    samples: int
    seed: int


def solutions_of(task: SolutionsTask) -> dict[str, Any]:
    """Identification, samples and overlap of one model."""
    model = model_of(task.folder, task.model)
    test = set_of(task.folder).of_split("test")
    scenes = test.scenes[: task.scenes]
    return {
        "identification": identification(model, test, task.draws, task.seed),
        "samples": _samples(model, scenes, truth_of(task.folder), task.samples, task.seed),
        "overlap": _overlap(model, scenes, task.seed),
    }


def solutions_by_model(
    folder: Path, draws: int, scenes: int, samples: int, seed: int, workers: int, progress: Progress
) -> dict[str, Any]:
    """Model → what it finds."""
    from demospec.parallel import run_tasks

    tasks = [SolutionsTask(folder, name, draws, scenes, samples, seed) for name in MODELS]
    found = run_tasks(solutions_of, tasks, workers=workers, progress=progress, what="solutions")
    return dict(zip(MODELS, found, strict=True))


def identification(model: Any, data: Any, draws: int, seed: int) -> dict[str, Any]:
    """Share of demonstrators whose type is found from k of their demonstrations.

    ``accepted``: they show what they accept, and nothing is said of the rest. ``labelled``: they
    say of k random paths which they accept. ``printed``: the paper's arg max Σ log C_s on
    accepted ones; types at the top together share the demonstrator.

    Returns:
        By way of showing: a share for each k of `SHOWN`, in which types count alike; None where
        some type has fewer than k. `n` is how many demonstrators a share is of, `pool` how many
        demonstrations of each type theirs are drawn from.
    """
    from demospec.specification import acceptances, type_posterior

    d = data.demonstrations
    accepted = data.select(d.valid == 1)
    sets = {"accepted": accepted, "labelled": data, "printed": accepted}
    asked = {id(s): acceptances(model, s)[:2] for s in (accepted, data)}
    out: dict[str, Any] = {"k": list(SHOWN), "n": draws * len(model.types), "pool": {}}
    for way, shown in sets.items():
        found, judged = asked[id(shown)]
        who = np.array([shown.demonstrations.type[i] for i in judged])
        out["pool"][way] = {t: int((who == t).sum()) for t in found.types}
        shares: list[float | None] = []
        for k in SHOWN:
            if min(out["pool"][way].values()) < k:
                shares.append(None)
                continue
            rng = np.random.default_rng([seed, k])
            hits = 0.0
            for t, type_ in enumerate(found.types):
                mine = np.flatnonzero(who == type_)
                for _ in range(draws):
                    part = found.rows(rng.choice(mine, size=k, replace=False))
                    score = (
                        np.log(np.maximum(part.c, 1e-12)).sum(axis=0)
                        if way == "printed"
                        else type_posterior(part)
                    )
                    top = np.isclose(score, score.max(), rtol=1e-9, atol=1e-12)
                    hits += float(top[t]) / float(top.sum())
            shares.append(hits / (draws * len(found.types)))
        out[way] = shares
    return out


def _samples(
    model: Any, scenes: Sequence[Any], truth: Any, samples: int, seed: int
) -> dict[str, Any]:
    """Type → solutions sampled, accepted by the truth, diversity, and ways to pass."""
    from demospec.specification import sample_valid

    out: dict[str, Any] = {}
    for type_ in truth.types:
        n = good = 0
        diversity, found, ways = [], [], []
        for scene in scenes:
            drawn = sample_valid(model.see(scene), type_, samples, seed=seed, size=31)
            own = sample_valid(truth.see(scene), type_, 1, seed=seed, size=31)
            ways.append(own.modes)
            found.append(drawn.modes)
            if len(drawn.points) == 0:
                continue
            n += len(drawn.points)
            good += int((truth.see(scene).p_valid(drawn.points, type_) > 0.5).sum())
            diversity.append(drawn.diversity)
        out[type_] = {
            "n": n,
            "valid_by_truth": good,
            "diversity": float(np.mean(diversity)) if diversity else None,
            "regions": float(np.mean(found)),
            "regions_of_truth": float(np.mean(ways)),
            "scenes": len(scenes),
        }
    return out


def _overlap(model: Any, scenes: Sequence[Any], seed: int) -> list[dict[str, Any]]:
    """Mean overlap of every two types over scenes, with its interval."""
    from demospec.causal import mean_interval
    from demospec.specification import overlap_of_types

    found = [overlap_of_types(model.see(scene), model.types, size=31) for scene in scenes]
    out = []
    for a, b in combinations(model.types, 2):
        shares = [s for s in (o.share(a, b) for o in found) if s is not None]
        ends = mean_interval(shares, seed=seed, bounds=(0.0, 1.0)) if shares else None
        out.append(
            {
                "types": [a, b],
                "overlap": float(np.mean(shares)) if shares else None,
                "interval": None if ends is None else list(ends),
                "n_scenes": len(shares),
            }
        )
    return out


def relevant_plans(folder: Path, learned: Any, scenes: Sequence[Any], progress: Progress) -> Any:
    """Plans by all learned rules, by the relevant symbols alone, and round everything.

    Which symbols are relevant is read from the effects on the field model (`causes.json`):
    the table feeds the cost map. ``everything`` keeps a type's largest clearance from every
    symbol: what a planner has to do that was told of no causes.
    """
    from demospec.causal import findings_from_document, rules_of_causes
    from demospec.experiments import plan_study
    from demospec.files import read_json

    findings = findings_from_document(read_json(folder / "causes.json")["field"])
    relevant = rules_of_causes(learned, findings)
    sets = {
        "learned": learned,
        "relevant": relevant,
        "everything": _round_everything(learned, findings.symbols),
    }
    truth = truth_of(folder)
    out = {}
    for name, rules in sets.items():
        plans = plan_study(rules, scenes, truth, progress)["plans"]
        out[name] = _summary(plans, rules.types)
    left_out = {
        t: [s for s in findings.symbols if s not in _symbols(relevant, t)] for t in relevant.types
    }
    needed = {t: list(_symbols(truth, t)) for t in truth.types}
    return {"rules": out, "left_out": left_out, "needed_by_truth": needed}


def _symbols(rules: Any, type_: str) -> tuple[str, ...]:
    rule = rules.rules[type_].clearance
    return () if rule is None else tuple(rule.value)


def _round_everything(rules: Any, symbols: Sequence[str]) -> Any:
    """Every type keeps its largest interval from every symbol; who keeps none, the largest."""
    from demospec.rules import ClearanceRule, TypeRules

    def largest(rule: Any) -> tuple[float, float]:
        ends = [rule.interval.get(s, (c, c)) for s, c in rule.value.items()]
        known = [high for _, high in ends if np.isfinite(high)]
        return max(rule.value.values()), max([*known, *rule.value.values()])

    of = {t: largest(r.clearance) for t, r in rules.rules.items()
          if r.clearance is not None and r.clearance.value}  # fmt: skip
    most = max(of.values(), key=lambda ends: ends[1], default=(0.0, 0.0))
    out = {}
    for type_ in rules.rules:
        value, high = of.get(type_, most)
        interval = dict.fromkeys(symbols, (value, high))
        out[type_] = TypeRules(ClearanceRule(dict.fromkeys(symbols, value), interval))
    return replace(rules, rules=out)


def _summary(plans: Sequence[dict[str, Any]], types: Sequence[str]) -> dict[str, Any]:
    """Type → planned, keeps the true rule, mean length against the straight line."""
    out = {}
    for type_ in types:
        mine = [p for p in plans if p["type"] == type_]
        found = [p for p in mine if p["status"] == "found"]
        ratio = [p["length"] / p["straight"] for p in found]
        out[type_] = {
            "scenes": len(mine),
            "planned": len(found),
            "kept": sum(bool(p["true_obeys"]) for p in found),
            "length": float(np.mean(ratio)) if ratio else None,
        }
    return out
