"""Demonstrations: paths, Bézier curves, labelled sets and their files, the model protocol."""

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
from demospec.demonstrations._partition import cut_rows, read_part
from demospec.demonstrations._protocol import (
    DifferentiableView,
    Paths,
    ValidityModel,
    View,
    p_valid_mean,
)
from demospec.demonstrations._schema import parse
from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._simulate import random_paths, simulate_set
from demospec.demonstrations._simulate_truth import true_clearances
from demospec.demonstrations._store import pictures_in_memory, read_set, write_set
from demospec.demonstrations._stream import count_rows, iterate_batches, sample_set
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
