"""Preconditions of findings: claims about answers that no rule explains are withheld.

An intervention asks a model. Where the model's rule does not explain the answers that it was
learned from, the effects are real effects on the model and say nothing about the person.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from demospec.causal._results import CausalFindings, SymbolEffect
from demospec.demonstrations import ValidityModel
from demospec.rules import LabelFit, RuleSet
from demospec.scene import Scene

OF_THE_MODEL = "Effects are on what the model learned from these answers accepts."


def fits_of(model: ValidityModel) -> dict[str, LabelFit]:
    """Type → how well the model's rule explains the labels it was learned from.

    Empty for models without a rule (networks) and for rules written by hand.
    """
    rules = model if isinstance(model, RuleSet) else getattr(model, "rules", None)
    if not isinstance(rules, RuleSet):
        return {}
    return {name: rule.fit for name, rule in rules.rules.items() if rule.fit is not None}


def checked(
    findings: CausalFindings, fits: Mapping[str, LabelFit], scenes: Sequence[Scene]
) -> CausalFindings:
    """The findings with the checks that can fail: permuted labels, and the moved bare table.

    Args:
        fits: By type, see `fits_of`; the test against permuted labels is theirs.
        scenes: Without a picture the bare table cannot be moved: "not applicable".
    """
    failed = {name for name, fit in fits.items() if fit.verdict == "not" and name in findings.types}
    words = list(findings.sentences)
    if fits:
        words.insert(0, OF_THE_MODEL)
    if all(scene.picture is None for scene in scenes):
        words = [w for w in words if not w.startswith("Moving a patch of bare table")]
        words.append("Moving a patch of bare table: not applicable, the scenes have no pictures.")
    for name in sorted(failed):
        words = [w for w in words if not _is_about(w, name)]
        fit = fits[name]
        words.append(
            f"{name}: permuted labels are explained as well (p = {fit.p_chance:.2g}), so nothing "
            "is claimed of this person."
        )
    passed = {n: f for n, f in fits.items() if n in findings.types and f.verdict != "not"}
    tested = {n: f for n, f in passed.items() if f.explained is not None}
    if tested:
        worst = max(fit.p_chance for fit in tested.values())
        words.append(f"Permuted labels are not explained as well (p = {worst:.2g} at most).")

    def kept(cells: Sequence[SymbolEffect]) -> tuple[SymbolEffect, ...]:
        return tuple(
            replace(c, causal=False, verdict="undecided") if c.type in failed else c for c in cells
        )

    return replace(
        findings,
        effects=kept(findings.effects),
        others=kept(findings.others),
        type_effects=tuple(
            replace(pair, differ=False) if {pair.from_type, pair.to_type} & failed else pair
            for pair in findings.type_effects
        ),
        sentences=tuple(words),
        labels={name: fit for name, fit in fits.items() if name in findings.types},
    )


def _is_about(sentence: str, name: str) -> bool:
    return sentence.startswith(f"{name} ") or f"For {name}," in sentence or f" {name} " in sentence
