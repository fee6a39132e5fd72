"""The built-in features of paths."""

from __future__ import annotations

from demospec.rules.constraints.features import _kinematic as k
from demospec.rules.constraints.features import _spatial as s
from demospec.rules.constraints.features._feature import Feature

BUILT_IN = (
    Feature(
        "distance", s.distance, "length", ("at_least",), "class", sectors=True,
        words=(("at_least", "keeps at least {value} {side} {of}"),), low="near", high="far",
    ),
    Feature(
        "near", s.near, "length", ("at_most",), "class",
        words=(("at_most", "comes within {value} of {of}"),), low="near", high="far",
    ),
    Feature(
        "between", s.between, "length", ("at_least",), "pair",
        words=(("at_least", "keeps at least {value} from the line between {of}"),),
        low="near", high="far",
    ),
    Feature(
        "height", k.height, "length", ("at_least", "at_most"),
        words=(("at_least", "stays at least {value} high"),
               ("at_most", "stays at most {value} high")),
        low="low", high="high",
    ),
    Feature(
        "height_over", s.height_over, "length", ("at_least",), "class",
        words=(("at_least", "passes at least {value} over {of}"),), low="low", high="high",
    ),
    Feature(
        "tilt", k.tilt, "deg", ("at_most",),
        words=(("at_most", "keeps its tilt at most {value}"),), low="upright", high="tilted",
    ),
    Feature(
        "speed", k.speed, "speed", ("at_most",), when=True,
        words=(("at_most", "moves at most {value}{where}"),), low="slow", high="fast",
    ),
    Feature(
        "dwell", k.dwell, "time", ("at_most",), "class", when=True,
        words=(("at_most", "stays at most {value}{where}"),), low="brief", high="long",
    ),
    Feature(
        "length", k.length, "length", ("at_most", "at_least"),
        words=(("at_most", "takes a way of at most {value}"),
               ("at_least", "takes a way of at least {value}")),
        low="short", high="long",
    ),
    Feature(
        "duration", k.duration, "time", ("at_most", "at_least"),
        words=(("at_most", "takes at most {value}"), ("at_least", "takes at least {value}")),
        low="brief", high="long",
    ),
    Feature(
        "curvature", k.curvature, "deg", ("at_most",),
        words=(("at_most", "turns at most {value} in all"),), low="straight", high="bent",
    ),
    Feature(
        "edge", s.edge, "length", ("at_least",),
        words=(("at_least", "keeps at least {value} from the edge of the table"),),
        low="near", high="far",
    ),
    Feature(
        "region", s.region, "length", ("at_least", "at_most"), "region",
        words=(("at_least", "keeps at least {value} out of {of}"),
               ("at_most", "stays in {of}, at most {value} outside")),
        low="inside", high="outside",
    ),
)  # fmt: skip
