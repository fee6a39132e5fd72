"""A robot's description (URDF) and the place of its links at given joint values, by MuJoCo.

Only the kinematics are used: shapes, masses and controllers of the description are left out, so
that meshes need not be there.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.files import read_bytes
from demospec.frames import FloatArray

_DATA = "example-robot-data"
_MOVING = ("revolute", "continuous", "prismatic")
_KEPT = ("parent", "child", "origin", "axis")
_MASS = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


@dataclass(frozen=True)
class Joint:
    """A joint that moves.

    Args:
        name: As in the description.
        turns: Revolute or continuous (radians), else prismatic (metres).
        low, high: Limits; −inf, inf where there are none.
        follows: Name of the joint that it mimics, with factor and offset; or None.
    """

    name: str
    turns: bool
    low: float
    high: float
    follows: tuple[str, float, float] | None = None


class Robot:
    """A robot's kinematics.

    Raises:
        InputError: No URDF, or one whose links are no tree.
        MissingExtraError: MuJoCo is not installed.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        root = _parsed(file)
        self.links = tuple(str(link.get("name")) for link in root.findall("link"))
        self._above: dict[str, tuple[str, Joint | None]] = {}
        for element in root.findall("joint"):
            parent, child, joint = _joint(element, file)
            if child in self._above:
                raise InputError("one joint above each link", f"two above {child}", file=file)
            self._above[child] = (parent, joint)
        bases = [link for link in self.links if link not in self._above]
        if len(bases) != 1:
            raise InputError("one link at the root", ", ".join(bases) or "none", file=file)
        self.base = bases[0]
        self._model = _model(root, file)

    def chain(self, link: str) -> tuple[Joint, ...]:
        """The moving joints from the base to a link, in this order.

        Raises:
            InputError: No such link, or one that no joint moves.
        """
        if link not in self.links:
            raise InputError(f"a link {link}", ", ".join(self.links), file=self.file, field="link")
        joints: list[Joint] = []
        at = link
        while at in self._above:
            at, joint = self._above[at]
            if joint is not None:
                joints.insert(0, joint)
        if not joints:
            raise InputError("a link that a joint moves", link, file=self.file, field="link")
        return tuple(joints)

    def needed(self, link: str) -> tuple[Joint, ...]:
        """The joints whose values decide where a link is: those of its chain, and those that they
        mimic in their place."""
        known = {joint.name: joint for _, joint in self._above.values() if joint is not None}
        out: dict[str, Joint] = {}
        for joint in self.chain(link):
            passed = {joint.name}
            while joint.follows is not None:
                name = joint.follows[0]
                if name not in known or name in passed:
                    raise InputError("a joint to mimic", name, file=self.file,
                                     row=f"joint {joint.name}")  # fmt: skip
                passed.add(name)
                joint = known[name]
            out[joint.name] = joint
        return tuple(out.values())

    def poses(self, link: str, values: dict[str, FloatArray]) -> FloatArray:
        """x, y, z, qx, qy, qz, qw of a link in the base, (n, 7), metres.

        Args:
            link: Below at least one moving joint.
            values: Joint → (n,) radians or metres, for every joint of `needed`.
        """
        import mujoco

        model, data = self._model, mujoco.MjData(self._model)
        joints = {joint.name: joint for _, joint in self._above.values() if joint is not None}

        def value(name: str) -> FloatArray:
            follows = joints[name].follows
            if follows is None:
                return values[name]
            return np.asarray(follows[1] * value(follows[0]) + follows[2])

        whole = {joint.name: value(joint.name) for joint in self.chain(link)}
        places = [int(model.joint(name).qposadr[0]) for name in whole]
        table = np.stack(list(whole.values()), axis=1)
        body = int(model.body(link).id)
        out = np.empty((len(table), 7))
        for i, row in enumerate(table):
            data.qpos[places] = row
            mujoco.mj_kinematics(model, data)
            out[i, :3] = data.xpos[body]
            out[i, 3:6], out[i, 6] = data.xquat[body][1:], data.xquat[body][0]
        flips = np.where((out[1:, 3:] * out[:-1, 3:]).sum(axis=1) < 0, -1.0, 1.0)
        out[1:, 3:] *= np.cumprod(flips)[:, None]  # of q and −q the one near the last
        return out


