"""Audit: demonstrations that contradict the rule of the others.

Three witnesses, each with its reason in words: the rule of clearances and constraints that the
*other* demonstrations of the type support (posterior predictive, the demonstration itself left
out; the distances come from the scenes' lists, or from what their pictures show); the same path
labelled both ways; and, where asked for, the surprise of a specification model fitted without the
demonstration.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, ValidityModel, in_one_unit
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.rules import (
    ANYONE,
    ClearanceFit,
    ClearanceRule,
    Constraint,
    Evidence,
    LabelFit,
    Learned,
    Mode,
    clearance_document,
    fit_with_constraints,
    goodness_of,
    kept_by_others,
)
from demospec.rules import fit as fit_evidence
from demospec.specification.audit._conflict import smallest_conflict
from demospec.specification.audit._measured import audit_evidence
from demospec.specification.audit._words import rule_words

REVIEW = 0.8
"""A demonstration is to be reviewed if the others say with more than this probability that its
label is the other one. Chosen on simulated sets (seeds 0 to 5): beside 0.5 it halves the false
reviews, which are demonstrations that alone mark where the rule's boundary lies."""

SURPRISE = 0.01
"""…or if a model fitted without it gives its label less than this probability, where the rule of
the others cannot judge or is itself in doubt. The rule is the better judge, also over distances
that pictures show: alone, the field model found 47 % of the detectable flips at this threshold
(seeds 0 and 1, 16 scenes)."""

DOUBT = 0.2
"""The rule of the others is in doubt above this probability that the label is wrong."""

_CLOSER_LOOK = 0.1

_SLIPS = 0.1
"""Somebody who gives the other answer less often than this may slip: those labels are doubted."""

_UNEXPLAINED = 0.2
"""A rule over what pictures show that contradicts more of its own labels than this says nothing:
what matters was not seen."""

_MISSED = 4
"""So many rejected paths of one type, and at least half of all that it rejects in a scene, that go
free of everything seen there: that a thing was missed is likelier than so many slips in one
place. Tried with four alone, it brought the false reviews from 2.4 % to 1.6 % and the recall from
86 % to 84 % (seeds 0 to 5)."""

LEFT_OUT_MODE: Mode = "quick"
"""How the rule of the others is found where one demonstration is left out, see `Mode`."""

Fit = Callable[[DemonstrationSet], ValidityModel]


@dataclass(frozen=True)
class AuditEntry:
    """The verdict on one demonstration.

    Args:
        verdict: ``pass`` or ``review``.
        why: One sentence.
        p_wrong: Probability, by the rule of the others, that the label is the other one; None
            where no rule could judge.
        p_label: Probability that a model fitted without it gives to its label, or None.
    """

    demo_id: str
    verdict: str
    why: str
    p_wrong: float | None = None
    p_label: float | None = None


