"""Tables with headers of several lines: Motive, DeepLabCut, Tracker, Kinovea's text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from demospec.demonstrations.readers._column_names import LENGTHS, column_name
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers.tables._cells import TextColumns, as_number
from demospec.demonstrations.readers.tables._text_lines import (
    DELIMITERS,
    Line,
    delimiter_of,
    head_of,
    lines_of,
    split,
)
from demospec.demonstrations.readers.tables._text_table import Header, TextTable, table_of
from demospec.errors import InputError


@dataclass(frozen=True)
class Layout:
    """A file of one of the known layouts.

    Args:
        tables: Name of a part (None where the file holds one path) → its columns.
        notes: What was chosen, for people.
        up: The axis that points up where it is not z, so that the table's plane is to be said.
        world_units: The coordinates are in a unit that the file does not state.
    """

    tables: list[tuple[str | None, TextTable]]
    notes: tuple[str, ...] = ()
    up: str | None = None
    world_units: str | None = None


def layout_of(data: bytes, how: Mapping, file: Path) -> Layout | None:
    """The file as one of the known layouts, or None.

    Args:
        data: Its text, UTF-8.
        how: `path` names the body, body part or track where there are several.
        file: For messages.
    """
    if how.header_row is not None:
        return None
    head = head_of(data, file, how.skip_rows)
    readers: list[Callable[[bytes, list[Line], Mapping, Path], Layout | None]] = [
        _motive, _deeplabcut, _kinovea, _tracker,
    ]  # fmt: skip
    found = (reader(data, head, how, file) for reader in readers)
    return next((layout for layout in found if layout is not None), None) if head else None


def _chosen(groups: dict[str, dict[str, int]], how: Mapping, file: Path, what: str) -> str:
    """The name of the group of columns that holds the path."""
    if how.path is not None:
        if how.path in groups:
            return how.path
        raise InputError(f"a {what} {how.path}", ", ".join(groups), file=file, field="path")
    if len(groups) != 1:
        expected = f"one {what}; say which: --path NAME"
        raise InputError(expected, ", ".join(groups) or "none", file=file, field="path")
    return next(iter(groups))


def _part(table: TextTable, places: dict[str, int], units: dict[str, str]) -> TextTable:
    """Some columns of a table, under other names."""
    cells = table.cells
    part = TextColumns(
        [cells.columns[j] for j in places.values()], tuple(places),
        file=cells.file, comma=cells.decimal_commas, decimal=cells.decimal, line=cells.line,
    )  # fmt: skip
    return TextTable(tuple(places), part, units)


def _numbered(head: Line, width: int, delimiter: str) -> Header:
    return Header([str(i) for i in range(width)], head.end, delimiter)


def _motive(data: bytes, head: list[Line], how: Mapping, file: Path) -> Layout | None:
    """OptiTrack Motive's CSV export (format 1.2x): rigid bodies and markers."""
    first = split(head[0].text, ",")
    if first[0] != "Format Version":
        return None
    said = dict(zip(first[::2], first[1::2], strict=False))
    rows = [split(line.text, ",") for line in head]
    at = next((i for i, r in enumerate(rows) if r[0] == "Frame" and len(r) > 2), None)
    if at is None or at < 3:
        raise InputError("a line Frame, Time (Seconds), X, …", "none", file=file)
    axes, kinds, block = rows[at], rows[at - 1], rows[1 : at - 1]
    named = {r[1].lower(): r for r in block if len(r) > 1 and r[1]}
    types, names = named.get("type", block[0]), named.get("name", block[min(1, len(block) - 1)])
    if said.get("Coordinate Space", "Global") != "Global":
        raise InputError("Coordinate Space Global", said["Coordinate Space"], file=file)
    unit = LENGTHS.get(said.get("Length Units", "").lower())
    if unit is None:
        raise InputError("Length Units of Meters, Centimeters or Millimeters",
                         said.get("Length Units", "none"), file=file)  # fmt: skip
    turned = said.get("Rotation Type") == "Quaternion"
    bodies: dict[str, dict[str, int]] = {}
    markers: dict[str, dict[str, int]] = {}
    for j in range(2, len(axes)):
        cells = [row[j] if j < len(row) else "" for row in (types, names, kinds, axes)]
        kind, name, what, axis = cells
        if what == "Position" or (what == "Rotation" and turned):
            group = (bodies if kind in ("Rigid Body", "Bone") else markers).setdefault(name, {})
            key = f"{what.lower()}.{axis.lower()}"
            if key in group:
                raise InputError("each body once", f"{name} twice", file=file, field="path")
            group[key] = j
    whole = {n: g for n, g in {**markers, **bodies}.items() if "position.x" in g}
    candidates = bodies if len(bodies) == 1 and how.path is None else whole
    name = _chosen(candidates, how, file, "rigid body or marker")
    table = table_of(data, _numbered(head[at], len(axes), ","), how, file)
    places = {"frame": 0, "time": 1, **whole[name]}
    units = {"time": "s", **{f"position.{a}": unit for a in "xyz"}}
    others = [n for n in whole if n != name]
    note = f"body: {name}" + (f"; not read: {', '.join(others[:8])}" if others else "")
    return Layout([(None, _part(table, places, units))], (note,), up="y")


