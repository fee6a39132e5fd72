"""What the name of a column says: quantity, axis, group and unit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

Quantity = Literal[
    "position", "orientation", "time", "index", "tilt", "speed", "gripper", "other"
]  # fmt: skip

LENGTHS = {
    "px": "px", "pixel": "px", "pixels": "px",
    "m": "m", "metre": "m", "meter": "m", "metres": "m", "meters": "m",
    "cm": "cm", "centimetre": "cm", "centimeter": "cm", "centimetres": "cm", "centimeters": "cm",
    "mm": "mm", "millimetre": "mm", "millimeter": "mm", "millimetres": "mm", "millimeters": "mm",
}  # fmt: skip
"""Words for the units of length that are read."""

_OTHER_LENGTHS = frozenset([
    "in", "inch", "inches", "ft", "foot", "feet", "yd", "mi", "km", "um", "µm", "μm", "nm",
    "micrometre", "micrometer", "micrometres", "micrometers", "micron", "microns",
])  # fmt: skip

TIMES = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "ms": "ms", "msec": "ms", "millis": "ms", "millisecond": "ms", "milliseconds": "ms",
    "us": "us", "µs": "us", "μs": "us", "usec": "us", "micros": "us", "microsecond": "us",
    "microseconds": "us",
    "ns": "ns", "nsec": "ns", "nsecs": "ns", "nanosec": "ns", "nanos": "ns", "nanosecond": "ns",
    "nanoseconds": "ns",
}  # fmt: skip
"""Words for the units of time that are read."""

_SUFFIXES = ("px", "m", "cm", "mm", "in", "inch", "ft", "um", "km")
"""Units of length that may end a name: ``x_mm``."""

_ANGLES = {"deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "rad": "rad",
           "radian": "rad", "radians": "rad"}  # fmt: skip

_ORIENTATION = frozenset(["orientation", "orient", "quaternion", "quat", "q", "rotation", "rot"])
_FUSED = {
    **{f"{p}{a}": a for a in "xyz" for p in ("t", "p", "pos", "position")},
    **{f"{a}{p}": a for a in "xyz" for p in ("pos", "position")},
}
_NOT_OF_THE_PATH = frozenset([
    # velocity, acceleration, force
    "v", "vel", "velocity", "velocities", "speed", "twist", "linear", "angular", "dot", "rate",
    "d", "delta", "diff", "derivative", "vx", "vy", "vz", "dx", "dy", "dz", "a", "acc", "accel",
    "acceleration", "jerk", "f", "force", "torque", "wrench", "effort", "tau", "moment", "current",
    # direction
    "euler", "rpy", "roll", "pitch", "yaw", "angle", "angles", "theta", "heading", "gyro", "omega",
    "rotvec", "normal", "mag", "magnetometer", "gravity", "joint", "joints",
    # doubt
    "cov", "covariance", "std", "sigma", "err", "error", "var", "variance", "likelihood",
    "confidence", "conf", "prob", "probability", "score", "bias",
    # count
    "index", "idx", "id", "row", "step", "seq", "count",
    # of something else, or only wished for
    "cmd", "command", "commanded", "desired", "des", "target", "goal", "ref", "reference",
    "setpoint", "action", "object", "obj", "obstacle", "start", "init", "offset", "origin", "size",
    "width", "scale", "relative", "rel",
])  # fmt: skip
_INDEX = frozenset(["index", "idx", "frame", "row", "step", "seq", "unnamed", "nr", "no", "n"])
_TIME = frozenset(["t", "time", "timestamp", "timestamps", "stamp"])
_BESIDE_TIME = _TIME | frozenset(TIMES) | frozenset([
    "header", "field", "msg", "elapsed", "clock", "unix", "epoch", "ros", "sim", "wall", "since",
    "capture", "recorded", "record", "receive", "received", "abs", "absolute", "frame", "0",
])  # fmt: skip
_GRIPPER = ("", "position", "pos", "width", "opening", "aperture", "value", "state")
_OF_THE_TOOL = frozenset(["tool", "tcp", "ee", "eef", "robot", "end", "effector"])


@dataclass(frozen=True)
class ColumnName:
    """A column's name, taken apart.

    Args:
        written: As it came.
        quantity: What it holds.
        axis: ``x``, ``y``, ``z`` or ``w`` of a position or an orientation.
        group: The words that are left without axis and unit: columns of one group belong
            together (``left_x`` and ``left_y``).
        unit: The unit that the name states (``x_mm``, ``x (mm)``, ``x/mm``), or None.
        rank: Of several columns of one quantity the one of the lowest rank is meant.
    """

    written: str
    quantity: Quantity
    axis: str | None = None
    group: tuple[str, ...] = ()
    unit: str | None = None
    rank: int = 0


@lru_cache(maxsize=100_000)
def column_name(written: str, stated: str | None = None) -> ColumnName:
    """What a column's name says.

    Args:
        written: The name.
        stated: Its unit where the format states it beside the name.
    """
    base, text = _without_unit(written)
    words = tuple(_words(base))
    unit = _unit(text) if stated is None else _unit(stated)
    if not words:
        return ColumnName(written, "index" if not base.strip() else "other", unit=unit)
    if words == ("qx",) or words == ("qy",) or words == ("qz",) or words == ("qw",):
        return ColumnName(written, "orientation", words[0][1], (), unit)
    for find in (_time, _orientation, _position, _measure):
        found = find(written, words, unit)
        if found is not None:
            return found
    if set(words) <= _INDEX | {"0", "number", "id"} and set(words) & _INDEX:
        return ColumnName(written, "index", unit=unit)
    return ColumnName(written, "other", group=words, unit=unit)


def _without_unit(written: str) -> tuple[str, str | None]:
    """``x (mm)`` → ``x``, ``mm``; also ``x [mm]`` and ``x/mm``."""
    match = re.fullmatch(r"(.*?)\s*[(\[]([^()\[\]]*)[)\]]\s*", written)
    if match and match[1].strip():
        return match[1], match[2].strip() or None
    match = re.fullmatch(r"(.+)/\s*([^/]+?)\s*", written)
    if match and match[2].lower() in {*LENGTHS, *TIMES, *_ANGLES, *_OTHER_LENGTHS}:
        return match[1], match[2]
    return written, None


def _words(name: str) -> list[str]:
    """Lower-case words: split at signs and at changes of case (``posX`` → pos, x)."""
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[^\W\d_A-Z]+|\d+", name)
    return [p.lower() for p in parts]


def _unit(text: str | None) -> str | None:
    if text is None or not text.strip():
        return None
    word = text.strip().lower()
    return LENGTHS.get(word) or TIMES.get(word) or _ANGLES.get(word) or word


def is_length(unit: str | None) -> bool:
    """Whether a unit is one of length (or none is stated)."""
    return unit is None or unit in LENGTHS or unit in _OTHER_LENGTHS


def is_unit(text: str) -> bool:
    """Whether a cell of a second header line holds a unit, perhaps in brackets."""
    word = text.strip().strip("()[]").strip().lower()
    known = {*LENGTHS, *TIMES, *_ANGLES, *_OTHER_LENGTHS, "m/s", "mm/s", "cm/s", "px/s", "m/s²",
             "m/s^2", "rad/s", "deg/s", "n", "nm", "quat", "quaternion"}  # fmt: skip
    return word in known


def _time(written: str, words: tuple[str, ...], unit: str | None) -> ColumnName | None:
    named = set(words) & _TIME
    if not named or not set(words) <= _BESIDE_TIME:
        return None
    suffix = TIMES.get(words[-1]) if len(words) > 1 and words[-1] not in _TIME else None
    if unit is not None and unit not in TIMES.values():
        return ColumnName(written, "time", group=words, unit=unit)
    # The plain names first, then the longer ones; `t` before `time` before `stamp`.
    rank = 10 * len(words) + min(
        i for i, w in enumerate(("t", "time", "timestamp", "timestamps", "stamp")) if w in named
    )
    return ColumnName(written, "time", group=words, unit=unit or suffix, rank=rank)


def _axis(words: tuple[str, ...], axes: str) -> tuple[str, tuple[str, ...]] | None:
    """The axis that the words name once, and the other words."""
    found = [(i, w) for i, w in enumerate(words) if w in axes or (w in _FUSED and axes != "xyzw")]
    if len(found) != 1:
        return None
    i, word = found[0]
    return _FUSED.get(word, word), words[:i] + words[i + 1 :]


def _orientation(written: str, words: tuple[str, ...], unit: str | None) -> ColumnName | None:
    if not set(words) & _ORIENTATION:
        return None
    found = _axis(words, "xyzw")
    if found is None or set(found[1]) & (_NOT_OF_THE_PATH - _ORIENTATION) or unit in _ANGLES:
        return ColumnName(written, "other", group=words, unit=unit)
    return ColumnName(written, "orientation", found[0], found[1], unit)


def _position(written: str, words: tuple[str, ...], unit: str | None) -> ColumnName | None:
    if len(words) > 1 and words[-1] in _SUFFIXES and unit is None:
        inner = _axis(words[:-1], "xyz")
        if inner is not None:
            words, unit = words[:-1], words[-1]
    found = _axis(words, "xyz")
    if found is None:
        return None
    axis, group = found
    if set(group) & _NOT_OF_THE_PATH or not is_length(unit):
        return ColumnName(written, "other", group=words, unit=unit)
    return ColumnName(written, "position", axis, group, unit)


def _measure(written: str, words: tuple[str, ...], unit: str | None) -> ColumnName | None:
    """Tilt, speed and gripper."""
    if words[0] == "tilt" and (words[1:] == () or (unit is None and words[1] in _ANGLES)):
        unit = unit or (_ANGLES[words[1]] if len(words) > 1 else None)
        return ColumnName(written, "tilt", unit=unit)
    bare = tuple(w for w in words if w not in _OF_THE_TOOL)
    if bare and bare[0] == "speed":
        inner = "/".join(bare[1:])
        if not inner or inner in ("px/s", "m/s", "cm/s", "mm/s"):
            return ColumnName(written, "speed", unit=unit or inner or None, rank=len(words))
    if bare[:1] == ("gripper",) and len(bare) <= 2:
        rest = bare[1] if len(bare) == 2 else ""
        if rest in _GRIPPER:
            return ColumnName(written, "gripper", unit=unit, rank=_GRIPPER.index(rest))
    return None


def may_be_path(name: str) -> bool:
    """Whether an array of that name may hold the path: not where it is a velocity, a doubt, …"""
    words = set(_words(_without_unit(name)[0]))
    return not words & (_NOT_OF_THE_PATH | _ORIENTATION | _TIME)