@dataclass(frozen=True)
class Audit:
    """What `audit_set` found.

    Args:
        conflict: A smallest set of demonstrations that cannot all be right under one
            noise-free clearance rule, or None.
        entries: One for each demonstration, in the order of the set.
        notes: What could not be judged, and why.
        rules: By type, the rule that all its demonstrations support: that of `learn_rules`.
        fits: By type, how well that rule explains the labels; labels are doubted only under a rule
            that explains them, at least partly.
        constraints: By type, what it asks for besides clearances.
    """

    conflict: tuple[str, ...] | None
    entries: tuple[AuditEntry, ...]
    notes: tuple[str, ...] = ()
    rules: Mapping[str, ClearanceRule] = field(default_factory=dict)
    fits: Mapping[str, LabelFit] = field(default_factory=dict)
    constraints: Mapping[str, tuple[Constraint, ...]] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """The JSON document of ``demospec audit``."""
        return {
            "conflict": None if self.conflict is None else list(self.conflict),
            "demonstrations": [
                {
                    "demo_id": e.demo_id,
                    "verdict": e.verdict,
                    "why": e.why,
                    "p_wrong": _rounded(e.p_wrong),
                    "p_label": _rounded(e.p_label),
                }
                for e in self.entries
            ],
            "notes": list(self.notes),
            "mode": "full",
            "left_out_mode": LEFT_OUT_MODE,
            "types": {
                name: {
                    "clearance": clearance_document(rule),
                    **(
                        {"constraints": [c.to_json() for c in self.constraints[name]]}
                        if self.constraints.get(name)
                        else {}
                    ),
                    **({"fit": self.fits[name].to_json()} if name in self.fits else {}),
                }
                for name, rule in self.rules.items()
            },
        }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def audit_set(
    data: DemonstrationSet,
    *,
    fit: Fit | None = None,
    folds: int = 5,
    seed: int = 0,
    progress: Progress = silent,
) -> Audit:
    """Looks for wrong labels.

    Args:
        data: At least one labelled demonstration. All splits are looked at.
        fit: Makes a specification model from a set; gives the second opinion. None: the rule
            of the others alone.
        folds: For the model: demonstrations left out at a time, n / folds.
        seed: Of the folds.
        progress: Told of each type and fold.

    Raises:
        InputError: No labels at all, or neither objects listed nor pictures nor a model.
        MissingExtraError: No objects listed, no model, and torch is absent.
    """
    data = in_one_unit(data)
    d = data.demonstrations
    labelled = d.valid >= 0
    if not labelled.any():
        raise InputError("demonstrations labelled valid or not", "none", field="valid")
    evidence, why_not = audit_evidence(
        data, labelled, needed=fit is None, seed=seed, progress=progress
    )
    judge = _RuleJudge(data, evidence)
    if evidence is not None:
        judge.of_everybody(progress)
    p_label = np.full(len(d), np.nan)
    if fit is not None:
        p_label = _surprise(data, labelled, fit, folds, seed, progress)
    twins = _opposed_twins(data)
    entries = [_entry(data, row, judge, twins, p_label) for row in range(len(d))]
    notes = []
    if not labelled.all():
        notes.append(f"{int((~labelled).sum())} demonstrations have no label: not judged")
    if judge.seen.any():
        notes.append(
            f"{int(judge.seen.sum())} demonstrations in scenes without listed objects: judged by "
            "what their pictures show, which is less sure than a list"
        )
    blind = labelled & ~judge.known
    if blind.any():
        why = f" ({why_not})" if why_not is not None else ""
        notes.append(f"{int(blind.sum())} demonstrations in scenes without listed objects{why}")
    notes += judge.notes
    names = None if judge.conflict is None else tuple(str(d.demo_id[r]) for r in judge.conflict)
    return Audit(names, tuple(entries), tuple(notes), judge.rules, judge.fits, judge.asked)


