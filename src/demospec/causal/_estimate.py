"""Estimation: effects, intervals, corrected p-values and claims from the table of interventions."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Literal

import numpy as np

from demospec.causal._dose import dose_responses
from demospec.causal._results import (
    CausalFindings,
    Estimate,
    Intervention,
    Placebo,
    Settings,
    SymbolEffect,
    TypeEffect,
    Verdict,
)
from demospec.causal._sentences import sentences
from demospec.causal._statistics import (
    holm,
    mean_interval,
    opposed,
    sign_flip_p,
    smallest_p,
    stable_seed,
    widened,
)
from demospec.causal._trials import TrialTable
from demospec.frames import FloatArray

Key = tuple[Intervention, str, str | None]


def estimate(table: TrialTable, settings: Settings) -> CausalFindings:
    """Effects of all interventions of `table`.

    The scene is the unit: after − before is averaged over paths and placements within each
    scene, and the n scene means are what is tested and resampled. Holm's correction runs over
    all (type × symbol) cells of one kind of intervention; pairs of types are a family of
    their own. A placebo is not corrected, so that it is the *harder* to pass.

    Where the model is a learned rule, effects are integrated over its posterior: intervals hold
    what differs between the rules that the answers allow, and a claim needs 95 % of them.
    """
    if settings.outcome == "verdict":
        table = verdicts(table)
    notes = list(table.notes)
    adds: list[Key] = [("add", symbol, None) for symbol in table.symbols]
    effects = _family(table, adds, settings) if "add" in settings.interventions else []
    others: list[SymbolEffect] = []
    for kind in settings.interventions:
        if kind != "add":
            tried = {(t.symbol, t.onto) for t in table.trials if t.intervention == kind}
            keys: list[Key] = [(kind, a, b) for a, b in sorted(tried, key=str)]
            others += _family(table, keys, settings)
    notes += _power(effects, settings, "cells")
    base = {t: _estimate(table, k, settings) for k, t in enumerate(table.types)}
    pairs = _types(table, settings)
    placebo = _placebo(table, settings, "placebo")
    for patch in placebo:
        if not patch.null:
            notes.append(
                f"the placebo moves the model for {patch.type} ({patch.effect:+.3f}): it responds "
                "to any change of the picture, so its effects of symbols are not to be trusted"
            )
    return CausalFindings(
        types=table.types,
        symbols=table.symbols,
        base=base,
        effects=tuple(effects),
        others=tuple(others),
        placebo=tuple(placebo),
        type_effects=tuple(pairs),
        sentences=sentences(table.types, effects, pairs, placebo, settings, dict(table.skipped)),
        notes=tuple(notes),
        skipped=dict(table.skipped),
        n_scenes=len(table.scene_ids),
        settings=settings,
        unrelated=tuple(p for p in _placebo(table, settings, "unrelated") if p.n_scenes),
        dose=dose_responses(table, settings),
    )


def verdicts(table: TrialTable) -> TrialTable:
    """The table with every probability turned into the verdict p > ½."""
    return replace(
        table,
        before=tuple((b > 0.5).astype(np.float64) for b in table.before),
        trials=tuple(replace(t, after=(t.after > 0.5).astype(np.float64)) for t in table.trials),
    )


def _family(table: TrialTable, keys: list[Key], settings: Settings) -> list[SymbolEffect]:
    """One family of tests: every type × every (symbol, onto) of one kind."""
    raw: list[tuple[str, Key, FloatArray, float, float, FloatArray | None]] = []
    for key in keys:
        effect, changed, before = table.scene_differences(*key)
        by_rule = table.rule_differences(*key)
        for k, type_ in enumerate(table.types):
            share = float(changed[k].mean()) if changed.shape[1] else float("nan")
            base = float(before[k].mean()) if before.shape[1] else float("nan")
            rules = None if by_rule is None else by_rule[k]
            raw.append((type_, key, effect[k], share, base, rules))
    # Types first, so that a table reads like the paper's, row by row.
    raw.sort(key=lambda item: table.types.index(item[0]))
    tested = [i for i, (_, _, d, *_) in enumerate(raw) if len(d) >= 2]
    p = {i: sign_flip_p(raw[i][2], seed=settings.seed) for i in tested}
    # What some rules of the posterior do not show is no claim, however many scenes are asked.
    against = {i: opposed(float(raw[i][2].mean()), raw[i][5]) for i in tested}
    corrected = {
        i: max(p_k, against[i]) for i, p_k in zip(tested, holm([p[i] for i in tested]), strict=True)
    }
    p = {i: max(p[i], against[i]) for i in tested}
    cells = []
    for i, (type_, (kind, symbol, onto), d, share, base, rules) in enumerate(raw):
        mean = float(d.mean()) if len(d) else float("nan")
        interval = _interval(d, settings, key=(type_, kind, symbol, onto or ""), by_rule=rules)
        causal = _claim(mean, corrected.get(i), settings)
        cells.append(
            SymbolEffect(
                type=type_,
                symbol=symbol,
                effect=mean,
                after=base + mean,
                interval=interval,
                p=p.get(i),
                p_corrected=corrected.get(i),
                causal=causal,
                changed=share,
                n_scenes=len(d),
                verdict=_verdict(causal, interval, len(d), settings),
                intervention=kind,
                onto=onto,
            )
        )
    return cells


def _claim(effect: float, p: float | None, settings: Settings) -> bool:
    """Significant *and* large: both, or no claim."""
    return p is not None and p < settings.significance and abs(effect) >= settings.minimum_effect


def _verdict(
    causal: bool, interval: tuple[float, float] | None, n: int, settings: Settings
) -> Verdict:
    """``none`` needs as many scenes as a claim does: two scenes that agree show nothing."""
    if causal:
        return "causal"
    small = interval is not None and max(map(abs, interval)) < settings.minimum_effect
    return "none" if small and smallest_p(n) < settings.significance else "undecided"


def _interval(
    d: FloatArray,
    settings: Settings,
    *,
    key: tuple[str, ...],
    bounds: tuple[float, float] = (-1.0, 1.0),
    by_rule: FloatArray | None = None,
) -> tuple[float, float] | None:
    seed = stable_seed(settings.seed, *key)
    over_scenes = mean_interval(d, level=settings.level, seed=seed, bounds=bounds)
    mean = float(d.mean()) if len(d) else float("nan")
    return widened(over_scenes, mean, by_rule, level=settings.level, bounds=bounds)


def _estimate(table: TrialTable, k: int, settings: Settings) -> Estimate:
    means = np.array([before[k].mean() for before in table.before])
    key = ("base", table.types[k])
    by_rule = None
    if table.before_by_rule:
        by_rule = np.mean([share[k] for share in table.before_by_rule], axis=0)
    interval = _interval(means, settings, key=key, bounds=(0.0, 1.0), by_rule=by_rule)
    return Estimate(float(means.mean()), interval, len(means))


def _types(table: TrialTable, settings: Settings) -> list[TypeEffect]:
    pairs = list(combinations(range(len(table.types)), 2))
    effects = [np.array([v[b].mean() - v[a].mean() for v in table.before]) for a, b in pairs]
    apart = [np.array([np.abs(v[b] - v[a]).mean() for v in table.before]) for a, b in pairs]
    enough = len(table.before) >= 2
    p: list[float | None] = [None] * len(pairs)
    corrected: list[float | None] = [None] * len(pairs)
    if enough:
        tested = [sign_flip_p(d, seed=settings.seed) for d in effects]
        p, corrected = [*tested], [*holm(tested)]
    out = []
    for (a, b), d, gap, p_k, p_c in zip(pairs, effects, apart, p, corrected, strict=True):
        names = (table.types[a], table.types[b])
        interval = _interval(gap, settings, key=("apart", *names), bounds=(0.0, 1.0))
        certain = interval is not None and interval[0] >= max(settings.minimum_effect, 1e-12)
        out.append(
            TypeEffect(
                from_type=names[0],
                to_type=names[1],
                effect=float(d.mean()),
                interval=_interval(d, settings, key=("types", *names)),
                p=p_k,
                p_corrected=p_c,
                differ=_claim(float(d.mean()), p_c, settings) or certain,
                disagreement=Estimate(float(gap.mean()), interval, len(gap)),
                n_scenes=len(d),
            )
        )
    return out


def _placebo(
    table: TrialTable, settings: Settings, kind: Literal["placebo", "unrelated"]
) -> list[Placebo]:
    effect, changed, _ = table.scene_differences(kind, "")
    out = []
    for k, type_ in enumerate(table.types):
        d = effect[k]
        p = sign_flip_p(d, seed=settings.seed) if len(d) >= 2 else None
        mean = float(d.mean()) if len(d) else float("nan")
        out.append(
            Placebo(
                type=type_,
                effect=mean,
                interval=_interval(d, settings, key=(kind, type_)),
                p=p,
                null=not _claim(mean, p, settings),
                changed=float(changed[k].mean()) if len(d) else float("nan"),
                n_scenes=len(d),
            )
        )
    return out


def _power(cells: list[SymbolEffect], settings: Settings, what: str) -> list[str]:
    """Says when too few scenes make every claim impossible, whatever the data."""
    tested = [c for c in cells if c.p is not None]
    if not tested:
        return []
    n = max(c.n_scenes for c in tested)
    if smallest_p(n) < settings.significance:
        family = sum(1 for c in tested if c.p is not None)
        if smallest_p(n) * family < settings.significance:
            return []
        needed = next(m for m in range(2, 64) if smallest_p(m) * family < settings.significance)
        return [
            f"with {n} scenes a lone effect among {family} {what} cannot be significant after "
            f"correction (smallest p {smallest_p(n):.2g} × {family}): {needed} scenes can"
        ]
    return [
        f"with {n} scenes nothing can be significant (smallest p {smallest_p(n):.2g}): "
        "give at least 6 scenes"
    ]
