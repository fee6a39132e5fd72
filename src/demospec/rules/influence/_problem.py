"""Rule problem of the influence family: objects, labelled trajectories, and a reading.

A point p influences through object k when its distance d_k(p) is at most r_k = T_min +
T_object-k; a point within T_min of any object makes the whole trajectory infinitely bad. A
valid demonstration has no such point and Σ_i f(p_i) < F_max; an invalid one has such a point
or Σ_i f(p_i) ≥ F_max. Source: Angelov et al., "Parameterization of Specifications"; where the
paper is loose, `Reading`, `Penalty` and `Weights` name the ways to take it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._problem_fields import unread_fields
from demospec.rules.constraints.features._point_features import feature_named

Reading = Literal["sum", "nearest", "nearest_active", "max_active", "first"]
Penalty = Literal["distance", "hinge", "count"]
Weights = Literal["points", "arc"]
Thresholds = Literal["instance", "class"]

MONOTONE: Mapping[str, frozenset[str]] = {
    "sum": frozenset({"distance", "hinge", "count"}),
    "nearest": frozenset({"distance", "hinge", "count"}),
    "max_active": frozenset({"distance", "hinge", "count"}),
    "nearest_active": frozenset({"count"}),
    "first": frozenset({"count"}),
}
"""Reading → penalties for which a larger radius never makes a trajectory better."""

PRESETS: Mapping[str, Mapping[str, str]] = {
    "physical": {"reading": "sum", "penalty": "hinge", "weights": "arc"}
}
"""``physical``: deeper costs more, and the sampling rate does not matter."""

ARC_QUANTA = 1_000
"""Quanta of length in one unit: positions along a path are rounded to them (weights arc)."""

ARC_FINE = 1_000_000
"""Parts of a quantum to which each step's length is rounded before positions are summed."""

MAX_BOUND = 100_000

MAX_F = 10**9
"""Largest F_max of a problem."""

MAX_COORDINATE = 1e15
"""Largest size of a coordinate: squares of it, scaled, are far from overflow."""


@dataclass(frozen=True)
class Bounds:
    """Domains of the parameters: whole numbers of set units, both ends included.

    The paper's table reads as if [1, 100]; it does not say.
    """

    T_min: tuple[int, int] = (1, 100)
    T_object: tuple[int, int] = (1, 100)

    def __post_init__(self) -> None:
        for name in ("T_min", "T_object"):
            low, high = getattr(self, name)
            if not 0 <= low <= high <= MAX_BOUND:
                raise InputError(
                    f"[low, high] with 0 <= low <= high <= {MAX_BOUND}",
                    [low, high],
                    field=f"bounds.{name}",
                )

    @property
    def radius(self) -> tuple[int, int]:
        """Least and greatest r_k = T_min + T_object-k."""
        return self.T_min[0] + self.T_object[0], self.T_min[1] + self.T_object[1]


@dataclass(frozen=True)
class RuleObject:
    """One object of a rule problem.

    Args:
        id: Unique in its scene.
        cls: Its class; objects of a class share a threshold where thresholds go by class.
        center: 2 or 3 coordinates, set units. Two: distances are taken in the plane.
        feature: Name of the point feature, see `PointFeature`.
    """

    id: str
    cls: str
    center: tuple[float, ...]
    feature: str = "distance"


@dataclass(frozen=True)
class RuleScene:
    """One scene: its objects, and its name where there are several."""

    objects: tuple[RuleObject, ...]
    id: str | None = None


@dataclass(frozen=True, eq=False)
class RuleTrajectory:
    """One labelled demonstration: points (n, c), n ≥ 1, c ≥ 2, set units, as recorded."""

    scene: int
    valid: bool
    points: FloatArray
    id: str | None = None


