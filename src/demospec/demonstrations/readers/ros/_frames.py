"""Transforms between frames: chains composed at the time of each sample."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.demonstrations.readers.ros._messages import POSE, field_of, points_of, stamp_of
from demospec.errors import InputError
from demospec.frames import FloatArray

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

_MAX_CHAINS = 1000


@dataclass
class _Link:
    """How one frame lies in another, as recorded.

    Args:
        stamps: Seconds of each sample's own stamp (of recording where it has none).
        logged: Seconds of recording.
        poses: x, y, z, qx, qy, qz, qw of the child in the parent.
        still: Published once for all.
    """

    parent: str
    child: str
    still: bool
    stamps: list[float] = field(default_factory=list)
    logged: list[float] = field(default_factory=list)
    poses: list[FloatArray] = field(default_factory=list)

    @property
    def name(self) -> str:
        return f"{self.parent}>{self.child}"

    @property
    def moves(self) -> bool:
        return not self.still and len(set(self.stamps)) > 1

    def sorted(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Stamps (n,), increasing, each once (the newest counts); recorded (n,); poses (n, 7)."""
        t = np.array(self.stamps)
        order = np.lexsort((np.arange(len(t)), t))
        last = np.append(np.diff(t[order]) > 0, True)
        order = order[last]
        return t[order], np.array(self.logged)[order], np.array(self.poses)[order]


@dataclass(frozen=True)
class FramePath:
    """One frame as it moves in another.

    Args:
        chain: The frames from the reference to the moving one.
        logged, stamps: Seconds of recording, and of the samples' own stamps, (n,).
        poses: x, y, z, qx, qy, qz, qw, (n, 7).
        left_out: Samples at times for which a transform of the chain is not known.
    """

    chain: tuple[str, ...]
    logged: FloatArray
    stamps: FloatArray
    poses: FloatArray
    left_out: int


