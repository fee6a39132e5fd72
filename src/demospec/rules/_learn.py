"""Rules of every user type from a demonstration set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet, in_one_unit
from demospec.frames import describe_length
from demospec.progress import Progress, silent
from demospec.rules._evidence import Evidence
from demospec.rules._fit import FitMemory, Posterior
from demospec.rules._fit_to_labels import conjunction_wrong, goodness_of
from demospec.rules._goodness import Fit, with_doubt
from demospec.rules._measurement import Measure, Passing, evidence_of
from demospec.rules._rule_set import ANYONE, RuleSet, TypeRules
from demospec.rules._sentences import clearance_words, listed, plural
from demospec.rules._verdicts import decided_by
from demospec.rules.clearance._encounters import passes
from demospec.rules.clearance._fit import ClearanceFit, drawn, fit_document
from demospec.rules.clearance._measure import Distance, nearest_approach
from demospec.rules.clearance._posterior import Sharing
from demospec.rules.constraints._beside import fit_with_constraints
from demospec.rules.constraints._learned import Learned
from demospec.rules.influence._of_set import influence_answer
from demospec.rules.influence._sentences import influence_words


def learn_rules(
    data: DemonstrationSet,
    *,
    sharing: Sharing = "average",
    distance: Distance = "footprint",
    split: str | None = "train",
    influence: bool = True,
    settings: Mapping[str, Any] | None = None,
    measure: Measure = nearest_approach,
    passing: Passing = passes,
    memory: FitMemory | None = None,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
) -> RuleSet:
    """What every user type of a set keeps away from, and how far.

    Args:
        data: At least one labelled demonstration in a scene that lists its objects. Pictures of
            different scale are learned from in metres (`in_one_unit`). Labels
            that are null are ignored with a note; types that are null too, unless no
            demonstration has one: then all are pooled under `ANYONE`.
        sharing: See `fit_clearance`.
        distance: Clearances to the ``footprint`` or to the ``center``.
        split: Learn from scenes of this split (all where none is so marked).
        influence: Answer with the influence family too: thresholds by class about the
            centres, scenes pooled, within five seconds a type. Null, with the reason under
            ``evidence``, where it does not apply.
        settings: Of the influence problem: ``F_max``, ``reading``, ``preset``, ….
        measure, passing: See `evidence_of`.
        memory: See `fit`.
        workers, cluster: As of `run_tasks`: paths are measured there, scene by scene; the
            rules that follow are found in this process.

    Raises:
        CannotJudgeError: No scene lists its objects.
        InputError: No label; pictures of which only some have a scale.
    """
    data = in_one_unit(data)
    seen = evidence_of(
        data, split=split, distance=distance, measure=measure, passing=passing, workers=workers,
        cluster=cluster, progress=progress,
    )  # fmt: skip
    found, asked = fit_with_constraints(data, seen, sharing=sharing, memory=memory)
    notes = list(seen.notes)
    notes += [
        f"no demonstration to learn from for type {name}"
        for name in data.types
        if name not in found.people and ANYONE not in found.people
    ]
    order = [name for name in (*data.types, ANYONE) if name in found.people]
    rules: dict[str, TypeRules] = {}
    for i, name in enumerate(order):
        rules[name] = _type_rules(data, seen, found, name, settings or {}, influence, asked)
        progress("rules", i + 1, len(order))
    return RuleSet(rules, data.units, data.metres_per_unit, tuple(notes))


def _type_rules(
    data: DemonstrationSet,
    seen: Evidence,
    found: Posterior,
    name: str,
    settings: Mapping[str, Any],
    influence: bool,
    asked: Mapping[str, Learned],
) -> TypeRules:
    own, fit = found.evidence.of_person(name), found.people[name]
    every = seen.of_person(name)
    beside = asked.get(name)
    valid = every.valid
    evidence: dict[str, Any] = {
        "n": len(valid),
        "accepted": int(valid.sum()),
        "rejected": int((~valid).sum()),
        **fit_document(fit, own),
        "mode": found.mode,
    }
    if not fit.contradicted and own.preferences is None:
        evidence["decided"] = decided_by(fit.rule.value, own.names, own.values, own.valid)
    if beside is not None:
        evidence["constraints"] = beside.document
    answer = None
    if influence:
        answer, reason = influence_answer(data, every.rows, valid, settings)
        words = ""
        if answer is not None:
            words = influence_words(answer, data.metres_per_unit, data.units)
        evidence["influence"] = words or reason
    tested = goodness_of(data, every, fit, beside)
    rule = replace(fit.rule, draws=drawn(fit.particles, fit.symbols))
    if beside is None or not beside.constraints:
        return TypeRules(rule, answer, type_sentence(data, fit, own, tested), evidence, tested)
    wrong = conjunction_wrong(every, fit, beside)
    evidence["contradicted"] = [str(every.demo_id[i]) for i in np.flatnonzero(wrong)]
    sentence = listed([c.sentence for c in beside.constraints])
    if fit.rule.value:
        sentence = f"{type_sentence(data, fit, own)}; and {sentence}"
    sentence = with_doubt(sentence, tested)
    return TypeRules(rule, answer, sentence, evidence, tested, beside.constraints)


def type_sentence(
    data: DemonstrationSet, fit: ClearanceFit, own: Evidence, tested: Fit | None = None
) -> str:
    """The clearance rule of one type in plain words, with its doubt where it was tested."""
    scale, units, valid = data.metres_per_unit, data.units, own.valid
    if valid.all() and not own.pairs:
        return _positive_only(fit, scale, units, own.unit)
    text = clearance_words(
        fit.rule.value,
        fit.symbols,
        fit.rule.uninformed,
        metres_per_unit=scale,
        units=units,
        distance=fit.rule.distance,
        interval=fit.rule.interval,
        undecided=fit.undecided,
        instead=fit.confounded,
    )
    if not valid.any() and not own.pairs:
        return f"{text}; no demonstration was accepted, so that larger distances are not ruled out"
    return text if tested is None else with_doubt(text, tested)


def _positive_only(fit: ClearanceFit, scale: float | None, units: str, unit: float) -> str:
    """What accepted demonstrations alone say: what matters is not known."""
    text = "no demonstration was rejected: what matters is not known"
    kept = {s: c for s, c in fit.at_most.items() if 0.05 * unit < c < np.inf}
    if kept:
        parts = [
            f"{describe_length(c, scale, units)} from {plural(s)}" for s, c in sorted(kept.items())
        ]
        text += f" (as near as {listed(parts)} was accepted; nearer may be, too)"
    return text
