"""Damage that keeps a file readable: columns renamed, reordered, retyped, doubled, re-united."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator

import numpy as np
from story import PIXELS, Column, Table

Change = Callable[[list[Table]], list[Table]]

WRONG_NAMES = ("foo", "value", "vx", "speed_x", "x_std", "index", "left_x", "target_y", "x_dot",
               "data 1", "qx", "x error", "joint_1", "frame_id", "")  # fmt: skip
"""None of these says that a column is a position, a time or a label of the demonstration."""
SAME_NAMES = {"x": ("X", "pos_x", "x [m]", "x_m", "tx"), "y": ("Y", "posY", "y (m)"),
              "z": ("Z", "z/m"), "t": ("time", "t_s", "timestamp", "Time (Seconds)"),
              "success": ("Success", "valid"), "user_type": ("type",),
              "demo_id": ("episode", "traj_id")}  # fmt: skip
JUNK = {
    "velocity": ("vx", lambda n: np.linspace(3, 5, n)), "count": ("index", np.arange),
    "frames": ("frame", lambda n: np.arange(n) + 100), "force": ("force_x", np.ones),
    "other arm": ("left_x", lambda n: np.linspace(5, 3, n)), "doubt": ("x_std", np.ones),
    "goal": ("goal_y", np.ones), "joint": ("joint_2", lambda n: np.linspace(2, 1, n)),
    "half a quaternion": ("qx", np.zeros), "temperature": ("temp", lambda n: np.full(n, 21.5)),
}  # fmt: skip


def _each(tables: list[Table], change: Callable[[Table], Table]) -> list[Table]:
    return [change(copy.deepcopy(t)) for t in tables]


def _renamed(old: str, new: str) -> Change:
    def change(table: Table) -> Table:
        for column in table:
            if column.name == old:
                column.name = new
        return table

    return lambda tables: _each(tables, change)


def _ordered(order: list[int]) -> Change:
    return lambda tables: _each(tables, lambda t: [t[j] for j in order])


def _with(name: str, make: Callable[[int], np.ndarray], place: int) -> Change:
    def change(table: Table) -> Table:
        values = [float(v) for v in make(len(table[0].values))]
        table.insert(min(place, len(table)), Column(name, values))
        return table

    return lambda tables: _each(tables, change)


def _doubled(name: str, new: str, shift: float) -> Change:
    """A column again under another name, with other numbers in it."""

    def change(table: Table) -> Table:
        found = next((c for c in table if c.name == name), None)
        if found is not None:
            moved = [v + shift if isinstance(v, float) else v for v in found.values]
            table.append(Column(new, moved))
        return table

    return lambda tables: _each(tables, change)


def _retyped(name: str, how: Callable[[object], object]) -> Change:
    def change(table: Table) -> Table:
        for column in table:
            if column.name == name:
                column.values = [how(v) for v in column.values]
        return table

    return lambda tables: _each(tables, change)


def _few_digits(value: object) -> object:
    return float(f"{value:.7g}") if isinstance(value, float) else value


def _cell(name: str, row: int, value: object) -> Change:
    """One value of the second demonstration."""

    def change(tables: list[Table]) -> list[Table]:
        out = copy.deepcopy(tables)
        for column in out[1]:
            if column.name == name:
                column.values[row] = value
        return out

    return change


def _in_unit(names: tuple[str, ...], form: str, unit: str, factor: float) -> Change:
    def change(table: Table) -> Table:
        for column in table:
            if column.name in names:
                column.values = [float(f"{v * factor:.9g}") for v in column.values]
                column.name = form.format(column.name, unit)
        return table

    return lambda tables: _each(tables, change)


def changes(columns: Table, words: bool) -> Iterator[tuple[str, Change]]:
    """Every change of a story with these columns.

    Args:
        columns: Of the first demonstration.
        words: Whether the format can hold words in the place of numbers.
    """
    names = [c.name for c in columns]
    rng = np.random.default_rng(7)
    for name in names:
        for new in WRONG_NAMES:
            yield f"{name} is called {new!r}", _renamed(name, new)
        for new in SAME_NAMES.get(name, ()):
            yield f"{name} is called {new!r}, which says the same", _renamed(name, new)
    for k in range(1, len(names)):
        turned = [(j + k) % len(names) for j in range(len(names))]
        yield f"columns rotated by {k}", _ordered(turned)
    for k in range(6):
        yield f"columns in order {k}", _ordered(rng.permutation(len(names)).tolist())
    for what, (name, make) in JUNK.items():
        for place in (0, 3, 99):
            yield f"{what} at {place}", _with(name, make, place)
    for name in ("x", "y", "z", "t", "success"):
        if name not in names:
            continue
        for new in (name, f"{name}.1", f"{name} ", f"left_{name}", name.upper()):
            yield f"{name} again as {new!r}", _doubled(name, new, 0.25)
    for name in ("x", "y", "z", "t"):
        if name in names and words:
            for value in ("-", "", "n.d.", "1,234.5", "1.234,5", "nan", None):
                yield f"{name} once {value!r}", _cell(name, 3, value)
            yield f"{name} as text with commas", _retyped(name, lambda v: str(v).replace(".", ","))
        if name in names:
            yield f"{name} once NaN", _cell(name, 3, float("nan"))
            yield f"{name} in few digits", _retyped(name, _few_digits)
    for name in ("success", "user_type"):
        for how, make_value in (("float", float), ("truth", bool), ("text", str)):
            if name in names and (how == "text" or name == "success"):
                yield f"{name} as {how}", _retyped(name, make_value)  # type: ignore[arg-type]
    axes = tuple(n for n in ("x", "y", "z") if n in names)
    for unit, factor in (("mm", 1000.0), ("cm", 100.0), ("in", 39.37), ("px", PIXELS)):
        for form in ("{} ({})", "{}_{}", "{} [{}]", "{}/{}"):
            yield f"all axes as {form.format('x', unit)}", _in_unit(axes, form, unit, factor)
            yield f"x alone as {form.format('x', unit)}", _in_unit(("x",), form, unit, factor)
    for unit, factor in (("ms", 1e3), ("us", 1e6), ("ns", 1e9), ("min", 1 / 60)):
        for form in ("{} ({})", "{}_{}"):
            yield f"time as {form.format('t', unit)}", _in_unit(("t",), form, unit, factor)
        if unit != "min":  # nothing tells minutes from seconds
            yield f"time in {unit}, unsaid", _in_unit(("t",), "{}", "", factor)
