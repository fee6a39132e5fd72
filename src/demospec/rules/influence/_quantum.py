"""Quantum of an influence rule: the length that its whole numbers count.

The engines count in whole numbers. In pixels these are pixels. In any other unit they are
thousandths, or so, of the size of the scenes, and answers are written in the unit of the set:
T_min 0.12 with quantum 0.001 is 120 in the engine.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.errors import InputError
from demospec.frames import FloatArray

_DECIMALS = 6
"""Decimals of a quantum that coordinates keep: a quotient that stands for 123.4 is 123.4."""

_CLOSE = 1e-6
"""How far, in quanta, a number of an answer may lie from a whole one."""


@dataclass(frozen=True)
class Quantum:
    """The unit of whole numbers.

    Args:
        length: Set units, > 0; 1 for pixels.
    """

    length: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.length) and self.length > 0):
            raise InputError("a length > 0", self.length, field="quantum")

    @classmethod
    def of(cls, units: str, size: float) -> Quantum:
        """The quantum of a set: a pixel, or about a thousandth of the size of its scenes.

        The thousandth is rounded up to 1, 2 or 5 times a power of ten: 1 mm for a table of a
        metre.

        Args:
            size: Set units, > 0.
        """
        if units == "px":
            return cls()
        least = size / 1000
        power = 10.0 ** math.floor(math.log10(least) + 1e-9)
        step = next(s for s in (1, 2, 5, 10) if s * power >= least * (1 - 1e-9))
        return cls(_tidy(step * power))

    def units(self, whole: float, power: int = 1) -> float:
        """A number of quanta in set units (to a power)."""
        return whole if self.length == 1 else _tidy(whole * self.length**power)

    def whole(self, number: Any, at: str, power: int = 1) -> int:
        """The whole number of quanta that a number in set units is.

        Raises:
            InputError: It is none, or below 0.
        """
        wrong = isinstance(number, bool) or not isinstance(number, int | float)
        if not wrong and math.isfinite(number) and number >= 0:
            count = number / self.length**power
            if abs(count - round(count)) <= _CLOSE * max(1.0, count * 1e-6):
                return int(np.rint(count))
        each = "" if self.length == 1 else f" of quanta ({self.length:g} units)"
        raise InputError(f"a whole number{each} of at least 0", number, field=at)

    def coordinates(self, values: ArrayLike) -> FloatArray:
        """Coordinates in set units as numbers of quanta."""
        numbers = np.asarray(values, dtype=np.float64)
        return numbers if self.length == 1 else np.round(numbers / self.length, _DECIMALS)

    def document(self, answer: Mapping[str, Any], power: int) -> dict[str, Any]:
        """The JSON of an answer in set units; ``settings.quantum`` says what was counted.

        Args:
            power: Of length in F_max: see `power_of`.
        """
        if self.length == 1:
            return dict(answer)
        return scaled_document(answer, self.length, power, self)


def scaled_document(
    answer: Mapping[str, Any], factor: float, power: int, quantum: Quantum
) -> dict[str, Any]:
    """The JSON of an answer with every length times `factor`, and the quantum named."""

    def scaled(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: scaled(part) for name, part in value.items()}
        if isinstance(value, list | tuple):
            return [scaled(part) for part in value]
        return value if value is None else _tidy(value * factor)

    out = dict(answer)
    for name in ("min", "max", "hull", "optima_min", "optima_max"):
        if name in out:
            out[name] = scaled(out[name])
    if "bound" in out:
        out["bound"] = {**out["bound"], "L": scaled(out["bound"]["L"])}
    if "fewest" in out:
        out["fewest"] = scaled_document(out["fewest"], factor, power, quantum)
    if isinstance(out.get("settings"), Mapping):
        settings = dict(out["settings"])
        if settings.get("F_max") is not None:
            settings["F_max"] = _tidy(settings["F_max"] * factor**power)
        if "bounds" in settings:
            settings["bounds"] = scaled(settings["bounds"])
        out["settings"] = {**settings, "quantum": quantum.length}
    return out


def positive(value: Any, at: str) -> float:
    """A finite number > 0; InputError names the field."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not (math.isfinite(value) and value > 0):
        raise InputError("a number > 0", value, field=at)
    return float(value)


def power_of(penalty: str, weights: str) -> int:
    """The power of length in a summed penalty: count 0, distance 1; one more by arc length."""
    return (0 if penalty == "count" else 1) + (1 if weights == "arc" else 0)


def _tidy(value: float) -> float:
    """Without the last digits of binary fractions: 0.123, not 0.12300000000000001."""
    return float(f"{value:.12g}")
