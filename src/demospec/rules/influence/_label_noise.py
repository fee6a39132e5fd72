"""Label noise: contradictions beyond the fewest that the likelihood-ratio set takes in.

Where each label is wrong with probability ε, on its own, the likelihood of parameters that
contradict w of n labels is ε^w·(1 − ε)^(n − w): each further contradiction divides it by
(1 − ε) / ε, 19 at ε = 5 %. The true parameters contradict exactly the wrong labels, which are
often more than the fewest that any parameters contradict. So the envelope of a tolerant fit is
the 95 % likelihood-ratio set: parameters whose likelihood is within
exp(−χ²(95 %, T_min and K thresholds) / 2) of the best.
"""

from __future__ import annotations

import math

from demospec.errors import InputError

LABEL_NOISE = 0.05
"""Share of labels taken to be wrong, unless told otherwise."""

LEFT_OUT = 0.05


def slack_of(label_noise: float, thresholds: int) -> int:
    """Contradictions beyond the fewest that the likelihood-ratio set takes in.

    At ε = 5 %: 1 for up to four thresholds, 2 for five to eight. Wilks' χ² is an
    approximation here (whole numbers, sharp edges): what it covers is measured.

    Args:
        label_noise: ε, from 0 (labels are wrong only where they must be) to below 0.5.
        thresholds: K, the number of T_object; T_min comes on top.
    """
    if not 0 <= label_noise < 0.5:
        raise InputError("a share from 0 to below 0.5", label_noise, field="label_noise")
    if label_noise == 0:
        return 0
    cost = 2 * math.log((1 - label_noise) / label_noise)
    slack = 0
    while _beyond((slack + 1) * cost, thresholds + 1) >= LEFT_OUT:
        slack += 1
    return slack


def _beyond(x: float, freedom: int) -> float:
    """P(χ² ≥ x), in closed form (scipy takes longer to load than a fit)."""
    half = x / 2
    even = freedom % 2 == 0
    term = 1.0 if even else math.sqrt(half) / math.gamma(1.5)
    total = 0.0
    for j in range(freedom // 2):
        total += term
        term *= half / (j + (1 if even else 1.5))
    return (0.0 if even else math.erfc(math.sqrt(half))) + math.exp(-half) * total
