"""Rules of causes: the learned rules, without the symbols that have no effect.

The rule learner says how far; the interventions say whether at all. What comes out is a rule
file like any other: planning and the other commands read it without knowing about causes.
"""

from __future__ import annotations

from dataclasses import replace

from demospec.causal._results import CausalFindings
from demospec.rules import ClearanceRule, RuleSet, TypeRules, plural


def rules_of_causes(rules: RuleSet, findings: CausalFindings) -> RuleSet:
    """`rules` cut down to what the interventions leave standing.

    A symbol is left out of a type's clearance only where the findings say ``none`` (the whole
    interval of its effect lies within ± the minimum effect). What is causal, undecided or was
    never tried stays: a planner then errs on the safe side. A causal symbol for which the
    rules know no clearance cannot be invented and is named in the notes. Influence answers are
    kept only where nothing was left out, because their radii were fitted together.

    Args:
        rules: Learned from demonstrations, or the truth.
        findings: Of any model with the same types and symbols.
    """
    notes = list(rules.notes)
    kept = {}
    for type_, entry in rules.rules.items():
        kept[type_] = _of_type(type_, entry, findings, notes, rules.units)
    return replace(rules, rules=kept, notes=tuple(notes))


def _of_type(
    type_: str, entry: TypeRules, findings: CausalFindings, notes: list[str], units: str
) -> TypeRules:
    verdict = {c.symbol: c.verdict for c in findings.effects if c.type == type_}
    if type_ not in findings.types:
        notes.append(f"{type_}: not asked about by the causal analysis; kept as learned")
        return entry
    rule = entry.clearance
    if rule is None:
        return entry
    for symbol, said in verdict.items():
        if said == "causal" and symbol not in rule.value:
            notes.append(
                f"{type_}: {plural(symbol)} are causal for the model, but the rules know no "
                "clearance to them"
            )
    gone = [s for s in rule.value if verdict.get(s) == "none"]
    if not gone:
        return entry
    notes.append(f"{type_}: no causal effect, left out: {', '.join(map(plural, gone))}")
    left = replace(
        rule,
        value={s: c for s, c in rule.value.items() if s not in gone},
        interval={s: i for s, i in rule.interval.items() if s not in gone},
    )
    return replace(entry, clearance=left, influence=None, sentence=_sentence(type_, left, units))


def _sentence(type_: str, rule: ClearanceRule, units: str) -> str:
    if not rule.value:
        return f"{type_} keeps away from nothing."
    kept = ", ".join(f"{c:.3g} {units} from {plural(s)}" for s, c in rule.value.items())
    return f"{type_} keeps {kept}."