class _RuleJudge:
    """Judges every demonstration by the rule that the others of its type follow."""

    def __init__(self, data: DemonstrationSet, evidence: Evidence | None) -> None:
        n = len(data.demonstrations)
        self.data = data
        self.evidence = evidence
        self.known, self.seen = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        if evidence is not None:
            self.known[evidence.rows] = True
            self.seen[evidence.rows] = evidence.seen
        self.p_wrong = np.full(n, np.nan)
        self.rules: dict[str, ClearanceRule] = {}
        self.fits: dict[str, LabelFit] = {}
        self.asked: dict[str, tuple[Constraint, ...]] = {}
        self.unexplained = np.zeros(n, dtype=bool)
        self.by: dict[int, tuple[ClearanceRule, Mapping[str, float]]] = {}
        self.conflict: list[int] | None = None
        self.notes: list[str] = []

    def of_everybody(self, progress: Progress) -> None:
        """Judges everybody by the posterior that all commands speak from."""
        assert self.evidence is not None
        types = set(self.data.demonstrations.type.tolist())
        # Who has no type beside others who have one is nobody's company.
        apart = (self.evidence.person == ANYONE) & (ANYONE not in types) & (types != {None})
        for keep in (~apart, apart):
            if keep.any() and len(self.evidence.columns):
                self._of_people(self.evidence.view(keep), progress)

    def _of_people(self, evidence: Evidence, progress: Progress) -> None:
        posterior, beside = fit_with_constraints(self.data, evidence)
        people = posterior.people
        unseen = np.zeros(len(evidence), dtype=bool)
        for name, found in people.items():
            mine = np.flatnonzero(evidence.person == name)
            seen = evidence.seen[mine]
            wrong = np.isin(np.flatnonzero(seen), found.contradicted)
            if wrong.sum() > _UNEXPLAINED * len(wrong):
                who = "these demonstrations" if name == ANYONE else name
                self.notes.append(f"what matters to {who} was not seen in the pictures: not judged")
                unseen[mine[seen]] = True
        if unseen.any():
            evidence = evidence.view(~unseen)
            people, beside = {}, {}
            if evidence.persons:
                posterior, beside = fit_with_constraints(self.data, evidence)
                people = posterior.people
        for i, (name, own) in enumerate(evidence.by_person().items()):
            self.rules[name] = people[name].rule
            asked = beside.get(name)
            if asked is not None and not asked.constraints:
                asked = None
            self.fits[name] = tested = goodness_of(self.data, own, people[name], asked)
            if asked is not None:
                self.asked[name] = asked.constraints
            who = "these answers" if name == ANYONE else f"the answers of {name}"
            if tested.verdict == "not" and not _nearly_one_answer(own):
                self.notes.append(
                    f"distance to the listed objects does not explain {who} "
                    f"({tested.contradicted} of {tested.n} contradict the best rule, "
                    f"p = {tested.p_chance:.2g}): no label is doubted by it"
                )
                self.unexplained[own.rows] = True
            elif len(own) > 1:
                if tested.verdict == "partly" and tested.explained:
                    self.notes.append(
                        f"the rule explains {tested.explained:.0%} of {who}: "
                        "labels that contradict it may be right"
                    )
                self._of_person(own, people[name], name, asked)
            progress("audit", i + 1, len(people))

    def _of_person(
        self, own: Evidence, whole: ClearanceFit, name: str, asked: Learned | None
    ) -> None:
        rows = own.rows
        in_sample = _against(whole, own)
        if asked is not None:
            self.p_wrong[rows] = _against_all(whole, own, asked)
            self.by |= {int(row): (whole.rule, own.at(i)) for i, row in enumerate(rows)}
            return
        self.p_wrong[rows] = in_sample
        self.by |= {int(row): (whole.rule, own.at(i)) for i, row in enumerate(rows)}
        # A demonstration draws the rule to itself: those that may be wrong are judged by a rule
        # fitted without them. Leaving out one that the rule agrees with changes little.
        for i in np.flatnonzero(in_sample > _CLOSER_LOOK):
            others = np.arange(len(own)) != i
            apart = fit_evidence(own.view(others), mode=LEFT_OUT_MODE).people[name]
            self.by[int(rows[i])] = apart.rule, own.at(int(i))
            self.p_wrong[rows[i]] = _against(apart, own.view(~others))[0]
        self._spare_what_was_missed(rows[own.seen], name)
        exact = np.flatnonzero(~own.seen)
        found = smallest_conflict(own.values[exact], own.valid[exact])
        if found is not None and (self.conflict is None or len(found) < len(self.conflict)):
            self.conflict = [int(rows[exact[i]]) for i in found]

    def _spare_what_was_missed(self, rows: NDArray[np.int64], name: str) -> None:
        d = self.data.demonstrations
        doubted = rows[(self.p_wrong[rows] > REVIEW) & (d.valid[rows] == 0)]
        rejected = rows[d.valid[rows] == 0]
        for scene in dict.fromkeys(d.scene_id[doubted].tolist()):
            mine = doubted[d.scene_id[doubted] == scene]
            if len(mine) < max(_MISSED, np.sum(d.scene_id[rejected] == scene) / 2):
                continue
            self.p_wrong[mine] = np.nan
            who = "" if name == ANYONE else f" of {name}"
            self.notes.append(
                f"scene {scene}: {len(mine)} rejected paths{who} keep clear of all that was seen: "
                "something was probably missed there, so they are not judged"
            )


def _nearly_one_answer(own: Evidence) -> bool:
    """Whether somebody gave one answer but for what may be slips."""
    return bool(min(own.valid.sum(), (~own.valid).sum()) <= _SLIPS * len(own))


def _against(fit: ClearanceFit, own: Evidence) -> FloatArray:
    """(n,) posterior probability that the rule's verdict is not the label.

    A distance that was seen is uncertain, by an error that all distances of a path share.
    """
    p = fit.p_valid(own.values)
    error = own.error.max(axis=1, initial=0.0)
    blurred = np.flatnonzero(error > 0)
    if len(blurred):
        steps, weights = np.polynomial.hermite_e.hermegauss(5)
        shifts = error[blurred, None] * steps
        p[blurred] = sum(
            w * fit.p_valid(own.values[blurred] + shifts[:, k, None])
            for k, w in enumerate(weights / weights.sum())
        )
    return np.asarray(np.where(own.valid, 1.0 - p, p))


