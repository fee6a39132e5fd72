"""NumPy and OMPL callables: one Python file that needs neither demospec nor a network.

The file holds the zones as numbers and computes exact distances from them, in set units and in
metres, so that a planner on another machine can import it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from demospec.geometry import Capsule, Disc, MultiPolygon, Polygon, rims
from demospec.planning._results import Zone
from demospec.planning.exports._request import ExportRequest


def write_numpy(request: ExportRequest, folder: Path) -> None:
    """``rule.py`` (cost, clearance, margin) and ``cost_map.npz`` (arrays, their frame)."""
    (folder / "rule.py").write_text(_header(request) + _NUMPY, encoding="utf-8")
    where = request.cost_map
    np.savez_compressed(
        folder / "cost_map.npz",
        cost=where.array,
        signed_distance=where.signed_distance,
        forbidden=where.forbidden,
        bounds=np.array(where.bounds),
        cell=np.array(where.cell),
        metres_per_unit=np.array(where.metres_per_unit or np.nan),
    )


def write_ompl(request: ExportRequest, folder: Path) -> None:
    """``rule.py`` with OMPL's validity checker and objective beside the NumPy functions."""
    text = _header(request) + _NUMPY + _OMPL
    (folder / "rule.py").write_text(text, encoding="utf-8")


def _header(request: ExportRequest) -> str:
    where = request.cost_map
    values = {
        "ZONES": [_zone(z) for z in where.zones],
        "BOUNDS": list(where.bounds),
        "WEIGHT": where.weight,
        "UNITS": request.units,
        "Y_AXIS": request.axes.y,
        "FRAME_ID": request.frame_id,
        "METRES_PER_UNIT": where.metres_per_unit,
        "STEP": where.cell / 4,
        "START": list(request.scene.start[:2]),
        "GOAL": list(request.scene.goal[:2]),
    }
    lines = [f"{name} = {value!r}\n" for name, value in values.items()]
    scene, of = json.dumps(request.scene.scene_id), json.dumps(request.plan.type)
    return _DOC + "\nimport numpy as np\n\n" + f"SCENE, TYPE = {scene}, {of}\n" + "".join(lines)


def _zone(zone: Zone) -> dict[str, Any]:
    shape = zone.shape
    document: dict[str, Any] = {"id": str(zone.object_id), "symbol": str(zone.symbol)}
    document |= {"radius": float(zone.radius), "reach": float(zone.reach)}
    if isinstance(shape, Disc):
        ends = [list(map(float, shape.center))] * 2
        return document | {"segment": ends, "thickness": float(shape.radius)}
    if isinstance(shape, Capsule):
        ends = [list(map(float, shape.start)), list(map(float, shape.end))]
        return document | {"segment": ends, "thickness": float(shape.radius)}
    document["polygons"] = [rim.tolist() for rim in rims(shape)]
    known = shape if isinstance(shape, MultiPolygon) else Polygon(document["polygons"][0])
    return document | {"rim": [ends.tolist() for ends in known.edges]}


_DOC = '''"""A rule as functions of places. Written by demospec; needs NumPy only.

Places are (x, y) in the units and the frame of the set (UNITS, Y_AXIS; METRES_PER_UNIT).
`cost(p)` is the price of a unit of length, >= 1; `clearance(p)` the signed distance to the
nearest object that matters;
`margin(p)` the least (distance - clearance to keep): < 0 is forbidden.
"""
'''

