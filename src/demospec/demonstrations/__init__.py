"""Demonstrations: paths, Bézier curves, labelled sets and their files, the model protocol.

Names load on first use: who reads a set does not wait for what draws one.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from demospec.demonstrations import _edit as edit
    from demospec.demonstrations._bezier import (
        bernstein,
        bezier_basis,
        bezier_points,
        control_gradients,
        densify,
        fit_bezier,
        resample,
    )
    from demospec.demonstrations._check import CheckReport, Problem, check_set
    from demospec.demonstrations._partition import count_rows, cut_rows, read_part
    from demospec.demonstrations._protocol import (
        DifferentiableView,
        Paths,
        ValidityModel,
        View,
        p_valid_mean,
    )
    from demospec.demonstrations._sample import sample_set
    from demospec.demonstrations._schema import parse
    from demospec.demonstrations._set import DemonstrationSet
    from demospec.demonstrations._simulate import random_paths, simulate_set
    from demospec.demonstrations._simulate_truth import true_clearances
    from demospec.demonstrations._store import pictures_in_memory, read_set, write_set
    from demospec.demonstrations._stream import iterate_batches
    from demospec.demonstrations._trajectory import (
        MAX_COORDINATE,
        MAX_POINTS,
        Demonstration,
        Demonstrations,
        checked_points,
    )

__all__ = [
    "MAX_COORDINATE",
    "MAX_POINTS",
    "CheckReport",
    "Demonstration",
    "DemonstrationSet",
    "Demonstrations",
    "DifferentiableView",
    "Paths",
    "Problem",
    "ValidityModel",
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
    "iterate_batches",
    "read_part",
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
    "CheckReport": "_check",
    "Demonstration": "_trajectory",
    "DemonstrationSet": "_set",
    "Demonstrations": "_trajectory",
    "DifferentiableView": "_protocol",
    "MAX_COORDINATE": "_trajectory",
    "MAX_POINTS": "_trajectory",
    "Paths": "_protocol",
    "Problem": "_check",
    "ValidityModel": "_protocol",
    "View": "_protocol",
    "bernstein": "_bezier",
    "bezier_basis": "_bezier",
    "bezier_points": "_bezier",
    "check_set": "_check",
    "checked_points": "_trajectory",
    "control_gradients": "_bezier",
    "count_rows": "_partition",
    "cut_rows": "_partition",
    "densify": "_bezier",
    "fit_bezier": "_bezier",
    "iterate_batches": "_stream",
    "p_valid_mean": "_protocol",
    "parse": "_schema",
    "pictures_in_memory": "_store",
    "random_paths": "_simulate",
    "read_part": "_partition",
    "read_set": "_store",
    "resample": "_bezier",
    "sample_set": "_sample",
    "simulate_set": "_simulate",
    "true_clearances": "_simulate_truth",
    "write_set": "_store",
}


def __getattr__(name: str) -> Any:
    if name == "edit":
        return importlib.import_module("demospec.demonstrations._edit")
    if name in _HOME:
        return getattr(importlib.import_module(f"demospec.demonstrations.{_HOME[name]}"), name)
    raise AttributeError(f"module 'demospec.demonstrations' has no attribute {name!r}")
