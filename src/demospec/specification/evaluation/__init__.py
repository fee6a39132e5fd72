"""Prediction, evaluation, conformal verdicts, identification and explanation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.specification.evaluation._conformal import Conformal, conformal, pooled_quantile
    from demospec.specification.evaluation._evaluate import (
        Evaluation,
        Score,
        clustered_interval,
        evaluate,
        score,
        wilson_interval,
    )
    from demospec.specification.evaluation._explain import Explanation, explain
    from demospec.specification.evaluation._identify import (
        Identification,
        acceptances,
        clusters,
        identify,
        type_posterior,
    )
    from demospec.specification.evaluation._predict import Predictions, predict
    from demospec.specification.evaluation._predict_parts import predict_parts

__all__ = [
    "Conformal",
    "Evaluation",
    "Explanation",
    "Identification",
    "Predictions",
    "Score",
    "acceptances",
    "clustered_interval",
    "clusters",
    "conformal",
    "evaluate",
    "explain",
    "identify",
    "pooled_quantile",
    "predict",
    "predict_parts",
    "score",
    "type_posterior",
    "wilson_interval",
]

_HOME = {
    "Conformal": "_conformal",
    "Evaluation": "_evaluate",
    "Explanation": "_explain",
    "Identification": "_identify",
    "Predictions": "_predict",
    "Score": "_evaluate",
    "acceptances": "_identify",
    "clustered_interval": "_evaluate",
    "clusters": "_identify",
    "conformal": "_conformal",
    "evaluate": "_evaluate",
    "explain": "_explain",
    "identify": "_identify",
    "pooled_quantile": "_conformal",
    "predict": "_predict",
    "predict_parts": "_predict_parts",
    "score": "_evaluate",
    "type_posterior": "_identify",
    "wilson_interval": "_evaluate",
}


__getattr__ = names_of(__name__, _HOME)
