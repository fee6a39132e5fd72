"""Agreement of a model's causal effects with learned rules, scored cell by cell.

Two ways to the same question from the same demonstrations: interventions on a model, and
exact rules. Where they disagree, one of them is wrong, or the data say too little.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from demospec.causal._results import CausalFindings
from demospec.rules import RuleSet


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
