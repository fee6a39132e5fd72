"""Rules: types, exact engines, envelopes, conflicts, queries.

Light names load at once, engines on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.rules._rule_set import ANYONE, ClearanceRule, RuleSet, RuleView, TypeRules
from demospec.rules.clearance._measure import nearest_approach

if TYPE_CHECKING:
    from demospec.rules._answer_problem import ProblemAnswer, answer_problem
    from demospec.rules._documents import (
        clearance_document,
        read_rules,
        rules_document,
        rules_from_document,
    )
    from demospec.rules._evidence import Column, Evidence
    from demospec.rules._fit import FitMemory, Mode, Posterior, fit, fit_clearance
    from demospec.rules._fit_to_labels import goodness_of
    from demospec.rules._goodness import Fit as LabelFit
    from demospec.rules._goodness import fit_from_json
    from demospec.rules._learn import learn_rules
    from demospec.rules._learning_curve import enough_problem, enough_set, enough_words
    from demospec.rules._measurement import Observer, evidence_of
    from demospec.rules._sentences import clearance_words, listed, plural
    from demospec.rules._units import rules_for_set, rules_in_unit
    from demospec.rules._verdicts import Known, known_of, refuse_unexplained
    from demospec.rules.active._of_set import query_set
    from demospec.rules.active._query import next_query, query_file
    from demospec.rules.active._result import Query
    from demospec.rules.clearance._encounters import Encounters, Passes, encounters, passes
    from demospec.rules.clearance._fit import ClearanceFit, fit_document
    from demospec.rules.constraints._beside import fit_with_constraints
    from demospec.rules.constraints._constraint import Constraint, When
    from demospec.rules.constraints._documents import constraint_from_json
    from demospec.rules.constraints._judge import Worst, margin, margins, worst
    from demospec.rules.constraints._learned import Learned
    from demospec.rules.constraints._left_out import kept_by_others
    from demospec.rules.constraints._simulate import simulate_by_rule
    from demospec.rules.constraints._words import (
        broken_parts,
        broken_words,
        constraint_words,
        quantity_words,
    )
    from demospec.rules.constraints.features._feature import Feature, FeatureValue
    from demospec.rules.constraints.features._point_features import PointFeature
    from demospec.rules.constraints.features._registry import (
        constraint_feature,
        path_features,
        register_feature,
    )
    from demospec.rules.constraints.features._spatial import (
        joined_things,
        regions_of,
        sector_direction,
        table_of,
    )
    from demospec.rules.influence._answer import InfluenceAnswer
    from demospec.rules.influence._conflict import minimal_conflict
    from demospec.rules.influence._consistent_sets import ConsistentSets, consistent_sets
    from demospec.rules.influence._evaluate import evaluate_rule
    from demospec.rules.influence._learning_curve import (
        ThresholdGrid,
        WidthCurve,
        threshold_grid,
        width_curve,
    )
    from demospec.rules.influence._one_class import PositiveAnswer, solve_positive
    from demospec.rules.influence._problem import (
        Bounds,
        Penalty,
        Reading,
        RuleObject,
        RuleProblem,
        RuleScene,
        RuleTrajectory,
        problem_from_document,
        read_problem,
    )
    from demospec.rules.influence._rule import InfluenceRule, Thresholds
    from demospec.rules.influence._sentences import describe_influence
    from demospec.rules.influence._solve import solve
    from demospec.rules.influence.engines._unknown_f_max import FmaxAnswer, identify_F_max

__all__ = [
    "ANYONE",
    "listed",
    "plural",
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
    "Constraint",
    "When",
    "constraint_from_json",
    "Worst",
    "worst",
    "margin",
    "margins",
    "Feature",
    "FeatureValue",
    "Reading",
    "constraint_feature",
    "path_features",
    "simulate_by_rule",
    "joined_things",
    "regions_of",
    "sector_direction",
    "table_of",
    "broken_parts",
    "broken_words",
    "fit_with_constraints",
    "Learned",
    "kept_by_others",
    "constraint_words",
    "quantity_words",
    "enough_problem",
    "enough_set",
    "enough_words",
    "evaluate_rule",
    "describe_influence",
    "InfluenceAnswer",
    "InfluenceRule",
    "Thresholds",
    "solve",
    "problem_from_document",
    "read_problem",
    "Bounds",
    "RuleTrajectory",
    "RuleObject",
    "RuleScene",
    "Penalty",
    "RuleProblem",
    "clearance_words",
    "ClearanceFit",
    "fit_document",
    "clearance_document",
    "ClearanceRule",
    "RuleSet",
    "RuleView",
    "TypeRules",
    "fit_clearance",
    "fit",
    "FitMemory",
    "Mode",
    "Posterior",
    "Column",
    "Evidence",
    "evidence_of",
    "Observer",
    "Encounters",
    "encounters",
    "Passes",
    "passes",
    "learn_rules",
    "nearest_approach",
    "read_rules",
    "rules_document",
    "rules_from_document",
    "Known",
    "known_of",
    "LabelFit",
    "goodness_of",
    "fit_from_json",
    "rules_for_set",
    "rules_in_unit",
    "refuse_unexplained",
]

_HOME = {
    "Query": "active._result",
    "next_query": "active._query",
    "query_file": "active._query",
    "query_set": "active._of_set",
    "answer_problem": "_answer_problem",
    "ProblemAnswer": "_answer_problem",
    "minimal_conflict": "influence._conflict",
    "WidthCurve": "influence._learning_curve",
    "width_curve": "influence._learning_curve",
    "ThresholdGrid": "influence._learning_curve",
    "threshold_grid": "influence._learning_curve",
    "FmaxAnswer": "influence.engines._unknown_f_max",
    "identify_F_max": "influence.engines._unknown_f_max",
    "PositiveAnswer": "influence._one_class",
    "solve_positive": "influence._one_class",
    "ConsistentSets": "influence._consistent_sets",
    "consistent_sets": "influence._consistent_sets",
    "register_feature": "constraints.features._registry",
    "Constraint": "constraints._constraint",
    "When": "constraints._constraint",
    "constraint_from_json": "constraints._documents",
    "Worst": "constraints._judge",
    "worst": "constraints._judge",
    "margin": "constraints._judge",
    "margins": "constraints._judge",
    "Feature": "constraints.features._feature",
    "FeatureValue": "constraints.features._feature",
    "constraint_feature": "constraints.features._registry",
    "path_features": "constraints.features._registry",
    "simulate_by_rule": "constraints._simulate",
    "joined_things": "constraints.features._spatial",
    "regions_of": "constraints.features._spatial",
    "sector_direction": "constraints.features._spatial",
    "table_of": "constraints.features._spatial",
    "broken_parts": "constraints._words",
    "broken_words": "constraints._words",
    "fit_with_constraints": "constraints._beside",
    "Learned": "constraints._learned",
    "kept_by_others": "constraints._left_out",
    "constraint_words": "constraints._words",
    "quantity_words": "constraints._words",
    "PointFeature": "constraints.features._point_features",
    "enough_problem": "_learning_curve",
    "enough_set": "_learning_curve",
    "enough_words": "_learning_curve",
    "evaluate_rule": "influence._evaluate",
    "describe_influence": "influence._sentences",
    "InfluenceAnswer": "influence._answer",
    "InfluenceRule": "influence._rule",
    "Thresholds": "influence._rule",
    "solve": "influence._solve",
    "problem_from_document": "influence._problem",
    "read_problem": "influence._problem",
    "Bounds": "influence._problem",
    "RuleTrajectory": "influence._problem",
    "RuleObject": "influence._problem",
    "RuleScene": "influence._problem",
    "Penalty": "influence._problem",
    "Reading": "influence._problem",
    "RuleProblem": "influence._problem",
    "Passes": "clearance._encounters",
    "passes": "clearance._encounters",
    "ClearanceFit": "clearance._fit",
    "fit_document": "clearance._fit",
    "clearance_document": "_documents",
    "fit_clearance": "_fit",
    "fit": "_fit",
    "FitMemory": "_fit",
    "Mode": "_fit",
    "Posterior": "_fit",
    "Column": "_evidence",
    "Evidence": "_evidence",
    "evidence_of": "_measurement",
    "Observer": "_measurement",
    "Encounters": "clearance._encounters",
    "encounters": "clearance._encounters",
    "clearance_words": "_sentences",
    "listed": "_sentences",
    "plural": "_sentences",
    "learn_rules": "_learn",
    "read_rules": "_documents",
    "rules_document": "_documents",
    "rules_from_document": "_documents",
    "rules_for_set": "_units",
    "rules_in_unit": "_units",
    "refuse_unexplained": "_verdicts",
    "Known": "_verdicts",
    "known_of": "_verdicts",
    "LabelFit": "_goodness:Fit",
    "goodness_of": "_fit_to_labels",
    "fit_from_json": "_goodness",
}


__getattr__ = names_of(__name__, _HOME)