def _against_all(fit: ClearanceFit, own: Evidence, asked: Learned) -> FloatArray:
    """(n,) probability that the verdict of clearances and constraints is not the label.

    Thresholds of constraints are those of the other labels; which constraints they are, and the
    clearances beside them, are those of all labels.
    """
    limit = np.array([fit.rule.value.get(name, -np.inf) for name in own.names])
    near = np.asarray((own.values >= limit).all(axis=1))
    p = kept_by_others(asked, own.valid, near) * fit.p_valid(own.values)
    return np.asarray(np.where(own.valid, 1.0 - p, p))


def _surprise(
    data: DemonstrationSet,
    labelled: NDArray[np.bool_],
    fit: Fit,
    folds: int,
    seed: int,
    progress: Progress,
) -> FloatArray:
    """(n,) probability that a model fitted without it gives to each label; NaN without a label."""
    d = data.demonstrations
    rows = np.flatnonzero(labelled)
    if folds < 2 or len(rows) < folds:
        raise InputError(f"2 to {len(rows)} folds (labelled demonstrations)", folds, field="folds")
    fold = np.random.default_rng(seed).permutation(np.arange(len(rows)) % folds)
    out = np.full(len(d), np.nan)
    for k in range(folds):
        model = fit(data.select(rows[fold != k]))
        held = rows[fold == k]
        for scene_id in dict.fromkeys(d.scene_id[held].tolist()):
            view = model.see(data.scene(scene_id))
            for name in dict.fromkeys(d.type[held].tolist()):
                mine = held[(d.scene_id[held] == scene_id) & (d.type[held] == name)]
                if len(mine) and name in model.types:
                    p = np.asarray(view.p_valid(data.motions(mine), name))
                    out[mine] = np.where(d.valid[mine] == 1, p, 1.0 - p)
        progress("model", k + 1, folds)
    return out


def _opposed_twins(data: DemonstrationSet) -> dict[int, int]:
    """Row → another row with the same scene, type and path, and the other label."""
    d = data.demonstrations
    first: dict[tuple[Any, ...], dict[int, int]] = {}
    for row in range(len(d)):
        if d.valid[row] >= 0:
            key = (d.scene_id[row], d.type[row], d.points(row).tobytes())
            first.setdefault(key, {}).setdefault(int(d.valid[row]), row)
    twins: dict[int, int] = {}
    for rows in first.values():
        if len(rows) == 2:
            twins |= {rows[0]: rows[1], rows[1]: rows[0]}
    return twins


def _entry(
    data: DemonstrationSet,
    row: int,
    judge: _RuleJudge,
    twins: dict[int, int],
    p_label: FloatArray,
) -> AuditEntry:
    d = data.demonstrations
    name = str(d.demo_id[row])
    p_wrong = None if np.isnan(judge.p_wrong[row]) else float(judge.p_wrong[row])
    by_model = None if np.isnan(p_label[row]) else float(p_label[row])
    reasons = []
    if d.valid[row] < 0:
        return AuditEntry(name, "pass", "no label to judge")
    if p_wrong is not None and p_wrong > REVIEW:
        rule, near = judge.by[row]
        name_of = d.type[row] if d.type[row] is not None else ANYONE
        asked = judge.asked.get(str(name_of), ())
        reasons.append(rule_words(data, row, rule, near, bool(judge.seen[row]), asked))
    if row in twins:
        reasons.append(f"the same path as {d.demo_id[twins[row]]}, which has the other label")
    open_question = p_wrong is None or p_wrong > DOUBT
    if by_model is not None and by_model < SURPRISE and (open_question or reasons):
        reasons.append(
            f"a model fitted without it gives this label a probability of {by_model:.1%}"
        )
    if reasons:
        return AuditEntry(name, "review", "; ".join(reasons), p_wrong, by_model)
    if p_wrong is None and by_model is None:
        why = "what matters was not seen" if judge.known[row] else "no objects listed"
        if judge.unexplained[row]:
            why = "the rule does not explain these answers"
        return AuditEntry(name, "pass", f"not judged: {why}")
    return AuditEntry(name, "pass", "agrees with the others", p_wrong, by_model)
