"""What a type cares about, as the field model reads it: relevance and clearance per class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules import ClearanceFit, fit_clearance

_SURE = 0.995
_CLEARLY = 3.0


@dataclass(frozen=True)
class FieldRule:
    """One type's specification.

    Args:
        probability: Class → posterior probability that it matters, in [0, 1].
        clearance: Class → posterior mean of the distance to keep if it matters, set units.
        spread: Class → standard deviation of that, set units.
        relevant: Classes that matter in the point answer.
        uninformed: Classes about which no demonstration says anything; they count as
            irrelevant, with the uncertainty that `probability` states.
    """

    probability: Mapping[str, float]
    clearance: Mapping[str, float]
    spread: Mapping[str, float]
    relevant: tuple[str, ...]
    uninformed: tuple[str, ...]

    @classmethod
    def fit(
        cls,
        nearest: FloatArray,
        valid: FloatArray,
        symbols: Sequence[str],
        unit: float,
        others: Sequence[ClearanceFit] = (),
    ) -> FieldRule:
        """From exact nearest approaches (n, K) and labels; see `demospec.rules.fit_clearance`.

        Args:
            unit: A hundredth of the table, set units.
            others: What is known of the other types.
        """
        found = fit_clearance(nearest, valid, symbols, unit=unit, others=others)
        if not _explains(found, nearest, valid):
            # Labels that no choice of classes explains better than chance: nothing is known.
            nothing = dict.fromkeys(symbols, 0.0)
            return cls(nothing, nothing, nothing, (), tuple(symbols))
        mean, spread = _moments(found)
        silent = np.array([bool(np.isinf(nearest[:, k]).all()) for k in range(len(symbols))])
        uninformed = set(found.rule.uninformed) | {
            s for s, q in zip(symbols, silent, strict=True) if q
        }
        probability = {}
        for name in symbols:
            p = float(found.probability.get(name, 0.0))
            # The point answer decides; the posterior says how sure it is.
            inside = name in found.rule.value
            probability[name] = max(p, 0.55) if inside else min(p, 0.45)
        return cls(
            probability,
            {n: float(found.rule.value.get(n, mean[n])) for n in symbols},
            {n: float(max(spread[n], 0.02 * unit)) for n in symbols},
            tuple(n for n in symbols if n in found.rule.value),
            tuple(n for n in symbols if n in uninformed),
        )

    def is_nested_in(self, other: FieldRule) -> bool:
        """True where this type cares about fewer classes, and about those no more than `other`.

        "No more": a clearance that is larger by at most twice the spread of both.
        """
        mine, others = set(self.relevant), set(other.relevant)
        return mine < others and all(
            self.clearance[n] - other.clearance[n] <= 2 * np.hypot(self.spread[n], other.spread[n])
            for n in mine
        )

    def of_classes(self, classes: Mapping[str, float]) -> tuple[float, float, float]:
        """Relevance, clearance and spread of a thing of uncertain class.

        Args:
            classes: Class → probability; what is missing to 1 is no thing at all. Classes that
                the rule does not know count as irrelevant.
        """
        shares = {n: p * self.probability.get(n, 0.0) for n, p in classes.items()}
        relevance = sum(shares.values())
        if relevance <= 1e-9:
            return 0.0, 0.0, 0.0
        clearance = sum(w * self.clearance[n] for n, w in shares.items() if w > 0) / relevance
        second = sum(
            w * (self.spread[n] ** 2 + (self.clearance[n] - clearance) ** 2)
            for n, w in shares.items()
            if w > 0
        )
        return min(relevance, _SURE), clearance, float(np.sqrt(second / relevance))

    def to_json(self) -> dict[str, Any]:
        """As saved in a model's settings."""
        return {
            "probability": dict(self.probability),
            "clearance": dict(self.clearance),
            "spread": dict(self.spread),
            "relevant": list(self.relevant),
            "uninformed": list(self.uninformed),
        }

    @classmethod
    def from_json(cls, document: Any, *, field: str) -> FieldRule:
        """The inverse of `to_json`; InputError names what is wrong."""
        try:
            parts = [
                {str(k): float(v) for k, v in document[key].items()}
                for key in ("probability", "clearance", "spread")
            ]
            names = [tuple(str(n) for n in document[key]) for key in ("relevant", "uninformed")]
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InputError("a rule of the field model", str(error), field=field) from None
        if set(parts[0]) != set(parts[1]) or set(parts[0]) != set(parts[2]):
            raise InputError("the same classes in each part", sorted(parts[0]), field=field)
        return cls(parts[0], parts[1], parts[2], names[0], names[1])


def _explains(found: ClearanceFit, nearest: FloatArray, valid: FloatArray) -> bool:
    """Whether the rule agrees with its own labels by more than chance.

    Balanced accuracy beyond ½ by `_CLEARLY` standard errors of a coin: the fit chose among all
    subsets and clearances, so two would be little. Labels of one class need no explanation.
    """
    ok = np.asarray(valid, dtype=bool)
    if ok.all() or not ok.any() or not found.rule.value:
        return True
    kept = np.ones(len(ok), dtype=bool)
    for k, name in enumerate(found.symbols):
        if name in found.rule.value:
            kept &= nearest[:, k] >= found.rule.value[name]
    agrees = 0.5 * (kept[ok].mean() + (~kept[~ok]).mean())
    error = 0.25 * np.sqrt(1.0 / ok.sum() + 1.0 / (~ok).sum())
    # With very few labels even full agreement is no proof, and all that there is.
    return bool(agrees - 0.5 > min(_CLEARLY * error, 0.35))


def _moments(found: ClearanceFit) -> tuple[dict[str, float], dict[str, float]]:
    """Posterior mean and deviation of each class's clearance, given that it matters."""
    weight = np.exp(found.particles.log_weight)
    clearance = np.asarray(found.particles.clearance, dtype=np.float64)
    mean, spread = {}, {}
    overall = list(found.rule.value.values())
    default = float(np.mean(overall)) if overall else 0.0
    for k, name in enumerate(found.symbols):
        column = clearance[:, k]
        mine = np.isfinite(column) & (weight > 0)
        total = weight[mine].sum()
        if total <= 1e-12:
            mean[name], spread[name] = default, 0.0
            continue
        m = float((weight[mine] * column[mine]).sum() / total)
        mean[name] = m
        spread[name] = float(np.sqrt((weight[mine] * (column[mine] - m) ** 2).sum() / total))
    return mean, spread
