"""Which column is what: one reading, or a refusal that lists the columns."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from demospec.demonstrations.readers._column_names import ColumnName, column_name
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import Recording
from demospec.errors import InputError
from demospec.frames import FloatArray

QUATERNION = ("qx", "qy", "qz", "qw")
KEPT = (*QUATERNION, "tilt", "speed", "gripper")
"""Columns that are kept by name beside x, y and z."""

_ORIENTATION_WORDS = frozenset([
    "orientation", "orient", "quaternion", "quat", "q", "rotation", "rot", "pos", "position", "p",
    "pose", "translation", "t",
])  # fmt: skip


@dataclass(frozen=True)
class Columns:
    """What the columns of a recording are.

    Args:
        places: Our name → place of the column; x and y first, then z and those kept.
        time: Place of the time stamps among the columns, or None.
        nanoseconds: Place of the column that holds their fractions, where seconds and nanoseconds
            are two columns.
        units: Our name → unit that the source states.
        rest: Columns that are not read.
    """

    places: dict[str, int]
    time: int | None = None
    nanoseconds: int | None = None
    units: dict[str, str] = field(default_factory=dict)
    rest: tuple[str, ...] = ()


def columns_of(recordings: list[Recording], mapping: Mapping) -> list[Columns]:
    """What the columns of each recording are; the same ones in all of them.

    A recording's own names decide, so that two files may name or order them differently.

    Raises:
        InputError: Columns that could be read in several ways, or in none.
    """
    known: dict[object, Columns] = {}
    out = []
    for recording in recordings:
        key = (
            recording.columns,
            tuple(sorted(recording.units.items())),
            recording.ordered,
            recording.grouped,
        )
        if key not in known:
            known[key] = _columns(recording, mapping)
        out.append(known[key])
    _refuse_differing(recordings, out)
    _refuse_clocks(recordings, out, mapping)
    return _with_common(recordings, out, mapping)


def _columns(recording: Recording, mapping: Mapping) -> Columns:
    names = [column_name(c, recording.units.get(c)) for c in recording.columns]
    time, nanoseconds = _with_nanoseconds(_time(recording, names, mapping), names)
    if mapping.columns is not None:
        places = _asked(recording, mapping.columns, time)
    else:
        places = _positions(recording, names, mapping)
        places |= _kept(names, places)
    units = {ours: unit for ours, j in places.items() if (unit := names[j].unit) is not None}
    used = {*places.values(), time, nanoseconds}
    rest = tuple(c for j, c in enumerate(recording.columns) if j not in used)
    return Columns(places, time, nanoseconds, units, rest)


def _asked(recording: Recording, columns: dict[str, str | int], time: int | None) -> dict[str, int]:
    """The columns that the mapping names: by name, else by number."""
    for name in ("x", "y"):
        if name not in columns:
            raise InputError(f"a column for {name}", list(columns), field="columns")
    order = ["x", "y", *(["z"] if "z" in columns else [])]
    order += [name for name in columns if name not in order]
    return {ours: _place(recording, str(columns[ours]), ours, time) for ours in order}


def _place(recording: Recording, theirs: str, ours: str, time: int | None) -> int:
    if theirs in recording.columns:
        return recording.columns.index(theirs)
    if theirs.isdecimal():  # a number counts the columns of numbers, that of the time left out
        own = [j for j in range(len(recording.columns)) if j != time and not _words(recording, j)]
        if int(theirs) < len(own):
            return own[int(theirs)]
    known = ", ".join(recording.columns[:20])
    raise recording.complain(f"a column {theirs} for {ours}", known, "columns")


def _words(recording: Recording, j: int) -> bool:
    return recording.cells is not None and recording.cells.are_words(j)


def _positions(recording: Recording, names: list[ColumnName], mapping: Mapping) -> dict[str, int]:
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for j, name in enumerate(names):
        if name.quantity == "position" and name.axis is not None:
            group = groups.setdefault(name.group, {})
            if name.axis in group:
                both = f"{names[group[name.axis]].written}, {name.written}"
                raise _unclear(recording, f"one column for {name.axis}", both)
            group[name.axis] = j
    if mapping.path is not None and recording.grouped and groups:
        groups = _named_group(recording, groups, names, mapping.path)
    if not groups:
        return _nameless(recording, names)
    exact = groups.get(())
    chosen = exact if exact is not None and {"x", "y"} <= set(exact) else None
    if chosen is None and len(groups) == 1:
        chosen = next(iter(groups.values()))
    if chosen is None or not {"x", "y"} <= set(chosen):
        held = [names[j].written for g in groups.values() for j in g.values()]
        lacking = "y" if chosen is not None and "y" not in chosen else "x"
        if len(groups) > 1:
            raise _unclear(recording, f"one column for {lacking}", ", ".join(held[:8]))
        raise _none(recording)
    return {axis: chosen[axis] for axis in "xyz" if axis in chosen}


def _named_group(
    recording: Recording,
    groups: dict[tuple[str, ...], dict[str, int]],
    names: list[ColumnName],
    path: str,
) -> dict[tuple[str, ...], dict[str, int]]:
    """The group of columns whose names begin with `path`."""
    found = {
        key: group
        for key, group in groups.items()
        if all(names[j].written.startswith(path) for j in group.values())
    }
    if not found:
        known = ", ".join(n.written for n in names if n.quantity == "position")
        raise recording.complain(f"columns of a position that begin with {path}", known, "path")
    return found


def _nameless(recording: Recording, names: list[ColumnName]) -> dict[str, int]:
    """Two or three columns that are numbered, not named: x, y and z in this order."""
    own = [j for j, n in enumerate(names) if n.written.isdecimal()]
    if len(own) not in (2, 3):
        raise _none(recording)
    return dict(zip("xyz", own, strict=False))


def _unclear(recording: Recording, expected: str, found: str) -> InputError:
    axis = expected.rsplit(" ", 1)[-1]
    return recording.complain(f"{expected}; say which: --column {axis}=NAME", found, "columns")


def _none(recording: Recording) -> InputError:
    known = ", ".join(recording.columns[:20])
    expected = "columns for x and y; say which: --column x=NAME --column y=NAME"
    return recording.complain(expected, known, "columns")


def _time(recording: Recording, names: list[ColumnName], mapping: Mapping) -> int | None:
    if mapping.time is not None:
        asked = str(mapping.time)
        if asked in recording.columns:
            return recording.columns.index(asked)
        index = asked.isdecimal() and asked not in recording.fields
        return int(asked) if index and int(asked) < len(recording.columns) else None
    if recording.t is not None:
        return None
    found = [(n.rank, j) for j, n in enumerate(names) if n.quantity == "time"]
    return min(found)[1] if found else None


def _with_nanoseconds(time: int | None, names: list[ColumnName]) -> tuple[int | None, int | None]:
    """The place of the seconds and of their nanoseconds, where these are a column of their own."""
    if time is None or names[time].quantity != "time" or names[time].unit not in ("s", "ns"):
        return time, None
    for j, name in enumerate(names):
        same = name.quantity == "time" and name.group[:-1] == names[time].group[:-1]
        if j != time and same and {name.unit, names[time].unit} == {"s", "ns"}:
            return (time, j) if names[time].unit == "s" else (j, time)
    return time, None


def _kept(names: list[ColumnName], places: dict[str, int]) -> dict[str, int]:
    """Orientation, tilt, speed and gripper, where there is one reading of each."""
    out: dict[str, int] = {}
    position = names[places["x"]].group
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for j, name in enumerate(names):
        if name.quantity == "orientation" and name.axis is not None:
            groups.setdefault(name.group, {}).setdefault(name.axis, j)
    whole = {k: g for k, g in groups.items() if len(g) == 4}
    if len(whole) > 1:  # that of the same thing as the position
        whole = {k: g for k, g in whole.items() if _thing(k) == _thing(position)}
    if len(whole) == 1:
        group = next(iter(whole.values()))
        out |= {f"q{axis}": group[axis] for axis in "xyzw"}
    for quantity in ("tilt", "speed", "gripper"):
        found = sorted((n.rank, j) for j, n in enumerate(names) if n.quantity == quantity)
        if found and (len(found) == 1 or found[0][0] < found[1][0]):
            out[quantity] = found[0][1]
    return out


def _thing(group: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(w for w in group if w not in _ORIENTATION_WORDS)


def _refuse_differing(recordings: list[Recording], columns: list[Columns]) -> None:
    """InputError where some recordings have heights and others have none."""
    first = columns[0]
    for recording, other in zip(recordings, columns, strict=True):
        if ("z" in other.places) != ("z" in first.places):
            with_z = recording if "z" in other.places else recordings[0]
            without = recordings[0] if "z" in other.places else recording
            raise without.complain(f"a column for z, as {with_z.name} has one",
                                   ", ".join(without.columns[:20]), "columns")  # fmt: skip


def _refuse_clocks(recordings: list[Recording], columns: list[Columns], mapping: Mapping) -> None:
    """InputError where the first or last of three nameless columns may be a clock or a count."""
    if mapping.columns is not None:
        return
    nameless = [
        (r, c) for r, c in zip(recordings, columns, strict=True)
        if not r.ordered and len(c.places) >= 3
        and all(r.columns[j].isdecimal() for j in c.places.values())
    ]  # fmt: skip
    if not nameless:
        return
    for axis in ("x", "z"):
        values = [r.numbers(c.places[axis]) for r, c in nameless]
        if may_be_clock(values):
            recording, chosen = nameless[0]
            column = recording.columns[chosen.places[axis]]
            expected = "columns for x and y; say which: --column x=0 --column y=1 (and z=2)"
            found = f"column {column} rises like a clock or a count"
            raise recording.complain(expected, found, "columns")


def may_be_clock(values: list[FloatArray]) -> bool:
    """Whether numbers of recordings rise all the time as time stamps or counts would.

    They do where each recording rises at every step, and each begins at 0, or all steps of all
    recordings are the same, or all are dates.
    """
    known = [v for v in values if len(v) >= 3]
    if not known or any(not (np.diff(v) > 0).all() for v in known):
        return False
    steps = np.concatenate([np.diff(v) for v in known])
    even = float(np.ptp(steps)) <= 1e-3 * float(np.median(steps))
    zero = all(abs(v[0]) < 1e-9 for v in known)
    return even or zero or all(v[0] > 1e8 for v in known)


def _with_common(
    recordings: list[Recording], columns: list[Columns], mapping: Mapping
) -> list[Columns]:
    """Only those kept columns that every recording has, with numbers in them."""
    if mapping.columns is not None:
        return columns
    common = [n for n in KEPT if all(n in c.places for c in columns)]
    if not set(QUATERNION) <= set(common):
        common = [n for n in common if n not in QUATERNION]
    words: set[str] = set()
    for recording, chosen in zip(recordings, columns, strict=True):
        words |= {n for n in common if _words(recording, chosen.places[n])}
    common = [n for n in common if n not in words]
    out = []
    for recording, chosen in zip(recordings, columns, strict=True):
        places = {n: j for n, j in chosen.places.items() if n not in KEPT or n in common}
        left_out = tuple(recording.columns[j] for n, j in chosen.places.items() if n not in places)
        units = {n: u for n, u in chosen.units.items() if n in places}
        rest = (*chosen.rest, *left_out)
        out.append(replace(chosen, places=places, units=units, rest=rest))
    return out
