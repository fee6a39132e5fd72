"""Verdicts with a stated error rate: split-conformal prediction with scenes as the units.

Demonstrations of one scene share what the model got wrong there, so they are not exchangeable;
scenes are. Every held-out scene therefore weighs 1, however many demonstrations it has, and one
further scene counts as infinitely bad: that bounds the error rate which n scenes can support by
1/(n + 1), whatever the number of demonstrations.

Source: hierarchical conformal prediction, Lee, Barber, Willett 2023 (pooled distribution of the
groups). Not in the paper by Angelov et al.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from demospec.demonstrations import DemonstrationSet, ValidityModel, Verdict
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.specification.evaluation._predict import Views, check_type


@dataclass(frozen=True)
class Conformal:
    """Per type: how far a logit must be from 0 for a verdict with the stated error rate.

    Args:
        alpha: A demonstration of a new scene gets the wrong verdict with at most this
            probability, over scenes and demonstrations drawn as the calibration's were.
        margin: Type → logit beyond which the verdict is given; else it is ``either``.
        scenes: Type → scenes it was calibrated on.
    """

    alpha: float
    margin: Mapping[str, float]
    scenes: Mapping[str, int]

    @property
    def least_alpha(self) -> Mapping[str, float]:
        """Type → smallest error rate that its scenes can support."""
        return {t: 1.0 / (n + 1) for t, n in self.scenes.items()}

    def verdicts(self, logits: FloatArray, type: str) -> list[Verdict]:
        """(n,) logits of a type → a verdict each.

        Raises:
            InputError: A type that was not calibrated.
        """
        if type not in self.margin:
            known = ", ".join(self.margin) or "none"
            raise InputError(f"one of the calibrated types ({known})", type, field="type")
        margin = self.margin[type]
        return [
            "accept" if value > margin else "reject" if value < -margin else "unknown"
            for value in np.asarray(logits, dtype=np.float64)
        ]


def predict_verdicts(
    model: ValidityModel,
    data: DemonstrationSet,
    calibrated: Conformal,
    *,
    progress: Progress = silent,
) -> dict[tuple[str, str], Verdict]:
    """(demonstration, type) → verdict, for its type or, where it has none, every calibrated one.

    Demonstrations that cannot be judged, or of a type that was not calibrated, are left out.
    Never reads the labels.
    """
    d = data.demonstrations
    out: dict[tuple[str, str], Verdict] = {}
    views = Views(model, data, progress)
    for _, rows, view in views:
        for type_ in calibrated.margin:
            mine = [int(i) for i in rows if d.type[i] is None or d.type[i] == type_]
            if mine:
                said = calibrated.verdicts(view.logits(data.motions(mine), type_), type_)
                out.update({(d.demo_id[i], type_): v for i, v in zip(mine, said, strict=True)})
    views.refuse_if_none()
    return out


def conformal(
    model: ValidityModel,
    held_out: DemonstrationSet,
    alpha: float,
    *,
    progress: Progress = silent,
) -> Conformal:
    """Calibrates a model's verdicts on labelled scenes that it was not fitted to.

    Args:
        held_out: Labelled demonstrations; scenes are the independent units.
        alpha: Error rate in (0, 1).

    Raises:
        InputError: No labels; or fewer scenes than `alpha` needs, with the smallest error rate
            that they support.
        CannotJudgeError: No scene can be judged.
    """
    if not 0 < alpha < 1:
        raise InputError("an error rate in (0, 1)", alpha, field="conformal")
    d = held_out.demonstrations
    # Type → one array a scene: how far each logit lies on the wrong side.
    wrong: dict[str, list[FloatArray]] = {}
    views = Views(model, held_out, progress)
    for _, rows, view in views:
        for type_ in model.types:
            mine = [int(i) for i in rows if d.type[i] == type_ and d.valid[i] >= 0]
            if mine:
                logits = view.logits(held_out.motions(mine), type_)
                side = np.where(d.valid[mine] == 1, -1.0, 1.0)
                wrong.setdefault(type_, []).append(np.asarray(side * logits))
    views.refuse_if_none()
    if not wrong:
        raise InputError("labelled demonstrations of the model's types", "none", field="valid")
    margin = {}
    for type_, groups in wrong.items():
        check_type(model, type_)
        least = 1.0 / (len(groups) + 1)
        if alpha < least:
            raise InputError(
                f"an error rate of at least {least:.3g}: {len(groups)} scene(s) of type "
                f"{type_} can support no smaller one",
                alpha,
                field="conformal",
            )
        margin[type_] = max(0.0, pooled_quantile(groups, alpha))
    return Conformal(alpha, margin, {t: len(g) for t, g in wrong.items()})


def pooled_quantile(groups: list[FloatArray], alpha: float) -> float:
    """Smallest t with Σ_groups share(≤ t) ≥ (1 − α)(n + 1)."""
    values = np.concatenate(groups)
    weights = np.concatenate([np.full(len(g), 1.0 / len(g)) for g in groups])
    order = np.argsort(values, kind="stable")
    mass = np.cumsum(weights[order])
    needed = (1.0 - alpha) * (len(groups) + 1) - 1e-9
    return float(values[order][min(int(np.searchsorted(mass, needed)), len(values) - 1)])
