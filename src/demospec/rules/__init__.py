"""Rules: types, exact engines, envelopes, conflicts, queries.

Light names load at once, engines on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from demospec.rules._clearance_distance import nearest_approach
from demospec.rules._results import ANYONE, ClearanceRule, RuleSet, RuleView, TypeRules

if TYPE_CHECKING:
    from demospec.rules._answer import InfluenceAnswer, describe_influence
    from demospec.rules._answer_problem import ProblemAnswer, answer_problem
    from demospec.rules._clearance import ClearanceFit, fit_clearance
    from demospec.rules._clearance_passes import Passes, passes
    from demospec.rules._conflict import minimal_conflict
    from demospec.rules._documents import read_rules, rules_document, rules_from_document
    from demospec.rules._enough import enough_problem, enough_set, enough_words
    from demospec.rules._evaluate import evaluate_rule
    from demospec.rules._features import PointFeature, register_feature
    from demospec.rules._fmax import FmaxAnswer, identify_F_max
    from demospec.rules._learn import learn_rules
    from demospec.rules._positive import PositiveAnswer, solve_positive
    from demospec.rules._problem import (
        Bounds,
        RuleObject,
        RuleProblem,
        RuleScene,
        RuleTrajectory,
        problem_from_document,
        read_problem,
    )
    from demospec.rules._query import Query, next_query, query_file
    from demospec.rules._query_set import query_set
    from demospec.rules._sets import ConsistentSets, consistent_sets
    from demospec.rules._solve import solve
    from demospec.rules._sweep_grid import ThresholdGrid, WidthCurve, threshold_grid, width_curve

__all__ = [
    "ANYONE",
    "Query",
    "next_query",
    "query_file",
    "query_set",
    "answer_problem",
    "ProblemAnswer",
    "minimal_conflict",
    "WidthCurve",
    "width_curve",
    "ThresholdGrid",
    "threshold_grid",
    "FmaxAnswer",
    "identify_F_max",
    "PositiveAnswer",
    "solve_positive",
    "ConsistentSets",
    "consistent_sets",
    "register_feature",
    "PointFeature",
    "enough_problem",
    "enough_set",
    "enough_words",
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
    "Passes",
    "passes",
    "learn_rules",
    "nearest_approach",
    "read_rules",
    "rules_document",
    "rules_from_document",
]

_HOME = {
    "Query": "_query",
    "next_query": "_query",
    "query_file": "_query",
    "query_set": "_query_set",
    "answer_problem": "_answer_problem",
    "ProblemAnswer": "_answer_problem",
    "minimal_conflict": "_conflict",
    "WidthCurve": "_sweep_grid",
    "width_curve": "_sweep_grid",
    "ThresholdGrid": "_sweep_grid",
    "threshold_grid": "_sweep_grid",
    "FmaxAnswer": "_fmax",
    "identify_F_max": "_fmax",
    "PositiveAnswer": "_positive",
    "solve_positive": "_positive",
    "ConsistentSets": "_sets",
    "consistent_sets": "_sets",
    "register_feature": "_features",
    "PointFeature": "_features",
    "enough_problem": "_enough",
    "enough_set": "_enough",
    "enough_words": "_enough",
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
    "Passes": "_clearance_passes",
    "passes": "_clearance_passes",
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