class FrameTree:
    """Every transform of a bag.

    A frame that is published under several parents has no place of its own: then the choice must
    say PARENT>CHILD.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self.links: dict[tuple[str, str], _Link] = {}

    def add(self, message: Any, kind: str, seconds: float, *, still: bool) -> None:
        """Takes the transforms of a TFMessage, or of a Foxglove FrameTransform(s)."""
        several = field_of(message, "transforms")
        for transform in [message] if several is None else several:
            parent, child = _names(transform)
            if not parent or not child or parent == child:
                raise InputError("two frames", f"{parent!r} and {child!r}", file=self.file,
                                 row=kind, field="child_frame_id")  # fmt: skip
            columns, pose = points_of(transform, kind, self.file)
            if columns != POSE or abs(float(np.linalg.norm(pose[0, 3:])) - 1) > 0.01:
                found = pose[0, 3:].tolist() if columns == POSE else "no rotation"
                raise InputError("a rotation (a unit quaternion)", found, file=self.file,
                                 row=f"{parent}>{child}", field="rotation")  # fmt: skip
            link = self.links.setdefault((parent, child), _Link(parent, child, still))
            link.still = link.still and still
            stamp = stamp_of(transform)
            link.stamps.append(seconds if stamp is None else stamp)
            link.logged.append(seconds)
            link.poses.append(pose[0])

    @property
    def choices(self) -> str:
        """The moving transforms, for a message."""
        moving = [link.name for link in self.links.values() if link.moves]
        return ", ".join(moving or [link.name for link in self.links.values()]) or "none"

    def path(self, choice: str | None) -> FramePath:
        """The path of the frame that `choice` names.

        Args:
            choice: ``PARENT>CHILD``; ``CHILD``, in the topmost frame that it hangs on; or None
                where there is only one moving transform.

        Raises:
            InputError: A frame that is not there, several ways to read the choice, or nothing
                that moves.
        """
        if choice is None:
            moving = [link for link in self.links.values() if link.moves]
            if len(moving) != 1:
                raise self._which(self.choices)
            parent, child = None, moving[0].child
        else:
            first, arrow, second = (part.strip().strip("/") for part in choice.partition(">"))
            parent, child = (first, second) if arrow else (None, first)
        known = {name for pair in self.links for name in pair}
        for name in (parent, child):
            if name is not None and name not in known:
                raise InputError(f"a frame {name}", ", ".join(sorted(known)) or "none",
                                 file=self.file, field="path")  # fmt: skip
        steps = self._up(child) if parent is None else self._between(parent, child)
        return self._composed(steps, parent, child)

    def _which(self, found: str) -> InputError:
        expected = "one transform; say which: --path TOPIC:PARENT>CHILD"
        return InputError(expected, found, file=self.file, field="path")

    def _up(self, child: str) -> list[tuple[_Link, bool]]:
        """The links from the topmost frame down to `child`."""
        steps: list[tuple[_Link, bool]] = []
        seen = {child}
        while above := self._parents(child):
            if len(above) > 1:
                raise self._which(", ".join(link.name for link in above))
            child = above[0].parent
            if child in seen:
                raise InputError("frames in a tree", f"a circle through {child}", file=self.file,
                                 field="path")  # fmt: skip
            seen.add(child)
            steps.insert(0, (above[0], False))
        if not steps:
            raise InputError("a frame that hangs on another", child, file=self.file, field="path")
        return steps

    def _parents(self, child: str) -> list[_Link]:
        return [link for link in self.links.values() if link.child == child]

    def _chains(self, child: str) -> list[list[_Link]]:
        """Every chain of links upwards from `child`, the empty one first."""
        chains: list[list[_Link]] = [[]]
        for chain in chains:
            top = chain[0].parent if chain else child
            passed = {child, *(link.parent for link in chain)}
            chains += [[p, *chain] for p in self._parents(top) if p.parent not in passed]
            if len(chains) > _MAX_CHAINS:
                raise InputError("frames in a tree", f"{len(chains)} chains of frames",
                                 file=self.file, field="path")  # fmt: skip
        return chains

    def _between(self, parent: str, child: str) -> list[tuple[_Link, bool]]:
        """The links from `parent` to `child`: down, or up to a common frame and down again."""
        direct = self.links.get((parent, child))
        if direct is not None:
            return [(direct, False)]
        downs, ups = self._chains(child), self._chains(parent)
        found: list[list[tuple[_Link, bool]]] = []
        for up in ups:
            top = up[0].parent if up else parent
            for down in downs:
                shared = bool(up) and bool(down) and up[0] is down[0]  # not the lowest common
                if (down[0].parent if down else child) == top and not shared:
                    back = [(link, True) for link in reversed(up)]
                    found.append(back + [(link, False) for link in down])
        if len(found) > 1:
            ways = [">".join(_frames(steps, parent)) for steps in found]
            raise self._which(", ".join(ways[:4]))
        if not found or not found[0]:
            raise InputError(f"transforms from {parent} to {child}", self.choices,
                             file=self.file, field="path")  # fmt: skip
        return found[0]

    def _composed(
        self, steps: list[tuple[_Link, bool]], parent: str | None, child: str
    ) -> FramePath:
        from scipy.spatial.transform import Rotation

        chain = _frames(steps, parent or steps[0][0].parent)
        moving = [link for link, _ in steps if link.moves]
        if not moving:
            raise InputError("a transform that moves", ">".join(chain), file=self.file,
                             field="path")  # fmt: skip
        base = max(moving, key=lambda link: len(link.stamps))
        t, logged, _ = base.sorted()
        known = np.ones(len(t), dtype=bool)
        for link in moving:
            stamps = link.sorted()[0]
            known &= (t >= stamps[0]) & (t <= stamps[-1])
        if not known.any():
            raise InputError("transforms at a common time", ">".join(chain), file=self.file,
                             field="path")  # fmt: skip
        at = t[known]
        place = np.zeros((len(at), 3))
        turn = Rotation.identity(len(at))
        for link, back in steps:
            there, turned = _at(link, at)
            if back:
                turned = turned.inv()
                there = -turned.apply(there)
            place = place + turn.apply(there)
            turn = turn * turned
        quaternion = turn.as_quat()
        flips = np.cumprod(np.where((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0, -1.0, 1.0))
        quaternion[1:] *= flips[:, None]
        poses = np.concatenate([place, quaternion], axis=1)
        return FramePath(chain, logged[known], at, poses, int((~known).sum()))


def _names(transform: Any) -> tuple[str, str]:
    header = field_of(transform, "header")
    parent = getattr(header, "frame_id", None) or getattr(transform, "parent_frame_id", None)
    child = getattr(transform, "child_frame_id", None)
    return str(parent or "").strip("/"), str(child or "").strip("/")


def _frames(steps: list[tuple[_Link, bool]], first: str) -> tuple[str, ...]:
    return (first, *(link.parent if back else link.child for link, back in steps))


def _at(link: _Link, t: FloatArray) -> tuple[FloatArray, Rotation]:
    """Positions (n, 3) and rotations of a link at times inside its own: interpolated."""
    from scipy.spatial.transform import Rotation, Slerp

    stamps, _, poses = link.sorted()
    if not link.moves or len(stamps) == 1:
        # What is published once holds at all times; where it was published again, from then on.
        row = np.clip(np.searchsorted(stamps, t, side="right") - 1, 0, None)
        return poses[row, :3], Rotation.from_quat(poses[row, 3:])
    place = np.stack([np.interp(t, stamps, poses[:, k]) for k in range(3)], axis=1)
    return place, Slerp(stamps, Rotation.from_quat(poses[:, 3:]))(t)
