"""Agreement of a model with labels: accuracy, balanced accuracy, base rate, interval."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, ValidityModel
from demospec.errors import InputError
from demospec.progress import Progress, silent
from demospec.specification.evaluation._predict import Views

Z95 = 1.959963984540054
UNDEFINED = "undefined: one class"


@dataclass(frozen=True)
class Score:
    """Agreement with the labels of one type.

    Args:
        n: Labelled demonstrations that were judged.
        n_valid: Of these, labelled valid.
        accuracy: Share judged as labelled.
        balanced_accuracy: Mean of the shares among valid and among invalid; None where only
            one of them occurs (`UNDEFINED`).
        majority: Accuracy of always answering the commoner label.
        interval: 95 % of the balanced accuracy, else of the accuracy: Wilson's, with the
            number of demonstrations divided by the design effect of their scenes.
    """

    n: int
    n_valid: int
    accuracy: float
    balanced_accuracy: float | None
    majority: float
    interval: tuple[float, float]

    def to_json(self) -> dict[str, Any]:
        """The fields of ``demospec evaluate``."""
        return {
            "n": self.n,
            "n_valid": self.n_valid,
            "accuracy": self.accuracy,
            "balanced_accuracy": self.balanced_accuracy,
            "majority": self.majority,
            "interval": list(self.interval),
            "interval_of": "accuracy" if self.balanced_accuracy is None else "balanced_accuracy",
        }


@dataclass(frozen=True)
class Evaluation:
    """Scores per type, and what was left out.

    Args:
        types: Type → score over all its judged demonstrations.
        far: Type → score over those further than `far_px` from the boundary; empty without a
            truth to measure that by.
        unjudged: Scene id → why the model cannot judge it.
        left_out: Demonstrations without type or label, or of a type the model does not know.
    """

    types: dict[str, Score]
    far: dict[str, Score]
    unjudged: dict[str, str]
    left_out: int

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec evaluate``."""
        types = {t: s.to_json() for t, s in self.types.items()}
        for t, score in self.far.items():
            types[t]["far"] = score.to_json()
        return {"types": types, "left_out": self.left_out, "unjudged": self.unjudged}


def evaluate(
    model: ValidityModel,
    data: DemonstrationSet,
    *,
    truth: ValidityModel | None = None,
    far_px: float | None = None,
    progress: Progress = silent,
) -> Evaluation:
    """Agreement of a model with the labels of a set, per type.

    Args:
        truth: Rules whose logit is the margin in set units; with them the demonstrations with
            |margin| > `far_px` are scored apart.
        far_px: Set units; by default two hundredths of the scenes' size.

    Raises:
        InputError: The set has no labelled demonstration of a type that the model knows.
        CannotJudgeError: No scene of the set can be judged.
    """
    d = data.demonstrations
    usable = (d.valid >= 0) & np.array([t in model.types for t in d.type], dtype=bool)
    if not usable.any():
        expected = f"labelled demonstrations of {', '.join(model.types)}"
        raise InputError(expected, f"none among {len(d)}", field="valid")
    beyond = 0.02 * data.length_scale if far_px is None else far_px
    agree = np.full(len(d), -1, dtype=np.int8)
    far = np.zeros(len(d), dtype=bool)
    views = Views(model, data, progress)
    for scene_id, rows, view in views:
        for type_ in model.types:
            mine = [int(i) for i in rows if usable[i] and d.type[i] == type_]
            if not mine:
                continue
            paths = data.motions(mine)
            agree[mine] = (view.logits(paths, type_) > 0) == (d.valid[mine] == 1)
            if truth is not None and type_ in truth.types:
                margin = truth.see(data.scene(scene_id)).logits(paths, type_)
                far[mine] = np.abs(margin) > beyond
    views.refuse_if_none()
    judged = agree >= 0
    scene = np.array([data.scene_index[s] for s in d.scene_id])

    def scores(mask: NDArray[np.bool_]) -> dict[str, Score]:
        out = {}
        for type_ in model.types:
            rows = np.flatnonzero(mask & (d.type == type_))
            if len(rows):
                out[type_] = score(agree[rows] == 1, d.valid[rows] == 1, scene[rows])
        return out

    return Evaluation(
        types=scores(judged),
        far=scores(judged & far) if truth is not None else {},
        unjudged=views.unjudged,
        left_out=int((~usable).sum()),
    )


def score(right: NDArray[np.bool_], valid: NDArray[np.bool_], scene: NDArray[np.int64]) -> Score:
    """Scores verdicts.

    Args:
        right: (n,) the verdict agrees with the label; n ≥ 1.
        valid: (n,) the label.
        scene: (n,) which scene, any integers: demonstrations of one scene are not independent.
    """
    rates, intervals = [], []
    for label in (True, False):
        mask = valid == label
        if mask.any():
            rates.append(float(right[mask].mean()))
            intervals.append(clustered_interval(right[mask], scene[mask]))
    n_valid = int(valid.sum())
    accuracy = float(right.mean())
    if len(rates) == 2:
        centre = sum(rates) / 2
        # Newcombe's square-and-add of the two rates' own intervals.
        low = sqrt(sum(((r - i[0]) / 2) ** 2 for r, i in zip(rates, intervals, strict=True)))
        high = sqrt(sum(((i[1] - r) / 2) ** 2 for r, i in zip(rates, intervals, strict=True)))
        interval = (max(0.0, centre - low), min(1.0, centre + high))
    else:
        interval = clustered_interval(right, scene)
    return Score(
        n=len(right),
        n_valid=n_valid,
        accuracy=accuracy,
        balanced_accuracy=sum(rates) / 2 if len(rates) == 2 else None,
        majority=max(n_valid, len(right) - n_valid) / len(right),
        interval=interval,
    )


def clustered_interval(right: NDArray[np.bool_], scene: NDArray[np.int64]) -> tuple[float, float]:
    """Wilson's 95 % interval of a share, for n over the design effect of the scenes.

    The design effect is the variance between scenes over that of independent demonstrations
    (ratio estimator), at least 1. Where every verdict agrees there is nothing to estimate it
    from: each scene then counts once.
    """
    n = len(right)
    p = float(right.mean())
    _, cluster = np.unique(scene, return_inverse=True)
    k = int(cluster.max()) + 1
    if p in (0.0, 1.0):
        return wilson_interval(p, float(k))
    total = np.bincount(cluster, weights=right - p)
    effect = 1.0
    if k > 1:
        effect = max(1.0, float((total**2).sum()) * k / (k - 1) / (n * p * (1 - p)))
    return wilson_interval(p, n / effect)


def wilson_interval(p: float, n: float) -> tuple[float, float]:
    """Wilson's 95 % interval of a share p observed among n > 0 independent trials."""
    centre = p + Z95**2 / (2 * n)
    half = Z95 * sqrt(p * (1 - p) / n + Z95**2 / (4 * n**2))
    scale = 1 + Z95**2 / n
    return (max(0.0, (centre - half) / scale), min(1.0, (centre + half) / scale))
