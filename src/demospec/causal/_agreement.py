"""Causal effects beside learned rules: their agreement, and the rules without what has no effect.

Two ways to the same question from the same demonstrations: interventions on a model, and
exact rules. Where they disagree, one of them is wrong, or the data say too little.

The rule learner says how far; the interventions say whether at all. Rules of causes are a rule
file like any other: planning and the other commands read it without knowing about causes.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from demospec.causal._results import CausalFindings
from demospec.rules import ClearanceRule, RuleSet, TypeRules, plural


@dataclass(frozen=True)
class Disagreement:
    """One type and symbol on which the two differ.

    Args:
        kind: ``only the model`` finds it causal, or ``only the rules`` find it relevant.
        effect: By the model.
        why: In words, with the numbers that matter.
    """

    type: str
    symbol: str
    kind: Literal["only the model", "only the rules"]
    effect: float
    why: str


@dataclass(frozen=True)
class Agreement:
    """Model against rules.

    Args:
        score: Share of comparable cells on which they agree; None without any.
        n_cells: Comparable cells.
        disagreements: The others.
        open: Cells that cannot be compared (``type/symbol: why``): undecided by the
            interventions, or uninformed by the demonstrations.
    """

    score: float | None
    n_cells: int
    disagreements: tuple[Disagreement, ...]
    open: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return asdict(self)


def agreement(findings: CausalFindings, rules: RuleSet) -> Agreement:
    """Compares the causal symbols of each type with the relevant symbols of its clearance rule.

    Args:
        findings: Of a model.
        rules: Learned from the same demonstrations (or the truth).
    """
    same = 0
    differ: list[Disagreement] = []
    open_: list[str] = []
    for cell in findings.effects:
        name = f"{cell.type}/{cell.symbol}"
        rule = rules.rules[cell.type].clearance if cell.type in rules.rules else None
        if rule is None:
            open_.append(f"{name}: no clearance rule for {cell.type}")
        elif cell.symbol in rule.uninformed:
            open_.append(f"{name}: no demonstration informs the rule")
        elif cell.verdict == "undecided":
            open_.append(f"{name}: the interventions leave it undecided ({cell.effect:+.2f})")
        elif cell.causal == (cell.symbol in rule.relevant):
            same += 1
        elif cell.causal:
            why = f"adding it changes E[p(valid)] by {cell.effect:+.2f}, the rules ignore it"
            differ.append(Disagreement(cell.type, cell.symbol, "only the model", cell.effect, why))
        else:
            keeps = rule.value[cell.symbol]
            why = (
                f"the rules keep {keeps:.1f} {rules.units} from it, adding it changes "
                f"E[p(valid)] by {cell.effect:+.3f} only"
            )
            differ.append(Disagreement(cell.type, cell.symbol, "only the rules", cell.effect, why))
    n = same + len(differ)
    return Agreement(same / n if n else None, n, tuple(differ), tuple(open_))


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
