"""Multinomial logistic regression under a Gaussian prior, fitted to its maximum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray


def standard(
    x: FloatArray, center: NDArray[np.floating], scale: NDArray[np.floating]
) -> FloatArray:
    """Standardised features; four deviations are far enough, beyond them nothing learned holds."""
    return np.asarray(np.clip((x - center) / scale, -4.0, 4.0))


def fit_logistic(
    z: FloatArray,
    y: NDArray[np.integer],
    weight: FloatArray,
    start: FloatArray,
    *,
    ridge: float,
    offset: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Weights (classes, f) and offsets (classes,), maximum a posteriori.

    Args:
        z: (n, f) standardised features.
        y: (n,) class numbers.
        weight: (n,) how much each example counts.
        start: (classes,) prior mean of the offsets (their precision is 1).
        ridge: Precision of the prior on every weight.
        offset: (n, classes) added to the scores: what is known beforehand.
    """
    from scipy.optimize import minimize

    count, width = len(start), z.shape[1]
    known = 0.0 if offset is None else offset
    target = np.zeros((len(z), count))
    target[np.arange(len(z)), y] = 1.0

    def loss(flat: FloatArray) -> tuple[float, FloatArray]:
        matrix, bias = flat[: count * width].reshape(count, width), flat[count * width :]
        score = z @ matrix.T + bias + known
        top = score.max(axis=1, keepdims=True)
        log_sum = top + np.log(np.exp(score - top).sum(axis=1, keepdims=True))
        p = np.exp(score - log_sum)
        gap = bias - start
        value = -(weight[:, None] * target * (score - log_sum)).sum()
        value += 0.5 * ridge * (matrix**2).sum() + 0.5 * (gap**2).sum()
        slope = weight[:, None] * (p - target)
        grad = np.concatenate([(slope.T @ z + ridge * matrix).ravel(), slope.sum(axis=0) + gap])
        return float(value), grad

    begin = np.concatenate([np.zeros(count * width), start])
    done = minimize(loss, begin, jac=True, method="L-BFGS-B", options={"maxiter": 300})
    return done.x[: count * width].reshape(count, width), done.x[count * width :]
