"""Causal findings: effects with intervals, placebos, sentences. Light to import."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from demospec.errors import InputError
from demospec.rules import LabelFit

Intervention = Literal["add", "remove", "move", "swap", "placebo", "unrelated"]
Verdict = Literal["causal", "none", "undecided"]
Interval = tuple[float, float]


@dataclass(frozen=True)
class Settings:
    """Everything that decides the outcome of `find_causes`, besides model and scenes.

    Args:
        placements: Free places tried for each symbol in each scene; ≥ 1. Intervals of 20
            scenes are 7 % wider with 3 than with 4, and 13 % wider than with 8.
        draws: Paths (z_θ) judged in each scene, the same before and after; ≥ 1.
        minimum_effect: Smallest |change of the probability of validity| that may be called
            causal, in [0, 1]. A deterministic model responds to everything a little, and a
            paired test finds that little significant.
        significance: Corrected p-values below this are significant.
        level: Of the intervals.
        interventions: Kinds beside the placebo.
        seed: Of places, paths, items and resampling.
        clear_ends_px: Nothing is put within this distance of start or goal (rim to point);
            None: 8 % of the width.
        hide_lists: The model gets the changed pictures without the changed object lists and
            must see by itself. Off: it gets both, and may use either.
        outcome: ``probability``: effects on E[p(v)], the paper's. ``verdict``: on the share of
            paths with p(v) > ½. A model that takes a bowl for a glass with p = 0.2 shifts the
            first and not the second.
    """

    placements: int = 3
    draws: int = 100
    minimum_effect: float = 0.05
    significance: float = 0.05
    level: float = 0.95
    interventions: tuple[Intervention, ...] = ("add",)
    seed: int = 0
    clear_ends_px: float | None = None
    hide_lists: bool = False
    outcome: Literal["probability", "verdict"] = "probability"

    def __post_init__(self) -> None:
        for name in ("placements", "draws"):
            if getattr(self, name) < 1:
                raise InputError("at least 1", getattr(self, name), field=name)
        if not 0.0 <= self.minimum_effect <= 1.0:
            expected = "a change of probability between 0 and 1"
            raise InputError(expected, self.minimum_effect, field="minimum_effect")
        for name in ("significance", "level"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise InputError("a number between 0 and 1", getattr(self, name), field=name)
        if self.outcome not in ("probability", "verdict"):
            raise InputError("probability or verdict", self.outcome, field="outcome")
        known = ("add", "remove", "move", "swap")
        for kind in self.interventions:
            if kind not in known:
                raise InputError(f"some of {', '.join(known)}", kind, field="interventions")


@dataclass(frozen=True)
class Estimate:
    """A mean over scenes. `interval` is None for fewer than two scenes."""

    mean: float
    interval: Interval | None
    n_scenes: int


@dataclass(frozen=True)
class SymbolEffect:
    """do(Z_I := E(I ∪ o)), or another intervention with symbol o: what it does to E[p(v)].

    Args:
        type: User type s.
        symbol: The symbol added, removed, moved, or replaced.
        effect: Mean over scenes of (after − before), in probability of validity; NaN where
            no scene allowed the intervention.
        after: E[p(v)] afterwards, in those scenes: the number of the paper's table.
        interval: For the effect, over scenes and over the rules of the posterior where the model
            has one; None for fewer than two scenes.
        p: Sign-flip permutation over scenes, two-sided; at least the share of the posterior's
            rules without such an effect.
        p_corrected: After Holm's correction within its kind of intervention.
        causal: p_corrected below the significance *and* |effect| at least the minimum.
        changed: Mean |after − before| over single paths: near 0 means that nothing responds,
            large with an effect near 0 means that as many paths are gained as lost (moves).
        n_scenes: Scenes in which the intervention was possible.
        verdict: ``causal``; ``none`` where the whole interval lies within ± the minimum
            effect; else ``undecided`` (absence of evidence is not evidence of absence).
        intervention: ``add``, ``remove``, ``move`` or ``swap``.
        onto: The symbol put in its stead (swaps only).
    """

    type: str
    symbol: str
    effect: float
    after: float
    interval: Interval | None
    p: float | None
    p_corrected: float | None
    causal: bool
    changed: float
    n_scenes: int
    verdict: Verdict
    intervention: Intervention = "add"
    onto: str | None = None


@dataclass(frozen=True)
class TypeEffect:
    """do(S := s) against do(S := s′) on the same scenes and paths.

    Args:
        from_type, to_type: s and s′; the effect is E[p(v) | s′] − E[p(v) | s].
        disagreement: Mean |p_s′ − p_s| over single paths, with its interval over scenes: two
            types may accept equally many paths and yet not the same ones.
        differ: Corrected p below the significance and |effect| at least the minimum; or the
            whole interval of the disagreement at or above the minimum.
    """

    from_type: str
    to_type: str
    effect: float
    interval: Interval | None
    p: float | None
    p_corrected: float | None
    differ: bool
    disagreement: Estimate
    n_scenes: int


@dataclass(frozen=True)
class DosePoint:
    """The paths that pass what was added at distances from `low` to `high`.

    Args:
        low, high: Distance to its footprint, negative inside, in the set's units; None: no end.
        effect: Mean over scenes of (after − before) of these paths, in probability of validity.
        interval: As that of a `SymbolEffect`; None for fewer than two scenes.
        before: What of them is accepted without it, on average: an effect is −`before` at most.
        n_scenes: Scenes that have such paths.
    """

    low: float | None
    high: float | None
    effect: float
    interval: Interval | None
    before: float
    n_scenes: int


@dataclass(frozen=True)
class DoseResponse:
    """How the effect of adding a symbol depends on how near the path passes it."""

    type: str
    symbol: str
    points: tuple[DosePoint, ...]


@dataclass(frozen=True)
class Placebo:
    """What must do nothing: a patch of bare table moved to a free place, or an unrelated thing.

    Args:
        null: No claim could have been made of it (by the very rule for symbols).
        changed: Mean |after − before| over single paths.
    """

    type: str
    effect: float
    interval: Interval | None
    p: float | None
    null: bool
    changed: float
    n_scenes: int


@dataclass(frozen=True)
class CausalFindings:
    """The answer of `find_causes`.

    Args:
        base: Type → E[p(v)] in the scenes as they are.
        effects: Adding each symbol, per type (the paper's table).
        others: Removals, moves and swaps, where asked for.
        placebo: One per type.
        unrelated: One per type: adding a thing of a class that nobody has shown to the model;
            empty where lists are hidden or there are none.
        dose: Effect of adding against distance, per type and symbol.
        type_effects: Every pair of types.
        sentences: The findings in words.
        notes: Smaller n, things that could not be tried, and why. Never empty silence.
        skipped: Symbol → why nothing of it could be added anywhere.
        n_scenes: Scenes given.
        labels: Type → how well the model's rule explains the labels that it was learned from,
            tested on permuted labels; types without a learned rule are absent.
    """

    types: tuple[str, ...]
    symbols: tuple[str, ...]
    base: Mapping[str, Estimate]
    effects: tuple[SymbolEffect, ...]
    others: tuple[SymbolEffect, ...]
    placebo: tuple[Placebo, ...]
    type_effects: tuple[TypeEffect, ...]
    sentences: tuple[str, ...]
    notes: tuple[str, ...]
    skipped: Mapping[str, str]
    n_scenes: int
    settings: Settings
    labels: Mapping[str, LabelFit] = field(default_factory=dict)
    unrelated: tuple[Placebo, ...] = ()
    dose: tuple[DoseResponse, ...] = ()

    def effect(self, type: str, symbol: str) -> SymbolEffect:
        """Adding `symbol` for `type`; InputError lists what there is."""
        for cell in self.effects:
            if cell.type == type and cell.symbol == symbol:
                return cell
        known = ", ".join(f"{c.type}/{c.symbol}" for c in self.effects)
        raise InputError(f"one of {known or 'no effects'}", f"{type}/{symbol}", field="symbol")

    def relevant(self, type: str) -> tuple[str, ...]:
        """The symbols that matter to `type`: data for the rules and the planner."""
        if type not in self.types:
            raise InputError(f"one of the types {', '.join(self.types)}", type, field="type")
        return tuple(c.symbol for c in self.effects if c.type == type and c.causal)

    @property
    def placebo_is_null(self) -> bool:
        """Whether the placebo (moved bare table) came out null for every type."""
        return all(p.null for p in self.placebo)

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec causes --json`` (DESIGN.md), with more fields."""
        return {
            "base": {t: _plain(asdict(e)) for t, e in self.base.items()},
            "effects": [_effect(c) for c in self.effects],
            "placebo": [_plain(asdict(p)) for p in self.placebo],
            "unrelated": [_plain(asdict(p)) for p in self.unrelated],
            "dose_response": [_plain(asdict(curve)) for curve in self.dose],
            "types": [_type_effect(t) for t in self.type_effects],
            "sentences": list(self.sentences),
            "relevant": {t: list(self.relevant(t)) for t in self.types},
            "others": [_effect(c) for c in self.others],
            "placebo_is_null": self.placebo_is_null,
            "skipped": dict(self.skipped),
            "notes": list(self.notes),
            "n_scenes": self.n_scenes,
            "labels": {name: fit.to_json() for name, fit in self.labels.items()},
            "settings": _plain(asdict(self.settings)),
        }


def _effect(cell: SymbolEffect) -> dict[str, Any]:
    document = _plain(asdict(cell))
    if cell.onto is None:
        del document["onto"]
    return document


def _type_effect(pair: TypeEffect) -> dict[str, Any]:
    document = _plain(asdict(pair))
    return {"from": document.pop("from_type"), "to": document.pop("to_type"), **document}


def _plain(document: dict[str, Any]) -> dict[str, Any]:
    """NaN (no scene allowed it) → null; tuples → lists."""
    out: dict[str, Any] = {}
    for key, value in document.items():
        if isinstance(value, dict):
            value = _plain(value)
        elif isinstance(value, (list, tuple)):
            value = [_plain(v) if isinstance(v, dict) else v for v in value]
        elif isinstance(value, float) and not math.isfinite(value):
            value = None
        out[key] = value
    return out
