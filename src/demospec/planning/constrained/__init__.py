"""Planning with constraints: zones, sides, places to come to, heights, speeds."""

from demospec.planning.constrained._areas import forbidden_areas
from demospec.planning.constrained._asked import requirements_of
from demospec.planning.constrained._checks import checks_of, with_constraints, words_of
from demospec.planning.constrained._obstacles import Obstacle, Via, outline, path_clear
from demospec.planning.constrained._plan import shortest_way
from demospec.planning.constrained._planned import planned_with_constraints
from demospec.planning.constrained._requirements import Requirements
from demospec.planning.constrained._shorten import length as path_length
from demospec.planning.constrained._signals import margin_signals
from demospec.planning.constrained._timing import SpeedLimit, TimeLimit, timed

__all__ = [
    "Obstacle",
    "Requirements",
    "SpeedLimit",
    "TimeLimit",
    "Via",
    "checks_of",
    "forbidden_areas",
    "margin_signals",
    "outline",
    "path_clear",
    "path_length",
    "planned_with_constraints",
    "requirements_of",
    "shortest_way",
    "timed",
    "with_constraints",
    "words_of",
]