def robot_file(named: str, root: Path) -> Path:
    """The URDF that a path names (from `root`), or a robot of example-robot-data by its name.

    Raises:
        InputError: Neither, or several robots of that name.
        MissingExtraError: A name, and example-robot-data is not installed.
    """
    for place in (root / named, Path(named)):
        if place.is_file():
            return place
    if named.lower().endswith(".urdf") and "_description/" not in named:
        raise InputError("a URDF file", "no such file", file=root / named, field="urdf")
    try:
        files = [f for f in metadata.files(_DATA) or [] if f.name.endswith(".urdf")]
    except metadata.PackageNotFoundError as error:
        raise MissingExtraError(_DATA, "robot", f"the robot {named}") from error
    known = {str(f).partition("/robots/")[2]: Path(str(f.locate())) for f in files}
    for found in (
        [k for k in known if k == named],
        [k for k in known if Path(k).stem == named],
        [k for k in known if Path(k).stem == f"{named}_robot"],
    ):
        if len(found) > 1:
            raise InputError("one robot; say its file", ", ".join(found), field="urdf")
        if found:
            return known[found[0]]
    from difflib import get_close_matches

    near = get_close_matches(named, [Path(k).stem for k in known], 3, 0.5)
    expected = "a URDF file, or a robot of example-robot-data"
    if near:
        expected += f" (such as {', '.join(near)})"
    raise InputError(expected, named, field="urdf")


def _parsed(file: Path) -> Any:
    data = read_bytes(file, limit_bytes=1 << 26)
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data or b"\x00" in data:
        raise InputError("XML without a document type", "one with it", file=file)
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError("a URDF file", str(error), file=file) from error
    if root.tag != "robot" or root.find("link") is None:
        found = root.tag if root.tag != "robot" else "no link (a xacro file is to be expanded)"
        raise InputError("a URDF file (an element robot with links)", found[:60], file=file)
    return root


def _joint(element: Any, file: Path) -> tuple[str, str, Joint | None]:
    """Parent, child, and the joint where it moves."""
    name, kind = str(element.get("name")), element.get("type")
    ends = [element.find(n) for n in ("parent", "child")]
    if any(end is None or not end.get("link") for end in ends):
        raise InputError("a parent and a child", "none", file=file, row=f"joint {name}")
    parent, child = (str(end.get("link")) for end in ends)
    if kind == "fixed":
        return parent, child, None
    if kind not in _MOVING:
        expected = f"one of fixed, {', '.join(_MOVING)}"
        raise InputError(expected, kind, file=file, row=f"joint {name}", field="type")
    limit, mimic = element.find("limit"), element.find("mimic")
    low, high = -np.inf, np.inf
    try:
        if kind != "continuous" and limit is not None:
            low, high = (float(limit.get(n, "nan")) for n in ("lower", "upper"))
        if np.isnan(low) or np.isnan(high) or low >= high:
            low, high = -np.inf, np.inf  # none, or the placeholder 0, 0
        follows = None
        if mimic is not None:
            follows = (
                str(mimic.get("joint")),
                float(mimic.get("multiplier", "1")),
                float(mimic.get("offset", "0")),
            )
    except ValueError as error:
        raise InputError("numbers", str(error), file=file, row=f"joint {name}") from error
    return parent, child, Joint(name, kind != "prismatic", low, high, follows)


def _model(root: Any, file: Path) -> Any:
    """The tree of links and joints alone as a MuJoCo model."""
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError("mujoco", "robot", "forward kinematics") from error
    bare = ElementTree.Element("robot", name="robot")
    compiler = ElementTree.SubElement(ElementTree.SubElement(bare, "mujoco"), "compiler")
    compiler.set("fusestatic", "false")
    for element in root:
        if element.tag == "link":
            link = ElementTree.SubElement(bare, "link", name=str(element.get("name")))
            link.append(ElementTree.fromstring(_MASS))
        elif element.tag == "joint":
            joint = ElementTree.SubElement(
                bare, "joint", name=str(element.get("name")), type=str(element.get("type"))
            )
            joint.extend(part for part in element if part.tag in _KEPT)
    text = ElementTree.tostring(bare, encoding="unicode")
    try:
        return mujoco.MjSpec.from_string(text).compile()
    except ValueError as error:
        raise InputError("a URDF file", str(error).splitlines()[0], file=file) from error
