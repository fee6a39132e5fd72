"""Demonstrations: paths, Bézier curves, labelled sets and their files, the model protocol.

Names load on first use: who reads a set does not wait for what draws one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.demonstrations._bezier import (
        bernstein,
        bezier_basis,
        bezier_points,
        control_gradients,
        densify,
        fit_bezier,
        resample,
    )
    from demospec.demonstrations._motion import Motion, Motions
    from demospec.demonstrations._one_unit import in_one_unit
    from demospec.demonstrations._pairs import Pair
    from demospec.demonstrations._protocol import (
        DifferentiableView,
        JudgingView,
        Paths,
        ValidityModel,
        Verdict,
        View,
        p_valid_mean,
    )
    from demospec.demonstrations._schema import object_from_json, parse
    from demospec.demonstrations._set import DemonstrationSet
    from demospec.demonstrations._store import pictures_in_memory, read_set, write_set
    from demospec.demonstrations._trajectory import (
        MAX_COORDINATE,
        MAX_POINTS,
        Demonstration,
        Demonstrations,
        checked_points,
    )
    from demospec.demonstrations.editing import _edit as edit
    from demospec.demonstrations.large._partition import count_rows, cut_rows, read_part
    from demospec.demonstrations.large._sample import sample_set
    from demospec.demonstrations.large._stream import iterate_batches
    from demospec.demonstrations.simulation._details import Details
    from demospec.demonstrations.simulation._simulate import random_paths, simulate_set
    from demospec.demonstrations.simulation._truth import true_clearances
    from demospec.demonstrations.validation._check import CheckReport, Problem, check_set

__all__ = [
    "MAX_COORDINATE",
    "MAX_POINTS",
    "CheckReport",
    "Demonstration",
    "Details",
    "DemonstrationSet",
    "Demonstrations",
    "DifferentiableView",
    "JudgingView",
    "Motion",
    "Motions",
    "Pair",
    "Paths",
    "Problem",
    "ValidityModel",
    "Verdict",
    "View",
    "bernstein",
    "bezier_basis",
    "bezier_points",
    "check_set",
    "checked_points",
    "control_gradients",
    "count_rows",
    "densify",
    "edit",
    "fit_bezier",
    "cut_rows",
    "in_one_unit",
    "iterate_batches",
    "read_part",
    "object_from_json",
    "p_valid_mean",
    "parse",
    "pictures_in_memory",
    "random_paths",
    "read_set",
    "resample",
    "sample_set",
    "simulate_set",
    "true_clearances",
    "write_set",
]

_HOME = {
    "CheckReport": "validation._check",
    "Demonstration": "_trajectory",
    "DemonstrationSet": "_set",
    "Details": "simulation._details",
    "Demonstrations": "_trajectory",
    "DifferentiableView": "_protocol",
    "JudgingView": "_protocol",
    "MAX_COORDINATE": "_trajectory",
    "MAX_POINTS": "_trajectory",
    "Motion": "_motion",
    "Motions": "_motion",
    "Pair": "_pairs",
    "Paths": "_protocol",
    "Problem": "validation._check",
    "ValidityModel": "_protocol",
    "Verdict": "_protocol",
    "View": "_protocol",
    "bernstein": "_bezier",
    "bezier_basis": "_bezier",
    "bezier_points": "_bezier",
    "check_set": "validation._check",
    "checked_points": "_trajectory",
    "control_gradients": "_bezier",
    "count_rows": "large._partition",
    "cut_rows": "large._partition",
    "densify": "_bezier",
    "edit": "editing._edit:",
    "fit_bezier": "_bezier",
    "in_one_unit": "_one_unit",
    "iterate_batches": "large._stream",
    "object_from_json": "_schema",
    "p_valid_mean": "_protocol",
    "parse": "_schema",
    "pictures_in_memory": "_store",
    "random_paths": "simulation._simulate",
    "read_part": "large._partition",
    "read_set": "_store",
    "resample": "_bezier",
    "sample_set": "large._sample",
    "simulate_set": "simulation._simulate",
    "true_clearances": "simulation._truth",
    "write_set": "_store",
}


__getattr__ = names_of(__name__, _HOME)
