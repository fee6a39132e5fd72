"""Rule problems of the clearance family: objects, labelled trajectories, one answer."""

from __future__ import annotations

import math
import os
import time
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import numpy as np

from demospec.demonstrations import MAX_COORDINATE, checked_points
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import bounds_of, extent
from demospec.rules._evidence import Evidence
from demospec.rules._fit import fit
from demospec.rules._problem_fields import unread_fields
from demospec.rules.clearance._encounters import Passes, passes
from demospec.rules.clearance._fit import ClearanceFit
from demospec.rules.clearance._measure import Distance, nearest_approach
from demospec.rules.clearance._posterior import Sharing
from demospec.scene import Disc, Footprint, MultiPolygon, Polygon, Scene, SceneObject


@dataclass(frozen=True, eq=False)
class ClearanceProblem:
    """Everything that fixes the clearance answer.

    Args:
        scenes: Each lists its objects; `symbol` is the class.
        paths: Points (m_i, 2) of each trajectory, set units.
        scene_of: (n,) scene of each trajectory.
        valid: (n,) labels.
        distance: To the ``footprint`` or to the ``center``.
        sharing: See `fit`.
    """

    scenes: tuple[Scene, ...]
    paths: tuple[FloatArray, ...]
    scene_of: tuple[int, ...]
    valid: tuple[bool, ...]
    distance: Distance = "footprint"
    sharing: Sharing = "average"

    @property
    def symbols(self) -> tuple[str, ...]:
        """Classes in order of first appearance."""
        seen = {o.symbol: None for s in self.scenes for o in s.listed_objects()}
        return tuple(seen)

    def evidence(self) -> Evidence:
        """The trajectories, measured."""
        near = np.full((len(self.paths), len(self.symbols)), np.inf)
        shown = [
            (scene, np.array([i for i, at in enumerate(self.scene_of) if at == s], dtype=np.int64))
            for s, scene in enumerate(self.scenes)
        ]
        places = [
            (scene, rows, [self.paths[i] for i in rows]) for scene, rows in shown if len(rows)
        ]
        for scene, rows, paths in places:
            near[rows] = nearest_approach(scene, paths, self.symbols, distance=self.distance)

        def met() -> Passes:
            return Passes.joined(
                [
                    (rows, passes(scene, paths, self.symbols, distance=self.distance,
                                  unit=self.extent / 100))
                    for scene, rows, paths in places
                ]
            )  # fmt: skip

        return Evidence.of(
            near, np.array(self.valid), self.symbols, extent=self.extent,
            distance=self.distance, encounters=cache(met),
        )  # fmt: skip

    @property
    def extent(self) -> float:
        """The length scale: of every scene with trajectories, the longer side of the box around
        these and its objects; the median of those."""
        sides = []
        for s, scene in enumerate(self.scenes):
            mine = [path for path, at in zip(self.paths, self.scene_of, strict=True) if at == s]
            if mine:
                sides.append(extent(bounds_of(mine, [o.outline for o in scene.listed_objects()])))
        return float(np.median(sides))


def solve_clearance(problem: ClearanceProblem) -> ClearanceFit:
    """The posterior of a clearance problem; InputError where it has no trajectory.

    Its objects stand where it says (`fit`, ``trusted``): whoever writes a problem has
    measured them.
    """
    if not problem.paths:
        raise InputError("at least one trajectory", "none", field="trajectories")
    (found,) = fit(problem.evidence(), sharing=problem.sharing, trusted=True).people.values()
    return found


def clearance_answer(problem: ClearanceProblem) -> dict[str, Any]:
    """The JSON answer: status, relevant, uninformed, interval, value, seconds, settings.

    ``infeasible`` means that no clearances agree with every label; the point answer is then
    the most probable one and `contradicted` names what it gets wrong.
    """
    began = time.perf_counter()
    fit = solve_clearance(problem)
    rule = fit.rule
    return {
        "family": "clearance",
        "status": "optimal" if fit.consistent else "infeasible",
        "relevant": list(rule.relevant),
        "uninformed": list(rule.uninformed),
        "undecided": list(fit.undecided),
        "interval": {s: [finite(a), finite(b)] for s, (a, b) in rule.interval.items()},
        "interval_kind": fit.interval_kind,
        "value": dict(rule.value),
        "probability": dict(fit.probability),
        "subsets": [{"classes": list(names), "probability": p} for names, p in fit.subsets],
        "at_most": {s: finite(v) for s, v in fit.at_most.items()},
        "contradicted": list(fit.contradicted),
        "fewest_classes": fit.fewest,
        "exact": fit.exact,
        "mode": "full",
        "seconds": time.perf_counter() - began,
        "settings": {"distance": problem.distance, "sharing": problem.sharing, "floor": 0.0},
    }


def finite(value: float) -> float | None:
    """The number, or None where there is no bound."""
    return float(value) if math.isfinite(value) else None


def read_clearance_problem(path: str | os.PathLike[str]) -> ClearanceProblem:
    """Reads a problem of the clearance family; InputError names file and field."""
    from demospec.files import read_json

    try:
        return clearance_problem_from_document(read_json(path))
    except InputError as error:
        raise error.at(file=path) from error