_NUMPY = """

def _distance(zone, p):
    if "segment" in zone:
        a, b = np.array(zone["segment"])
        return np.linalg.norm(_offset(a, b, p), axis=-1) - zone["thickness"]
    a, b = np.array(zone["rim"])
    gap = np.linalg.norm(_offset(a, b, p[..., None, :]), axis=-1).min(axis=-1)
    inside = np.any([_inside(np.array(corners), p) for corners in zone["polygons"]], axis=0)
    return np.where(inside, -gap, gap)


def _offset(a, b, p):
    along = b - a
    length2 = (along**2).sum(axis=-1)
    t = np.clip(((p - a) * along).sum(axis=-1) / np.where(length2 > 0, length2, 1), 0, 1)
    return p - (a + t[..., None] * along)


def _inside(a, p):
    b = np.roll(a, -1, axis=0)
    along = b - a
    straddles = (a[:, 1] > p[..., None, 1]) != (b[:, 1] > p[..., None, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (p[..., None, 1] - a[:, 1]) * (along[:, 0] / along[:, 1])
    return (straddles & (p[..., None, 0] < x)).sum(axis=-1) % 2 == 1


def clearance(p):
    p = np.asarray(p, dtype=float)
    return np.min([np.full(p.shape[:-1], np.inf)] + [_distance(z, p) for z in ZONES], axis=0)


def margin(p):
    p = np.asarray(p, dtype=float)
    gaps = [_distance(z, p) - z["radius"] for z in ZONES]
    return np.min([np.full(p.shape[:-1], np.inf)] + gaps, axis=0)


def cost(p):
    p = np.asarray(p, dtype=float)
    depths = [np.maximum(0, z["reach"] - _distance(z, p)) for z in ZONES]
    return 1 + WEIGHT * np.sum([np.zeros(p.shape[:-1])] + depths, axis=0)


def path_cost(points, spacing=STEP):
    points = np.asarray(points, dtype=float)
    total = 0.0
    for a, b in zip(points[:-1], points[1:]):
        length = float(np.hypot(*(b - a)))
        n = max(2, int(np.ceil(length / spacing)) + 1)
        price = cost(a + np.linspace(0, 1, n)[:, None] * (b - a))
        total += length * float((price[1:] + price[:-1]).mean() / 2)
    return total
"""

_OMPL = '''

def space_information():
    """OMPL's plane with the rule as validity; motions are checked at every STEP."""
    from ompl import base as ob

    space = ob.RealVectorStateSpace(2)
    bounds = ob.RealVectorBounds(2)
    for axis in (0, 1):
        bounds.setLow(axis, BOUNDS[axis])
        bounds.setHigh(axis, BOUNDS[axis + 2])
    space.setBounds(bounds)
    info = ob.SpaceInformation(space)

    class Outside(ob.StateValidityChecker):
        def isValid(self, state):
            return bool(margin([state[0], state[1]]) >= 0)

    class Clear(ob.MotionValidator):
        def checkMotion(self, first, last, *rest):
            a, b = np.array([[first[0], first[1]], [last[0], last[1]]])
            n = max(2, int(np.ceil(np.hypot(*(b - a)) / STEP)) + 1)
            return bool((margin(a + np.linspace(0, 1, n)[:, None] * (b - a)) >= 0).all())

    checkers = Outside(info), Clear(info)
    _KEPT.extend(checkers)
    info.setStateValidityChecker(checkers[0])
    info.setMotionValidator(checkers[1])
    info.setup()
    return info


def objective(info):
    """OMPL's OptimizationObjective: the integral of `cost` along a valid motion."""
    from ompl import base as ob

    # Where the price rises only in what is forbidden, a valid motion costs its length.
    plain = all(z["reach"] <= z["radius"] for z in ZONES)

    class Integral(ob.OptimizationObjective):
        def stateCost(self, state):
            return ob.Cost(float(cost([state[0], state[1]])))

        def motionCost(self, first, last):
            if plain:
                return ob.Cost(float(np.hypot(first[0] - last[0], first[1] - last[1])))
            ends = [[first[0], first[1]], [last[0], last[1]]]
            return ob.Cost(path_cost(ends, 4 * STEP))

        def motionCostHeuristic(self, first, last):
            return ob.Cost(float(np.hypot(first[0] - last[0], first[1] - last[1])))

    made = Integral(info)
    _KEPT.append(made)
    return made


_KEPT = []  # OMPL holds no reference of its own to what Python hands it
'''
