"""Tesseract: the table as URDF, and each clearance as the margin of a pair of links in SRDF.

Other than MoveIt, Tesseract knows a margin for each pair of links: outlines stay what they are,
and ``tool``, a small ball at the point that the rule speaks of, keeps its own margin from each.
``margins.yaml`` says the same margins to those who load them into a robot of their own.

Source: SRDF of `tesseract_srdf` (``collision_margins``, ``pair_margin``), URDF.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, rims
from demospec.planning._results import Zone
from demospec.planning.exports._moveit import HEIGHT_M, passed_over
from demospec.planning.exports._request import ExportRequest

PACKAGE = "demospec_table"
"""Folder of the files: URDF names its meshes by a package."""

_MANAGERS = """\
contact_manager_plugins:
  search_libraries:
    - tesseract_collision_bullet_factories
    - tesseract_collision_fcl_factories
  discrete_plugins:
    default: BulletDiscreteBVHManager
    plugins:
      BulletDiscreteBVHManager: {class: BulletDiscreteBVHManagerFactory}
      FCLDiscreteBVHManager: {class: FCLDiscreteBVHManagerFactory}
  continuous_plugins:
    default: BulletCastBVHManager
    plugins:
      BulletCastBVHManager: {class: BulletCastBVHManagerFactory}