@dataclass(frozen=True, eq=False)
class RuleProblem:
    """Everything that fixes the set of consistent parameters. See the module's text.

    Args:
        scenes: At least one.
        trajectories: May be empty: then every parameter set is consistent.
        F_max: Bound on the summed penalty, unscaled; None where it is to be identified.
        scale: Penalties are rounded half up to 1/scale of a unit.
        reading: Which objects of the discs that hold a point count: all (`sum`); the nearest
            of all objects, if its disc holds it (`nearest`); the nearest of those whose
            disc holds it (`nearest_active`); the one that costs most (`max_active`); the
            first in the list of objects (`first`).
        penalty: d (`distance`, as in the paper), r_k − d (`hinge`), or 1 (`count`).
        weights: Points alike, or each by half the length of path beside it (`arc`). Positions
            along the path, measured from its middle, are rounded half up in size to 1/1000 of a
            unit, whatever `scale` and the sampling rate are; a point's weight is the difference
            of its neighbours' positions. So the weights of a stretch of path add up to its
            length within 1/1000, however many points it has.
        thresholds: One T_object per object (`instance`) or per class (`class`).
        bounds: Domains of T_min and T_object.
    """

    scenes: tuple[RuleScene, ...]
    trajectories: tuple[RuleTrajectory, ...]
    F_max: int | None = 60
    scale: int = 1000
    reading: Reading = "sum"
    penalty: Penalty = "distance"
    weights: Weights = "points"
    thresholds: Thresholds = "instance"
    bounds: Bounds = field(default_factory=Bounds)

    def __post_init__(self) -> None:
        _choice(self.reading, get_args(Reading), "reading")
        _choice(self.penalty, get_args(Penalty), "penalty")
        _choice(self.weights, get_args(Weights), "weights")
        _choice(self.thresholds, get_args(Thresholds), "thresholds")
        if not 1 <= self.scale <= 10**6:
            raise InputError("a whole number from 1 to 1000000", self.scale, field="scale")
        if self.F_max is not None and not 0 <= self.F_max <= MAX_F:
            raise InputError("a whole number from 0 to 1e9", self.F_max, field="F_max")
        if not self.scenes:
            raise InputError("at least one scene", "none", field="scenes")
        self._check_scenes()
        self._check_trajectories()

    def _check_scenes(self) -> None:
        seen_scenes: set[str] = set()
        for s, scene in enumerate(self.scenes):
            if scene.id is not None and scene.id in seen_scenes:
                raise InputError("ids that differ", scene.id, field=f"scenes[{s}].id")
            seen_scenes.add(scene.id if scene.id is not None else str(s))
            seen: set[str] = set()
            for k, item in enumerate(scene.objects):
                where = f"scenes[{s}].objects[{k}]"
                if item.id in seen:
                    raise InputError("ids that differ", item.id, field=f"{where}.id")
                seen.add(item.id)
                if len(item.center) not in (2, 3) or not _moderate(item.center):
                    raise InputError(
                        f"2 or 3 {_FINITE}", list(item.center), field=f"{where}.center"
                    )
                feature_named(item.feature)

    def _check_trajectories(self) -> None:
        needed = [
            max(
                (max(len(o.center), feature_named(o.feature).columns) for o in s.objects), default=2
            )
            for s in self.scenes
        ]
        seen: set[str] = set()
        for i, path in enumerate(self.trajectories):
            where = f"trajectories[{i}]"
            if not 0 <= path.scene < len(self.scenes):
                raise InputError(
                    f"a scene from 0 to {len(self.scenes) - 1}", path.scene, field=f"{where}.scene"
                )
            if path.id is not None and path.id in seen:
                raise InputError("ids that differ", path.id, field=f"{where}.id")
            if path.id is not None:
                seen.add(path.id)
            shape = path.points.shape
            if len(shape) != 2 or shape[0] < 1 or shape[1] < needed[path.scene]:
                raise InputError(
                    f"at least one point of at least {needed[path.scene]} numbers",
                    f"shape {shape}",
                    field=f"{where}.points",
                )
            if not _moderate(path.points):
                row = int(np.flatnonzero(~(np.abs(path.points) <= MAX_COORDINATE).all(axis=1))[0])
                raise InputError(_FINITE, path.points[row].tolist(), field=f"{where}.points[{row}]")

    @property
    def unit(self) -> int:
        """One F_max in what sums are counted in: 1/scale, times half quanta of length for `arc`."""
        return self.scale if self.weights == "points" else 2 * ARC_QUANTA * self.scale

    @property
    def monotone(self) -> bool:
        """Whether a larger radius never makes any trajectory better."""
        return self.penalty in MONOTONE[self.reading]

    @cached_property
    def parameter_of(self) -> tuple[tuple[int, ...], ...]:
        """Scene → object → index of its parameter in `parameters`."""
        index: dict[str, int] = {}
        return tuple(
            tuple(index.setdefault(self._name(s, item), len(index)) for item in scene.objects)
            for s, scene in enumerate(self.scenes)
        )

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Names of the T_object in order of first appearance.

        The object's id (one scene), ``scene/id`` (several), or the class.
        """
        names: dict[str, None] = {}
        for s, scene in enumerate(self.scenes):
            for item in scene.objects:
                names.setdefault(self._name(s, item))
        return tuple(names)

    def _name(self, scene: int, item: RuleObject) -> str:
        if self.thresholds == "class":
            return item.cls
        if len(self.scenes) == 1:
            return item.id
        return f"{self.scenes[scene].id or scene}/{item.id}"

    @cached_property
    def valid(self) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """(n,) labels."""
        return np.array([path.valid for path in self.trajectories], dtype=bool)

    def subset(self, indices: Sequence[int]) -> RuleProblem:
        """The same problem with these trajectories only, in this order."""
        return replace(self, trajectories=tuple(self.trajectories[i] for i in indices))

    def settings(self) -> dict[str, Any]:
        """What an answer repeats, so that it alone can be planned with."""
        return {
            "F_max": self.F_max,
            "scale": self.scale,
            "reading": self.reading,
            "penalty": self.penalty,
            "weights": self.weights,
            "thresholds": self.thresholds,
            "bounds": {"T_min": list(self.bounds.T_min), "T_object": list(self.bounds.T_object)},
        }


_FINITE = f"finite numbers of size at most {MAX_COORDINATE:g}"


def _moderate(numbers: ArrayLike) -> bool:
    return bool((np.abs(np.asarray(numbers, dtype=np.float64)) <= MAX_COORDINATE).all())  # not NaN


def _choice(value: str, allowed: Sequence[str], name: str) -> None:
    if value not in allowed:
        raise InputError(f"one of {', '.join(allowed)}", value, field=name)


def read_problem(path: str | os.PathLike[str]) -> RuleProblem:
    """Reads a rule problem of the influence family from a JSON file.

    Raises:
        InputError: Unreadable, not JSON, a field missing or wrong: names file and field.
    """
    from demospec.files import read_json

    try:
        return problem_from_document(read_json(path))
    except InputError as error:
        raise error.at(file=path) from error


def problem_from_document(document: Any) -> RuleProblem:
    """A rule problem from its JSON document (see DESIGN: the rule problem)."""
    top = _mapping(document, "a rule problem (a JSON object)", "")
    family = top.get("family", "influence")
    if family != "influence":
        raise InputError("family influence", family, field="family")
    unread_fields(top, "influence")
    if top.get("quantum", 1) != 1:  # as an answer of a set in metres says it
        expected = "no quantum: a problem counts whole units (write its points in mm, say)"
        raise InputError(expected, top["quantum"], field="quantum")
    distance = top.get("distance", "center")
    if distance != "center":
        raise InputError(
            "distance center (influence measures to centres)", distance, field="distance"
        )
    chosen = dict(_preset(top))
    for name in ("reading", "penalty", "weights", "thresholds"):
        if name in top:
            if name in chosen and chosen[name] != top[name]:
                raise InputError(f"{chosen[name]} (the preset says so)", top[name], field=name)
            if not isinstance(top[name], str):
                raise InputError("a word", top[name], field=name)
            chosen[name] = top[name]
    for name in ("F_max", "scenes", "trajectories"):
        if name not in top:
            raise InputError(f"the field {name}", "nothing", field=name)
    limit = None if top["F_max"] is None else whole(top["F_max"], "F_max")
    return RuleProblem(
        scenes=tuple(
            _scene(item, f"scenes[{s}]") for s, item in enumerate(_list(top["scenes"], "scenes"))
        ),
        trajectories=tuple(
            _trajectory(item, f"trajectories[{i}]")
            for i, item in enumerate(_list(top["trajectories"], "trajectories"))
        ),
        F_max=limit,
        scale=whole(top.get("scale", 1000), "scale"),
        bounds=_bounds(top.get("bounds", {})),
        **chosen,
    )


def _preset(top: Mapping[str, Any]) -> Mapping[str, Any]:
    name = top.get("preset")
    if name is None:
        return {}
    if name not in PRESETS:
        raise InputError(f"one of the presets {', '.join(PRESETS)}", name, field="preset")
    return PRESETS[name]


def _bounds(value: Any) -> Bounds:
    top = _mapping(value, "an object with T_min and T_object", "bounds")
    pairs: dict[str, tuple[int, int]] = {}
    for name in ("T_min", "T_object"):
        if name in top:
            pair = _list(top[name], f"bounds.{name}")
            if len(pair) != 2:
                raise InputError("[low, high]", pair, field=f"bounds.{name}")
            pairs[name] = (whole(pair[0], f"bounds.{name}"), whole(pair[1], f"bounds.{name}"))
    return Bounds(**pairs)


def _scene(value: Any, where: str) -> RuleScene:
    top = _mapping(value, "a scene (a JSON object)", where)
    name = top.get("id", top.get("scene_id"))
    items = []
    for k, item in enumerate(_list(top.get("objects", []), f"{where}.objects")):
        place = f"{where}.objects[{k}]"
        entry = _mapping(item, "an object", place)
        for key in ("id", "center"):
            if key not in entry:
                raise InputError(f"the field {key}", "nothing", field=place)
        id_ = _word(entry["id"], f"{place}.id")
        center = _list(entry["center"], f"{place}.center")
        wrong = [isinstance(c, bool) or not isinstance(c, int | float) for c in center]
        if any(wrong) or any(not abs(c) <= MAX_COORDINATE for c in center):
            raise InputError(f"2 or 3 {_FINITE}", center, field=f"{place}.center")
        items.append(
            RuleObject(
                id_,
                _word(entry.get("class", entry.get("symbol", id_)), f"{place}.class"),
                tuple(float(c) for c in center),
                _word(entry.get("feature", "distance"), f"{place}.feature"),
            )
        )
    return RuleScene(tuple(items), None if name is None else _word(name, f"{where}.id"))


def _trajectory(value: Any, where: str) -> RuleTrajectory:
    top = _mapping(value, "a trajectory (a JSON object)", where)
    for key in ("valid", "points"):
        if key not in top:
            raise InputError(f"the field {key}", "nothing", field=where)
    if not isinstance(top["valid"], bool):
        raise InputError("true or false", top["valid"], field=f"{where}.valid")
    try:
        numbers = np.array(_list(top["points"], f"{where}.points"))
        if numbers.size and numbers.dtype.kind in "US":
            raise ValueError("text")  # "3" is not 3
        points = numbers.astype(np.float64)
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(
            "a list of points of two or more numbers each",
            str(error),
            field=f"{where}.points",
        ) from error
    name = top.get("id", top.get("demo_id"))
    return RuleTrajectory(
        whole(top.get("scene", 0), f"{where}.scene"),
        top["valid"],
        points,
        None if name is None else _word(name, f"{where}.id"),
    )


def whole(value: Any, where: str) -> int:
    """A whole number (60 or 60.0); InputError names the field."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    # Not np.isfinite: it does not take whole numbers beyond 64 bits.
    if not number or value != value or abs(value) == math.inf or value != int(value):
        raise InputError("a whole number", value, field=where)
    return int(value)


def _word(value: Any, where: str) -> str:
    if not isinstance(value, str) or not value:
        raise InputError("a name (text)", value, field=where)
    return value


def _mapping(value: Any, expected: str, where: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise InputError(expected, value, field=where or None)
    return value


def _list(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError("a list", value, field=where)
    return value
