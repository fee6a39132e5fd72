"""Registry of the features that a rule may speak of.

A path feature turns a motion in a scene into its worst value and the place of it; constraints,
learning, the scan of residuals, explanations and checks all ask this one registry. A point
feature gives every point a number and serves the thresholds of influence rules.
"""

from __future__ import annotations

from demospec.errors import InputError
from demospec.rules.constraints.features._built_in import BUILT_IN
from demospec.rules.constraints.features._feature import Feature
from demospec.rules.constraints.features._point_features import FEATURES as POINT_FEATURES
from demospec.rules.constraints.features._point_features import PointFeature

_FEATURES: dict[str, Feature] = {feature.name: feature for feature in BUILT_IN}


def path_features() -> tuple[Feature, ...]:
    """All features that there are, built in and registered."""
    return tuple(_FEATURES.values())


def constraint_feature(name: str) -> Feature:
    """The feature of that name; InputError lists the names there are."""
    if name not in _FEATURES:
        raise InputError(f"one of the features {', '.join(_FEATURES)}", name, field="feature")
    return _FEATURES[name]


def register_feature(feature: Feature | PointFeature) -> None:
    """Makes a feature known by its name.

    A `Feature` of a path may then stand in rule files; it is learned, explained and checked as
    the built-in ones are. A `PointFeature` serves influence rules.

    Raises:
        InputError: Another feature has that name.
    """
    if isinstance(feature, PointFeature):
        if POINT_FEATURES.get(feature.name, feature) != feature:
            raise InputError("a name that no feature has yet", feature.name, field="feature")
        POINT_FEATURES[feature.name] = feature
        return
    if _FEATURES.get(feature.name, feature) != feature:
        raise InputError("a name that no feature has yet", feature.name, field="feature")
    _FEATURES[feature.name] = feature