def _deeplabcut(data: bytes, head: list[Line], how: Mapping, file: Path) -> Layout | None:
    """DeepLabCut's CSV: lines scorer, (individuals,) bodyparts, coords."""
    if not head[0].text.lower().lstrip('"').startswith("scorer"):
        return None
    delimiter = delimiter_of(head, file)
    rows = [split(line.text, delimiter) for line in head[:5]]
    keys = [row[0].lower() for row in rows]
    if "bodyparts" not in keys or "coords" not in keys:
        return None
    at = keys.index("coords")
    parts, coords = rows[keys.index("bodyparts")], rows[at]
    owners = rows[keys.index("individuals")] if "individuals" in keys else None
    groups: dict[str, dict[str, int]] = {}
    for j in range(1, len(coords)):
        name = parts[j] if owners is None else f"{owners[j]}/{parts[j]}"
        group = groups.setdefault(name, {})
        if coords[j] in group:
            raise InputError("each body part once", f"{name} twice", file=file, field="path")
        group[coords[j]] = j
    name = _chosen(groups, how, file, "body part")
    table = table_of(data, _numbered(head[at], len(coords), delimiter), how, file)
    part = _part(table, {"frame": 0, **groups[name]}, {"x": "px", "y": "px"})
    others = [n for n in groups if n != name]
    notes = [f"body part: {name}" + (f"; not read: {', '.join(others[:8])}" if others else "")]
    if "likelihood" in groups[name]:
        doubtful = int((part.cells.numbers(part.names.index("likelihood")) < 0.6).sum())
        if doubtful:
            notes.append(f"likelihood: below 0.6 in {doubtful} of {len(part.cells)} points, kept")
    return Layout([(None, part)], tuple(notes))


def _kinovea(data: bytes, head: list[Line], how: Mapping, file: Path) -> Layout | None:
    """Kinovea's text export: a part for each trajectory, time and position in each line."""
    if "kinovea trajectory data export" not in head[0].text.lower():
        return None
    sections: list[tuple[str, list[Line]]] = []
    name, open_section = "", False
    for line in lines_of(data, file):
        text = line.text.strip()
        if text.startswith("#"):
            title = text.lstrip("#").strip()
            name = "" if line.number == head[0].number or title == "T X Y" else title
        if not text or text.startswith("#"):
            open_section = False
            continue
        if not open_section:
            sections.append((name or str(len(sections)), []))
            open_section, name = True, ""
        sections[-1][1].append(line)
    tables = []
    for name, lines in sections:
        blank = b"\n" * (lines[0].number - 1)
        body = blank + b"".join(line.text.encode() + b"\n" for line in lines)
        table = table_of(body, Header(["time", "x", "y"], len(blank), " "), how, file)
        tables.append((None if len(sections) == 1 else name, table))
    stamped = tables and as_number(tables[0][1].cells.texts(0)[0], comma=True) is None
    if stamped:  # 0:00:00:12: in frames of an unknown rate
        tables = [(n, _part(t, {"timecode": 0, "x": 1, "y": 2}, {})) for n, t in tables]
    notes = ("time: none (time codes count frames of a rate that is not stated)",) * bool(stamped)
    return Layout(tables, notes, world_units="Kinovea")


def _tracker(data: bytes, head: list[Line], how: Mapping, file: Path) -> Layout | None:
    """Tracker's data export: the track's name, then t, x, y; or several tracks side by side."""
    several = head[0].text.strip().lower() == "#multi:"
    rows = head[1:] if several else head
    title = rows[0].text.strip(" ;,\t|") if rows else "#"
    if len(rows) < 2 or title.startswith("#") or (not several and set(title) & set(DELIMITERS)):
        return None
    delimiter = delimiter_of(rows[1:], file)
    names, columns = split(rows[0].text, delimiter), split(rows[1].text, delimiter)
    while len(columns) > 1 and not columns[-1]:
        columns = columns[:-1]
    said = [n for n in names if n]
    axes = {c.axis for c in map(column_name, columns) if c.quantity == "position"}
    alone = len(said) == 1 and (delimiter != " " or len(names) == 1)
    if not {"x", "y"} <= axes or not (several or alone):
        return None
    if not several and (as_number(said[0], comma=True) is not None or columns[0] != "t"):
        return None
    groups: dict[str, dict[str, int]] = {}
    owner = said[0] if said else ""
    for j in range(1, len(columns)):
        owner = (names[j] if several and j < len(names) and names[j] else owner) or ""
        group = groups.setdefault(owner, {})
        if columns[j] in group:
            raise InputError("each column name once", f"{columns[j]} twice", file=file)
        group[columns[j]] = j
    name = _chosen(groups, how, file, "track")
    body = rows[2:] and split(rows[2].text, delimiter)
    width = max(len(columns), len(body or []))
    table = table_of(data, _numbered(rows[1], width, delimiter), how, file)
    part = _part(table, {columns[0]: 0, **groups[name]}, {})
    others = [n for n in groups if n != name]
    note = f"track: {name}" + (f"; not read: {', '.join(others[:8])}" if others else "")
    return Layout([(None, part)], (note,), world_units="Tracker")