"""

_BALL_M = 0.001
_ROUND = 48  # corners of half a circle of a capsule


def write_tesseract(request: ExportRequest, folder: Path) -> None:
    """Writes ``demospec_table/``: ``package.xml``, ``table.urdf``, ``table.srdf``,
    ``margins.yaml``, ``contact_managers.yaml`` and a mesh for each outline that is not a disc."""
    package = folder / PACKAGE
    (package / "meshes").mkdir(parents=True)
    things = [(zone, HEIGHT_M) for zone in request.cost_map.zones]
    things += [(zone, high) for zone, high, _ in passed_over(request)]
    margin = {zone.object_id: zone.radius * request.scale_m for zone, _ in things}
    kept = [m for m in margin.values() if m > 0]
    ball = min([_BALL_M, *(m / 10 for m in kept)])
    names = _names([zone.object_id for zone, _ in things])
    robot = _robot(request, ball)
    for number, (zone, high) in enumerate(things):
        _add_thing(robot, request, zone, high, names[zone.object_id], package, number)
    _write(robot, package / "table.urdf")
    pairs = {names[i]: max(0.0, m - ball) for i, m in margin.items()}
    _write(_semantics(pairs), package / "table.srdf")
    (package / "margins.yaml").write_text(_margins(pairs), encoding="utf-8")
    (package / "contact_managers.yaml").write_text(_MANAGERS, encoding="utf-8")
    about = ET.Element("package", format="3")
    for tag, text in (("name", PACKAGE), ("version", "0.0.0"), ("license", "none")):
        ET.SubElement(about, tag).text = text
    ET.SubElement(about, "description").text = f"Table of scene {request.scene.scene_id}"
    ET.SubElement(about, "maintainer", email="nobody@localhost").text = "nobody"
    _write(about, package / "package.xml")


def _names(ids: list[str]) -> dict[str, str]:
    """Names of links: the ids, unless a link of the tool is called so."""
    taken = {"world", "tool", "tool_x", "tool_y"}
    return {i: f"object_{i}" if i in taken else i for i in ids}


def _robot(request: ExportRequest, ball: float) -> ET.Element:
    """A ball that slides along x, y and z."""
    robot = ET.Element("robot", name=PACKAGE)
    ET.SubElement(robot, "link", name="world")
    x0, y0, x1, y1 = request.cost_map.bounds
    reach = 10 * max(x1 - x0, y1 - y0) * request.scale_m + float(
        np.abs(request.frame.to_metres(np.array([[x0, y0], [x1, y1]]))).max()
    )
    parent = "world"
    for axis, child, along in (
        ("x", "tool_x", "1 0 0"),
        ("y", "tool_y", "0 1 0"),
        ("z", "tool", "0 0 1"),
    ):
        link = ET.SubElement(robot, "link", name=child)
        joint = ET.SubElement(robot, "joint", name=f"tool_{axis}_joint", type="prismatic")
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=child)
        ET.SubElement(joint, "axis", xyz=along)
        ET.SubElement(
            joint, "limit", lower=f"{-reach:.9g}", upper=f"{reach:.9g}", effort="1", velocity="1"
        )
        parent = child
    shape = ET.SubElement(ET.SubElement(link, "collision"), "geometry")
    ET.SubElement(shape, "sphere", radius=f"{ball:.9g}")
    return robot


def _add_thing(
    robot: ET.Element,
    request: ExportRequest,
    zone: Zone,
    high: float,
    name: str,
    package: Path,
    number: int,
) -> None:
    link = ET.SubElement(robot, "link", name=name)
    joint = ET.SubElement(robot, "joint", name=f"{name}_joint", type="fixed")
    ET.SubElement(joint, "parent", link="world")
    ET.SubElement(joint, "child", link=name)
    if isinstance(zone.shape, Disc):
        x, y = request.frame.to_metres(zone.shape.center)
        collision = ET.SubElement(link, "collision")
        ET.SubElement(collision, "origin", xyz=f"{x:.9g} {y:.9g} {high / 2:.9g}", rpy="0 0 0")
        radius = f"{zone.shape.radius * request.scale_m:.9g}"
        geometry = ET.SubElement(collision, "geometry")
        ET.SubElement(geometry, "cylinder", radius=radius, length=f"{high:.9g}")
        return
    parts = [_around(zone.shape)] if isinstance(zone.shape, Capsule) else rims(zone.shape)
    # Tesseract takes the hull of a mesh, so each is convex.
    pieces = [piece for rim in parts for piece in _convex_pieces(request.frame.to_metres(rim))]
    for k, piece in enumerate(pieces):
        file = f"meshes/{number}_{k}.stl"
        (package / file).write_bytes(_stl(_prism(piece, high)))
        geometry = ET.SubElement(ET.SubElement(link, "collision"), "geometry")
        ET.SubElement(geometry, "mesh", filename=f"package://{PACKAGE}/{file}")


def _semantics(pairs: dict[str, float]) -> ET.Element:
    robot = ET.Element("robot", name=PACKAGE, version="1.0.0")
    ET.SubElement(ET.SubElement(robot, "group", name="tool"), "chain", base_link="world",
                  tip_link="tool")  # fmt: skip
    file = f"package://{PACKAGE}/contact_managers.yaml"
    ET.SubElement(robot, "contact_managers_plugin_config", filename=file)
    margins = ET.SubElement(robot, "collision_margins", default_margin="0")
    for name, margin in pairs.items():
        ET.SubElement(margins, "pair_margin", link1="tool", link2=name, margin=f"{margin:.9g}")
    names = list(pairs)
    for i, one in enumerate(names):
        for other in [*names[i + 1 :], "world"]:
            ET.SubElement(robot, "disable_collisions", link1=one, link2=other, reason="Adjacent")
    return robot


def _margins(pairs: dict[str, float]) -> str:
    lines = ["default: 0.0", "pairs:" if pairs else "pairs: []"]
    for name, margin in pairs.items():
        lines.append(f"  - {{link1: tool, link2: {json.dumps(name)}, margin: {margin:.9g}}}")
    return "\n".join(lines) + "\n"


def _write(root: ET.Element, file: Path) -> None:
    ET.indent(root)
    ET.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)


def _around(shape: Capsule) -> FloatArray:
    """Corners of a polygon around a capsule, from outside by less than a thousandth of it."""
    a, b = np.asarray(shape.start), np.asarray(shape.end)
    turn = np.arctan2(*(b - a)[::-1]) + np.pi / 2
    half = np.linspace(0.0, np.pi, _ROUND)
    r = shape.radius / np.cos(np.pi / (2 * (_ROUND - 1)))
    ends = [
        center + r * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        for center, angle in ((a, turn + half), (b, turn + np.pi + half))
    ]
    return np.concatenate(ends)


def _prism(rim: FloatArray, high: float) -> FloatArray:
    """(t, 3, 3) triangles of an upright prism over a convex polygon, anticlockwise."""
    low = np.column_stack([rim, np.zeros(len(rim))])
    top = np.column_stack([rim, np.full(len(rim), high)])
    low_next, top_next = np.roll(low, -1, axis=0), np.roll(top, -1, axis=0)
    walls = [np.stack([low, low_next, top], axis=1), np.stack([low_next, top_next, top], axis=1)]
    fan = np.array([[0, i, i + 1] for i in range(1, len(rim) - 1)])
    return np.concatenate([*walls, top[fan], low[fan[:, ::-1]]])


def _convex_pieces(rim: FloatArray) -> list[FloatArray]:
    """A simple polygon as convex ones, anticlockwise: its ears, joined where that stays convex.

    Source: Hertel and Mehlhorn (1983): at most four times the fewest.
    """
    off = rim - rim[0]
    after = np.roll(off, -1, axis=0)
    if float((off[:, 0] * after[:, 1] - off[:, 1] * after[:, 0]).sum()) < 0:
        rim = rim[::-1]
    pieces: list[list[int]] = []
    for ear in map(list, _ears(rim)):
        joined = True
        while joined:
            joined = False
            for k, other in enumerate(pieces):
                both = _joined(rim, ear, other)
                if both:
                    ear, joined = both, True
                    del pieces[k]
                    break
        pieces.append(ear)
    return [rim[piece] for piece in pieces]


def _joined(rim: FloatArray, one: list[int], other: list[int]) -> list[int]:
    """Two polygons across the edge that they share; empty where there is none, or not convex."""
    for k, (i, j) in enumerate(zip(one, one[1:] + one[:1], strict=True)):
        if i in other and other[other.index(i) - 1] == j:
            at = other.index(i)
            both = one[k + 1 :] + one[: k + 1] + (other[at:] + other[:at])[1:-1]
            n = len(both)
            turns = (_turn(*rim[[both[m - 2], both[m - 1], both[m]]]) for m in range(n))
            return both if all(turn >= 0 for turn in turns) else []
    return []


def _ears(rim: FloatArray) -> list[tuple[int, int, int]]:
    """A simple polygon, anticlockwise, as triangles: ears are cut off until one is left."""
    left = list(range(len(rim)))
    cut: list[tuple[int, int, int]] = []
    while len(left) > 3:
        for k in range(len(left)):
            i, j, n = left[k - 1], left[k], left[(k + 1) % len(left)]
            others = [m for m in left if m not in (i, j, n)]
            if _turn(rim[i], rim[j], rim[n]) > 0 and not _holds(rim[[i, j, n]], rim[others]):
                cut.append((i, j, n))
                del left[k]
                break
        else:  # what is left has no area but by rounding
            del left[0]
    return [*cut, (left[0], left[1], left[2])]


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _holds(corners: FloatArray, points: FloatArray) -> bool:
    """Whether a triangle, anticlockwise, holds one of the points; its corners do not count."""
    side = np.roll(corners, -1, axis=0) - corners
    off = points[:, None] - corners
    inside = (side[:, 0] * off[..., 1] - side[:, 1] * off[..., 0] >= 0).all(axis=1)
    same = (points[:, None] == corners).all(axis=2).any(axis=1)
    return bool((inside & ~same).any())


def _stl(triangles: FloatArray) -> bytes:
    """Binary STL; readers work out the normals."""
    made = np.zeros(len(triangles), dtype=[("v", "<f4", (4, 3)), ("attribute", "<u2")])
    made["v"][:, 1:] = triangles
    head = b"demospec".ljust(80, b" ")
    return head + len(triangles).to_bytes(4, "little") + made.tobytes()
