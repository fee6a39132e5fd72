"""Recordings and a mapping → a demonstration set, with notes about every choice made."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._trajectory import (
    MAX_COORDINATE,
    MAX_POINTS,
    Demonstration,
    Demonstrations,
)
from demospec.demonstrations.readers._clock import SECONDS, ClockRead, jumps_of, unit_of
from demospec.demonstrations.readers._column_names import column_name
from demospec.demonstrations.readers._columns import QUATERNION, Columns, columns_of
from demospec.demonstrations.readers._identity import checked_name, refuse_repeats
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._projection import Projection, projection_of
from demospec.demonstrations.readers._reading import ColumnRead, FrameRead, Reading
from demospec.demonstrations.readers._recording import ListedObjects, Recording, Source
from demospec.demonstrations.readers._scene_parts import (
    drawings_fitted,
    finished_scenes,
    in_set_units,
    match_objects,
    raw_scenes,
)
from demospec.demonstrations.readers._set_frame import frame_of
from demospec.demonstrations.readers._units import (
    Converter,
    SourceUnit,
    in_source_unit,
    source_unit,
)
from demospec.demonstrations.readers._values import (
    automatic,
    refuse_unknown,
    text_of,
    validity_of,
)
from demospec.errors import InputError
from demospec.frames import FloatArray, Frame


@dataclass(frozen=True)
class _Chosen:
    """The sources that the words ``auto`` were resolved to."""

    scene: str
    type: str
    demonstrator: str
    valid: str


@dataclass(frozen=True)
class _Path:
    """The points of one recording (n, d) in the source's unit, and its stamps in the clock's."""

    points: FloatArray
    t: FloatArray | None


def assemble(
    source: Source,
    mapping: Mapping,
    *,
    root: Path,
    objects: list[ListedObjects] | None = None,
    pictures: bool = True,
) -> tuple[DemonstrationSet, Reading]:
    """The set that a source holds, and how it was read. Appends to `source.notes`.

    Args:
        source: What a reader found.
        mapping: How to read it.
        root: The folder relative to which the mapping names pictures.
        objects: Objects by picture, from a file of objects, pixels.
        pictures: False decodes no picture (a dry run).

    Raises:
        InputError: With the file, the recording and the field.
    """
    if not source.recordings:
        raise InputError("at least one recording", "none", file=root)
    recordings, notes = source.recordings, source.notes
    refuse_repeats(recordings)
    chosen = _choose(recordings, mapping, notes)
    columns = columns_of(recordings, mapping)
    projection = projection_of(mapping.projection)
    _refuse_unsaid_plane(source, projection)
    scenes_of = [_scene_name(r, chosen.scene) for r in recordings]
    raw = raw_scenes(source, mapping, scenes_of, root)
    shown = {k: s.load() if pictures and s.load is not None else None for k, s in raw.items()}
    raw, scales = drawings_fitted(source, shown, raw)
    unit = source_unit(recordings, columns, mapping, source.units)
    paths = [_path(r, c, mapping) for r, c in zip(recordings, columns, strict=True)]
    columns, paths = _kept(recordings, columns, paths, projection, notes)
    names = tuple(columns[0].places)
    converter = Converter.of(unit, mapping, projection, raw, names, notes)
    stamps, clock = _stamps(recordings, columns, paths, mapping, notes)
    _note_columns(recordings[0], columns[0], notes)
    items = []
    for i, (recording, scene) in enumerate(zip(recordings, scenes_of, strict=True)):
        points = in_source_unit(paths[i].points, columns[i], unit.factors[i], unit.unit, recording)
        points[:, :2] *= scales.get(scene, (1.0, 1.0))
        row = recording.row if recording.row is not None else f"recording {recording.name}"
        items.append(
            Demonstration(
                demo_id=checked_name(recording.name, what="name", file=recording.file, row=row),
                scene_id=checked_name(scene, what="scene", file=recording.file, row=row),
                points=converter.convert(recording, points, shown.get(scene)),
                type=_word(recording, chosen.type, "type"),
                demonstrator=_word(recording, chosen.demonstrator, "demonstrator"),
                valid=validity_of(recording, chosen.valid, mapping.words),
                t=stamps[i],
            )
        )
    metres = converter.metres_per_unit(items)
    items = converter.heights_in_pixels(items, metres)
    raw = in_set_units(raw, shown, converter)
    file = None if mapping.objects is None else root / mapping.objects
    raw, matched = match_objects(raw, shown, objects, file)
    scenes = finished_scenes(raw, shown, items, notes)
    listed = f"objects: listed in {matched.matched} of {len(scenes)} scenes"
    if matched.unused:
        some = ", ".join(matched.unused[:5]) + (", …" if len(matched.unused) > 5 else "")
        listed += f", {len(matched.unused)} listed pictures are no scene ({some})"
    notes.append(listed)
    symbols = sorted({o.symbol for s in scenes for o in s.objects or ()})
    types = list(dict.fromkeys(i.type for i in items if i.type is not None))
    data = DemonstrationSet(
        scenes=scenes,
        demonstrations=Demonstrations.of(items, columns=len(names)),
        name=mapping.name or source.name,
        units=converter.units,
        metres_per_unit=metres,
        symbols=tuple(symbols),
        types=tuple(types),
        columns=names,
        frame=frame_of(source, converter, shown.values()),
    )
    reading = Reading(
        columns=_columns_read(recordings, columns, clock, unit),
        not_read=columns[0].rest,
        frame=_frame(data, converter, unit),
        time=clock,
        labels=source.labels,
        values={w: getattr(chosen, w) for w in ("scene", "type", "demonstrator", "valid")},
        labelled={
            "accepted": sum(i.valid is True for i in items),
            "rejected": sum(i.valid is False for i in items),
            "not_judged": sum(i.valid is None for i in items),
        },
        objects=matched,
    )
    return data, reading


def _choose(recordings: list[Recording], mapping: Mapping, notes: list[str]) -> _Chosen:
    found = {}
    for what in ("scene", "type", "demonstrator", "valid"):
        asked = getattr(mapping, what)
        where = automatic(what, recordings, mapping.words) if asked == "auto" else asked
        refuse_unknown(recordings, where, what)
        found[what] = where
        if where == "none":
            none = {
                "valid": "none recorded",
                "scene": "one for all",
                "type": "none (all are taken for one person; --type names them)",
            }.get(what, "none")
            stated = what == "scene" and any(r.scene is not None for r in recordings)
            notes.append(f"{what}: {'as the source states' if stated else none}")
        else:
            notes.append(f"{what}: from {where}{' (found)' if asked == 'auto' else ''}")
    return _Chosen(**found)


def _scene_name(recording: Recording, source: str) -> str:
    if source == "none":
        return recording.scene or "scene"
    return text_of(recording, source, "scene") or recording.scene or "scene"


def _word(recording: Recording, source: str, what: str) -> str | None:
    text = text_of(recording, source, what)
    if text is None:
        return None
    row = recording.row if recording.row is not None else f"recording {recording.name}"
    return checked_name(text, what=what, file=recording.file, row=row)


def _refuse_unsaid_plane(source: Source, projection: Projection | None) -> None:
    """InputError where an axis other than z points up and nobody said which plane is the table."""
    if source.up is not None and projection is None:
        plane = {"y": "zx", "x": "yz"}.get(source.up, "xy")
        expected = f"the plane of the table: --plane {plane} where {source.up} points up, else xy"
        raise InputError(expected, "none", field="projection.plane")


def _path(recording: Recording, columns: Columns, mapping: Mapping) -> _Path:
    """The chosen columns of a recording, thinned, with its time stamps."""
    names = list(columns.places)
    points = np.stack([recording.numbers(j) for j in columns.places.values()], axis=1)
    if not len(points):
        raise recording.complain("at least one point", "none", "points")
    t = _raw_times(recording, columns, mapping)
    kept = np.arange(len(points))
    if mapping.drop_missing:
        kept = np.flatnonzero(np.isfinite(points).all(axis=1))
        if not len(kept):
            raise recording.complain("a point that is not missing", "none", "points")
    wrong = ~(np.abs(points[kept]) <= MAX_COORDINATE)
    if wrong.any():
        at, k = (int(v) for v in np.argwhere(wrong)[0])
        i, j = int(kept[at]), columns.places[names[k]]
        expected = f"finite numbers of size at most {MAX_COORDINATE:.0e}"
        if np.isnan(points[i, k]):
            expected += " (--drop-missing leaves such points out"
            expected += ")" if k < 3 else "; --column x=NAME --column y=NAME read only those)"
        row, found = recording.place(j, i, points[i, k])
        raise InputError(expected, found, file=recording.file, row=row, field=names[k])
    if mapping.every > 1:
        take = np.arange(0, len(kept), mapping.every)
        if take[-1] != len(kept) - 1:
            take = np.append(take, len(kept) - 1)
        kept = kept[take]
    if len(kept) > MAX_POINTS:
        expected = f"at most {MAX_POINTS} points in one path (thin it out: --every N)"
        raise recording.complain(expected, f"{len(kept)} points", "points")
    return _Path(points[kept], None if t is None else t[kept])


def _raw_times(recording: Recording, columns: Columns, mapping: Mapping) -> FloatArray | None:
    """The stamps as they stand in the source."""
    if mapping.time is not None and str(mapping.time) == "none":
        return None
    t: FloatArray | None = recording.t
    if columns.time is not None:
        cells = recording.cells
        t = recording.numbers(columns.time) if cells is None else cells.seconds(columns.time)
        if columns.nanoseconds is not None:
            t = t + recording.numbers(columns.nanoseconds) * 1e-9
    elif mapping.time is not None:
        name = str(mapping.time)
        value = recording.fields.get(name)
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iuf":
            known = ", ".join(dict.fromkeys([*recording.columns, *recording.fields]))
            expected = f"a column {name} of time stamps (there are: {known})"
            raise recording.complain(expected, "none", "time")
        t = value.astype(np.float64)
    if t is None or np.isnan(t).all():
        return None
    if len(t) != len(recording.cells or recording.points):
        n = len(recording.cells or recording.points)
        raise recording.complain(f"{n} time stamps (one a point)", len(t), "time")
    return t


def _kept(
    recordings: list[Recording],
    columns: list[Columns],
    paths: list[_Path],
    projection: Projection | None,
    notes: list[str],
) -> tuple[list[Columns], list[_Path]]:
    """Without an orientation that is none, and without a speed that has no one unit."""
    left_out: list[str] = []
    if set(QUATERNION) <= set(columns[0].places):
        for recording, chosen, path in zip(recordings, columns, paths, strict=True):
            at = [list(chosen.places).index(q) for q in QUATERNION]
            size = np.linalg.norm(path.points[:, at], axis=1)
            if (np.abs(size - 1) > 0.1).any():
                i = int(np.flatnonzero(np.abs(size - 1) > 0.1)[0])
                notes.append(
                    f"orientation: not kept (a quaternion of length {size[i]:.3g}, "
                    f"{recording.name}, point {i})"
                )
                left_out += QUATERNION
                break
    if projection is not None and projection.to_pixels and "speed" in columns[0].places:
        notes.append("speed: not kept (a homography scales it by place)")
        left_out.append("speed")
    if not left_out:
        return columns, paths
    new_columns, new_paths = [], []
    for recording, chosen, path in zip(recordings, columns, paths, strict=True):
        names = [n for n in chosen.places if n not in left_out]
        at = [list(chosen.places).index(n) for n in names]
        rest = (*chosen.rest, *(recording.columns[chosen.places[n]] for n in left_out))
        places = {n: chosen.places[n] for n in names}
        units = {n: u for n, u in chosen.units.items() if n in places}
        new_columns.append(replace(chosen, places=places, units=units, rest=rest))
        new_paths.append(_Path(path.points[:, at], path.t))
    return new_columns, new_paths


def _stamps(
    recordings: list[Recording],
    columns: list[Columns],
    paths: list[_Path],
    mapping: Mapping,
    notes: list[str],
) -> tuple[list[FloatArray | None], ClockRead | None]:
    """Every recording's time stamps in seconds, and what was decided about them."""
    known = [i for i, p in enumerate(paths) if p.t is not None]
    if not known:
        notes.append("time: none")
        return [None] * len(paths), None
    for i in known:
        t = paths[i].t
        if t is not None and not np.isfinite(t).all():
            at = int(np.flatnonzero(~np.isfinite(t))[0])
            found = f"{t[at]} in point {at}"
            raise recordings[i].complain("finite seconds (--time none reads no time)", found, "t")
    first = recordings[known[0]]
    column, stated, open_unit = _clock_of(first, columns[known[0]], mapping)
    if open_unit:
        raw = [t for i in known if (t := paths[i].t) is not None]
        unit, why = unit_of(raw, column, stated, mapping.time_unit)
    else:
        unit, why = "s", "the format's"
    out = [None if p.t is None else p.t * SECONDS[unit] for p in paths]
    names = [recordings[i].name for i in known]
    jumps = jumps_of(names, [t for t in out if t is not None])
    without = len(paths) - len(known)
    note = f"time: {unit} from {column} ({why})"
    if without:
        note += f", none in {without} recordings"
    notes.append(note)
    notes += [f"clock: {j}" for j in jumps]
    return out, ClockRead(column, unit, why, jumps)


