"""Builders for tests: scenes, sets, paths, rule problems with known answers, formulas as models.

Hypothesis strategies are in `demospec.testing.strategies`, which needs hypothesis.
"""

from demospec.testing._contract import check_model
from demospec.testing._models import DiscModel, DiscView, FormulaModel, FormulaView, SlopedDiscView
from demospec.testing._problems import labelled_problem, problem_document, random_problem
from demospec.testing._scenes import (
    GOAL,
    START,
    SYMBOLS,
    bulged_path,
    disc_scene,
    random_paths,
    random_picture,
    random_scene,
)
from demospec.testing._sets import (
    clearance_verdicts,
    colour_set,
    demonstrator_set,
    small_set,
    with_labels,
    write_small_set,
)

__all__ = [
    "GOAL",
    "START",
    "SYMBOLS",
    "DiscModel",
    "DiscView",
    "FormulaModel",
    "FormulaView",
    "SlopedDiscView",
    "bulged_path",
    "check_model",
    "clearance_verdicts",
    "colour_set",
    "demonstrator_set",
    "disc_scene",
    "labelled_problem",
    "problem_document",
    "random_paths",
    "random_picture",
    "random_problem",
    "random_scene",
    "small_set",
    "with_labels",
    "write_small_set",
]