def clearance_problem_from_document(document: Any) -> ClearanceProblem:
    """A clearance problem from its JSON document.

    Objects carry ``polygons`` (several parts), ``polygon``, or ``radius`` about their
    ``center``; with none of them they count as points, as under ``"distance": "center"``.
    """
    top = _mapping(document, "a rule problem (an object {…})", None)
    if top.get("family") != "clearance":
        raise InputError("family clearance", top.get("family"), field="family")
    unread_fields(top, "clearance")
    distance = _choice(top.get("distance", "footprint"), ("footprint", "center"), "distance")
    sharing = _choice(top.get("sharing", "average"), ("average", "shared", "separate"), "sharing")
    for name in ("scenes", "trajectories"):
        if name not in top:
            raise InputError(f"the field {name}", "nothing", field=name)
    scenes = tuple(
        _scene(item, f"scenes[{i}]", i) for i, item in enumerate(_list(top["scenes"], "scenes"))
    )
    if not scenes:
        raise InputError("at least one scene", "none", field="scenes")
    paths, scene_of, valid = [], [], []
    for i, item in enumerate(_list(top["trajectories"], "trajectories")):
        at = f"trajectories[{i}]"
        entry = _mapping(item, "a trajectory (an object {…})", at)
        where = entry.get("scene", 0)
        if isinstance(where, bool) or not isinstance(where, int) or not 0 <= where < len(scenes):
            raise InputError(f"a scene from 0 to {len(scenes) - 1}", where, field=f"{at}.scene")
        if not isinstance(entry.get("valid"), bool):
            raise InputError("true or false", entry.get("valid"), field=f"{at}.valid")
        try:
            paths.append(checked_points(_list(entry.get("points"), f"{at}.points"))[:, :2])
        except InputError as error:
            raise InputError(error.expected, error.found, field=f"{at}.points") from error
        scene_of.append(where)
        valid.append(entry["valid"])
    if not paths:
        raise InputError("at least one trajectory", "none", field="trajectories")
    return ClearanceProblem(
        scenes,
        tuple(paths),
        tuple(scene_of),
        tuple(valid),
        cast(Distance, distance),
        cast(Sharing, sharing),
    )


def _scene(value: Any, at: str, index: int) -> Scene:
    entry = _mapping(value, "a scene (an object {…})", at)
    items: list[SceneObject] = []
    for k, raw in enumerate(_list(entry.get("objects", []), f"{at}.objects")):
        where = f"{at}.objects[{k}]"
        item = _mapping(raw, "an object {…}", where)
        name = _word(item.get("id"), f"{where}.id")
        if any(o.id == name for o in items):
            raise InputError("ids that differ", name, field=f"{where}.id")
        symbol = _word(item.get("class", item.get("symbol", name)), f"{where}.class")
        center = _numbers(item.get("center"), 2, f"{where}.center")
        shape: Footprint | None = None
        if item.get("polygons") is not None:
            parts = _list(item["polygons"], f"{where}.polygons")
            shape = MultiPolygon([_polygon(p, f"{where}.polygons") for p in parts])
        elif item.get("polygon") is not None:
            shape = _polygon(item["polygon"], f"{where}.polygon")
        elif item.get("radius") is not None:
            radius = _numbers([item["radius"]], 1, f"{where}.radius")[0]
            if radius < 0:
                raise InputError("a radius of at least 0", radius, field=f"{where}.radius")
            shape = Disc((center[0], center[1]), radius)
        items.append(SceneObject(name, symbol, (center[0], center[1]), None, shape))
    name = entry.get("id", entry.get("scene_id", str(index)))
    ends = ((0.0, 0.0), (0.0, 0.0))
    return Scene(_word(name, f"{at}.id"), *ends, objects=tuple(items))


def _polygon(value: Any, field: str) -> Polygon:
    expected = f"at least three [x, y] corners of size at most {MAX_COORDINATE:g}"
    try:
        shape = Polygon(value)
    except (InputError, TypeError, ValueError, OverflowError) as error:
        raise InputError(expected, value, field=field) from error
    if np.abs(shape.vertices).max() > MAX_COORDINATE:
        raise InputError(expected, value, field=field)
    return shape


def _mapping(value: Any, expected: str, field: str | None) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(expected, value, field=field)
    return value


def _list(value: Any, field: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError("a list [...]", value, field=field)
    return value


def _word(value: Any, field: str) -> str:
    if not isinstance(value, str) or not value:
        raise InputError("a word", value, field=field)
    return value


def _choice(value: Any, allowed: tuple[str, ...], field: str) -> str:
    if value not in allowed:
        raise InputError(f"one of {', '.join(allowed)}", value, field=field)
    return str(value)


def _numbers(value: Any, count: int, field: str) -> list[float]:
    expected = f"{count} finite numbers of size at most 1e+09" if count > 1 else "a finite number"
    if not isinstance(value, list) or len(value) < count:
        raise InputError(expected, value, field=field)
    for number in value[:count]:
        wrong = isinstance(number, bool) or not isinstance(number, int | float)
        if wrong or not abs(number) <= 1e9:
            raise InputError(expected, value, field=field)
    return [float(number) for number in value[:count]]