def _clock_of(
    recording: Recording, columns: Columns, mapping: Mapping
) -> tuple[str, str | None, bool]:
    """The column of the stamps, the unit that the source states, and whether it is open."""
    if columns.time is not None:
        name = recording.columns[columns.time]
        return name, column_name(name, recording.units.get(name)).unit, True
    if mapping.time is not None:
        return str(mapping.time), column_name(str(mapping.time)).unit, True
    if recording.clock is not None:
        return recording.clock.column, recording.clock.unit, True
    return "the format's clock", "s", mapping.time_unit is not None


def _note_columns(recording: Recording, columns: Columns, notes: list[str]) -> None:
    said = [f"{ours} from {recording.columns[j]}" for ours, j in columns.places.items()]
    rest = [c or "(no name)" for c in columns.rest]
    more = f" and {len(rest) - 12} more" if len(rest) > 12 else ""
    left = f"; not read: {', '.join(rest[:12])}{more}" if rest else ""
    notes.append(f"path: {', '.join(said)}{left}")


def _columns_read(
    recordings: list[Recording], columns: list[Columns], clock: ClockRead | None, unit: SourceUnit
) -> tuple[ColumnRead, ...]:
    """Every column → its meaning; the names of all recordings where they differ."""
    out = []
    for ours in columns[0].places:
        theirs = [r.columns[c.places[ours]] for r, c in zip(recordings, columns, strict=True)]
        units = [c.units.get(ours) for c in columns]
        own = {"x": unit.unit, "y": unit.unit, "z": unit.unit, "tilt": "deg",
               "speed": f"{unit.unit}/s"}.get(ours)  # fmt: skip
        said = list(dict.fromkeys(u or own for u in units))
        out.append(
            ColumnRead(
                ", ".join(dict.fromkeys(theirs)), ours, ", ".join(u for u in said if u) or None
            )
        )
    if clock is not None:
        out.append(ColumnRead(clock.column, "t", clock.unit))
    return tuple(out)


def _frame(data: DemonstrationSet, converter: Converter, unit: SourceUnit) -> FrameRead:
    """The frame of the set: that of its picture's pixels, else the source's."""
    if data.units == "px":
        how = unit.how if converter.source_metres is None else f"from {unit.unit}"
        return FrameRead("picture", "px", "down", how)
    frame = data.frame or Frame.of_units(data.units)
    how = unit.how if unit.unit == "m" else f"from {unit.unit}, {unit.how}"
    return FrameRead(frame.name, data.units, frame.y, how)
