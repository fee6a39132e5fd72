"""The test of a clearance fit against the labels of the set that it was learned from."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.rules._covariates import covariates_of
from demospec.rules._evidence import Evidence
from demospec.rules._goodness import Fit, goodness_of_fit
from demospec.rules.clearance._fit import ClearanceFit
from demospec.rules.clearance._likelihood import margins


def goodness_of(data: DemonstrationSet, own: Evidence, fit: ClearanceFit) -> Fit:
    """How well one person's fit explains their labels, and what goes with the rest.

    Args:
        data: The set that the evidence was measured in.
        own: The person's demonstrations.
        fit: What was learned from them.
    """
    wrong = np.zeros(len(own), dtype=bool)
    wrong[list(fit.contradicted)] = True
    limit = np.array([[fit.rule.value.get(name, -np.inf) for name in own.names]])
    return goodness_of_fit(
        own.values,
        own.valid,
        predicted=fit.p_valid(own.values),
        wrong=wrong,
        margin=margins(own.values, limit)[0],
        covariates=lambda: covariates_of(data, own.rows, own.names, own.values, own.extent),
    )
