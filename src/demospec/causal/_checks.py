"""Preconditions of findings: claims about answers that no rule explains are withheld.

An intervention asks a model. Where the model's rule does not explain the answers that it was
learned from, the effects are real effects on the model and say nothing about the person.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from demospec.causal._results import CausalFindings, SymbolEffect
from demospec.causal._sentences import sentences
from demospec.demonstrations import ValidityModel
from demospec.rules import LabelFit, RuleSet, constraint_words
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


def open_classes(model: ValidityModel) -> dict[str, tuple[str, ...]]:
    """Type → classes of which no answer that its rule was learned from says anything."""
    rules = model if isinstance(model, RuleSet) else getattr(model, "rules", None)
    if not isinstance(rules, RuleSet):
        return {}
    return {
        name: tuple(s for s in rule.clearance.uninformed if s not in rule.constrained)
        for name, rule in rules.rules.items()
        if rule.clearance is not None and rule.fit is not None
    }


def own_paths_asked(model: ValidityModel, type: str) -> list[str]:
    """What a rule asks of the path whatever stands in the scene, in words: no intervention on
    objects can show it."""
    rules = model if isinstance(model, RuleSet) else getattr(model, "rules", None)
    if not isinstance(rules, RuleSet) or type not in rules.rules:
        return []
    return [
        f"{constraint_words(c, rules.units, rules.metres_per_unit)}, whatever stands there"
        for c in rules.of_type(type).constraints
        if c.of is None and c.when is None
    ]


def checked(
    findings: CausalFindings, model: ValidityModel, scenes: Sequence[Scene]
) -> CausalFindings:
    """The findings with the checks that can fail: permuted labels, and the moved bare table.

    Classes of which the answers say nothing are undecided: what the model does there is its own.

    Args:
        model: What was asked; a learned rule brings its test against permuted labels.
        scenes: Without a picture the bare table cannot be moved: "not applicable".
    """
    fits, unknown = fits_of(model), open_classes(model)
    failed = {name for name, fit in fits.items() if fit.verdict == "not" and name in findings.types}

    def kept(cells: Sequence[SymbolEffect]) -> tuple[SymbolEffect, ...]:
        return tuple(
            replace(c, causal=False, verdict="undecided")
            if c.type in failed or c.symbol in unknown.get(c.type, ())
            else c
            for c in cells
        )

    effects = kept(findings.effects)
    pairs = tuple(
        replace(pair, differ=False) if {pair.from_type, pair.to_type} & failed else pair
        for pair in findings.type_effects
    )
    pictures = any(scene.picture is not None for scene in scenes)
    words = sentences(
        [name for name in findings.types if name not in failed],
        effects,
        [pair for pair in pairs if not {pair.from_type, pair.to_type} & failed],
        findings.placebo if pictures else (),
        findings.settings,
        findings.skipped,
        unknown,
    )
    first = (OF_THE_MODEL,) if fits else ()
    said = [f"{n} {'; '.join(own)}." for n in findings.types if n not in failed
            if (own := own_paths_asked(model, n))]  # fmt: skip
    return replace(
        findings,
        effects=effects,
        others=kept(findings.others),
        type_effects=pairs,
        sentences=(
            *first,
            *words,
            *said,
            *_of_checks(findings, fits, pictures),
        ),
        labels={name: fit for name, fit in fits.items() if name in findings.types},
    )


def _of_checks(findings: CausalFindings, fits: Mapping[str, LabelFit], pictures: bool) -> list[str]:
    """Which checks apply, and whether the answers passed them."""
    out = []
    if findings.placebo and not pictures:
        out.append("Moving a patch of bare table: not applicable, the scenes have no pictures.")
    out += _of_unrelated(findings)
    tested = {n: f for n, f in fits.items() if n in findings.types and f.explained is not None}
    for name in sorted(n for n, f in tested.items() if f.verdict == "not"):
        fit = tested[name]
        chance = "" if fit.chance is None else f"; chance would give {fit.chance:.0f}"
        out.append(
            f"{name}: the rule does not explain the answers ({fit.contradicted} of {fit.n} "
            f"contradict it{chance}), so nothing is claimed."
        )
    passed = [fit.p_chance for fit in tested.values() if fit.verdict != "not"]
    if passed:
        out.append(f"Permuted labels are not explained as well (p = {max(passed):.2g} at most).")
    return out


def _of_unrelated(findings: CausalFindings) -> list[str]:
    """What a thing of a class that the model was never shown does."""
    if not findings.unrelated:
        return []
    moved = [p for p in findings.unrelated if not p.null]
    if not moved:
        return ["Adding a thing of a class that nobody has shown to the model changes nothing."]
    which = ", ".join(f"{p.type} {p.effect:+.2f}" for p in moved)
    return [
        "Adding a thing of a class that nobody has shown to the model changes what it accepts "
        f"({which}): it keeps away from things of any class, and effects of a class may be those "
        "of a thing as such."
    ]
