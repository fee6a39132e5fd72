"""Planning with constraints: zones, sides, places to come to, heights, speeds."""

from demospec.planning.constrained._obstacles import Obstacle, Via, outline, path_clear
from demospec.planning.constrained._plan import shortest_way
from demospec.planning.constrained._shorten import length as path_length
from demospec.planning.constrained._timing import SpeedLimit, TimeLimit, timed

__all__ = [
    "Obstacle",
    "SpeedLimit",
    "TimeLimit",
    "Via",
    "outline",
    "path_clear",
    "path_length",
    "shortest_way",
    "timed",
]
