"""Rules: types, exact engines, envelopes, conflicts, queries.

Light names load at once, engines on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from demospec.rules._clearance_distance import nearest_approach
from demospec.rules._results import ClearanceRule, RuleSet, RuleView, TypeRules

if TYPE_CHECKING:
    from demospec.rules._answer import InfluenceAnswer, describe_influence
    from demospec.rules._clearance import ClearanceFit, fit_clearance
    from demospec.rules._documents import read_rules, rules_document, rules_from_document
    from demospec.rules._evaluate import evaluate_rule
    from demospec.rules._features import PointFeature, register_feature
    from demospec.rules._learn import learn_rules
    from demospec.rules._problem import (
        Bounds,
        RuleObject,
        RuleProblem,
        RuleScene,
        RuleTrajectory,
        problem_from_document,
        read_problem,
    )
    from demospec.rules._solve import solve

__all__ = [
    "register_feature",
    "PointFeature",
    "evaluate_rule",
    "describe_influence",
    "InfluenceAnswer",
    "solve",
    "problem_from_document",
    "read_problem",
    "Bounds",
    "RuleTrajectory",
    "RuleObject",
    "RuleScene",
    "RuleProblem",
    "ClearanceFit",
    "ClearanceRule",
    "RuleSet",
    "RuleView",
    "TypeRules",
    "fit_clearance",
    "learn_rules",
    "nearest_approach",
    "read_rules",
    "rules_document",
    "rules_from_document",
]

_HOME = {
    "register_feature": "_features",
    "PointFeature": "_features",
    "evaluate_rule": "_evaluate",
    "describe_influence": "_answer",
    "InfluenceAnswer": "_answer",
    "solve": "_solve",
    "problem_from_document": "_problem",
    "read_problem": "_problem",
    "Bounds": "_problem",
    "RuleTrajectory": "_problem",
    "RuleObject": "_problem",
    "RuleScene": "_problem",
    "RuleProblem": "_problem",
    "ClearanceFit": "_clearance",
    "fit_clearance": "_clearance",
    "learn_rules": "_learn",
    "read_rules": "_documents",
    "rules_document": "_documents",
    "rules_from_document": "_documents",
}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(f"demospec.rules.{_HOME[name]}"), name)
    raise AttributeError(f"module 'demospec.rules' has no attribute {name!r}")
