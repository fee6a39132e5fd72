"""Time stamps: which unit they are in, and whether the clock jumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.demonstrations.readers._column_names import TIMES
from demospec.errors import InputError
from demospec.frames import FloatArray

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_EPOCHS = (("s", 3e8, 3e10), ("ms", 3e11, 3e13), ("us", 3e14, 3e16), ("ns", 3e17, 3e19))
"""Where stamps of the years 1979 to 2920 lie."""
_STEPS = (2e-4, 5.0)
"""Seconds between two samples of a motion that people record: from 5 kHz to one in five seconds."""


@dataclass(frozen=True)
class ClockRead:
    """How time was read.

    Args:
        column: Where it came from.
        unit: ``s``, ``ms``, ``us`` or ``ns``.
        why: How the unit is known.
        jumps: Places where the clock runs back, stands still or leaps, in words.
    """

    column: str
    unit: str
    why: str
    jumps: tuple[str, ...] = ()


def unit_of(
    stamps: list[FloatArray], column: str, stated: str | None, asked: str | None
) -> tuple[str, str]:
    """The unit of time stamps, and how it is known.

    Args:
        stamps: Those of each recording, as they stand.
        column: Where they came from.
        stated: The unit that the source states.
        asked: The unit that the user said.

    Raises:
        InputError: The two disagree, an unknown unit is stated, or several units are plausible
            and seconds are not one of them.
    """
    if stated is not None and stated not in SECONDS:
        known = ", ".join(dict.fromkeys(TIMES.values()))
        raise InputError(
            f"a unit of time ({known}; --time-unit, --time none)", stated, field=column
        )
    if asked is not None:
        if stated is not None and stated != asked:
            expected = f"the unit that the source states ({stated})"
            raise InputError(expected, asked, field="time_unit")
        return asked, "as asked"
    if stated is not None:
        return stated, "as the source states"
    values = np.concatenate([t[np.isfinite(t)] for t in stamps]) if stamps else np.empty(0)
    if not len(values):
        return "s", "no stamps"
    for unit, low, high in _EPOCHS:
        if low <= values.min() and values.max() < high:
            return unit, "by its size: a date"
    steps = np.concatenate([_steps(t) for t in stamps])
    if not len(steps):
        return "s", "not stated"
    step = float(np.median(steps))
    plausible = [u for u, size in SECONDS.items() if _STEPS[0] <= step * size <= _STEPS[1]]
    if "s" in plausible or not plausible:
        if not plausible and step > _STEPS[1]:
            raise _unclear(column, step, list(SECONDS))
        return "s", "not stated"
    if len(plausible) > 1:
        raise _unclear(column, step, plausible)
    return plausible[0], f"by its steps of {step:g}"


def _unclear(column: str, step: float, units: list[str]) -> InputError:
    expected = f"a clear unit of time ({' or '.join(units)}; --time-unit, or --time none)"
    return InputError(expected, f"steps of {step:g}", field=column)


def _steps(t: FloatArray) -> FloatArray:
    steps = np.diff(t[np.isfinite(t)])
    return np.asarray(steps[steps > 0])


def jumps_of(names: list[str], stamps: list[FloatArray]) -> tuple[str, ...]:
    """Where the clocks of recordings (seconds) run back, stand still or leap; in words.

    A leap is a step of more than a second that is more than twenty times the median step.
    """
    back: list[str] = []
    still: list[str] = []
    leaps: list[str] = []
    for name, t in zip(names, stamps, strict=True):
        steps = np.diff(t)
        if not len(steps):
            continue
        if (steps < 0).any():
            back.append(f"{name} at point {int(np.flatnonzero(steps < 0)[0]) + 1}")
        if (steps == 0).any():
            still.append(f"{name} at point {int(np.flatnonzero(steps == 0)[0]) + 1}")
        usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
        far = steps > max(1.0, 20 * usual)
        if usual and far.any():
            at = int(np.flatnonzero(far)[0])
            leaps.append(f"{name} by {steps[at]:.4g} s at point {at + 1}")
    words = (("runs back", back), ("stands still", still), ("leaps", leaps))
    return tuple(
        f"{what} in {len(found)} recording{'s' if len(found) > 1 else ''} ({_some(found)})"
        for what, found in words
        if found
    )


def _some(words: list[str]) -> str:
    return ", ".join(words[:3]) + (", …" if len(words) > 3 else "")
