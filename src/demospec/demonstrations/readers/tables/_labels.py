"""Tables of labels: one line a recording; names match as text, then as numbers."""

from __future__ import annotations

import re
from collections import ChainMap
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import LabelsRead, Source
from demospec.demonstrations.readers._values import truth
from demospec.demonstrations.readers.tables._text_table import TextTable, read_csv
from demospec.errors import InputError

FILES = ("labels.csv", "metadata.csv", "index.csv")
"""Names of the table of labels that are looked for beside the recordings."""

_KEY = ("file", "file_name", "filename", "name", "demo_id", "demonstration", "demo", "episode",
        "episode_id", "episode_index", "trajectory", "trajectory_id", "traj_id", "recording",
        "path", "id")  # fmt: skip
_SUFFIX = re.compile(r"\.(csv|tsv|txt|npy|npz|json|jsonl|mcap|bag|db3|hdf5|h5)$", re.IGNORECASE)


def labels_file(root: Path, path: Path, mapping: Mapping) -> Path | None:
    """The table of labels: the one that the mapping names, else one beside the recordings."""
    if mapping.labels == "none":
        return None
    if mapping.labels is not None:
        return root / mapping.labels
    if not path.is_dir():
        return None
    return next((root / name for name in FILES if (root / name).is_file()), None)


def add_labels(source: Source, file: Path, root: Path) -> None:
    """Adds the fields of a table of labels to the recordings that it names.

    Raises:
        InputError: Two lines for one recording, a line that could mean two recordings, or no line
            that names any.
    """
    table = read_csv(file)
    key, names = _keys(table, file)
    columns = [c for c in table.names if c != key]
    found = match_names(
        _recording_names(source), names, file=file, field=key, line=table.cells.line
    )
    if not found:
        some = ", ".join(names[:3])
        expected = f"names of recordings ({', '.join(r.name for r in source.recordings[:3])}, …)"
        raise InputError(expected, some, file=file, field=key)
    texts = {c: table.cells.texts(table.names.index(c)) for c in columns}
    recordings = []
    for i, recording in enumerate(source.recordings):
        row = found.get(i)
        given: dict[str, Any] = {c: None if row is None else texts[c][row] for c in columns}
        own = cast(dict[str, Any], recording.fields)
        recordings.append(replace(recording, fields=ChainMap(given, own)))
    source.recordings = recordings
    without = tuple(r.name for i, r in enumerate(recordings) if i not in found)
    used = set(found.values())
    unused = tuple(n for j, n in enumerate(names) if j not in used)
    shown = file.relative_to(root).as_posix() if file.is_relative_to(root) else file.name
    source.labels = LabelsRead(shown, tuple(columns), len(found), without, unused)
    words = f"labels: {shown}, for {len(found)} of {len(recordings)} recordings"
    if without:
        words += f", {len(without)} recordings not in it ({_some(without)})"
    if unused:
        words += f", {len(unused)} lines of it name no recording ({_some(unused)})"
    source.notes.append(words)


def _some(names: tuple[str, ...]) -> str:
    return ", ".join(names[:5]) + (", …" if len(names) > 5 else "")


def _recording_names(source: Source) -> list[tuple[str, ...]]:
    """What each recording may be called: its name, and that without folders."""
    return [tuple(dict.fromkeys([r.name, r.name.rsplit("/", 1)[-1]])) for r in source.recordings]


def _keys(table: TextTable, file: Path, *, endings: bool = False) -> tuple[str, list[str]]:
    """The column of names, and the names, without the endings of files unless these are kept."""
    lower = {n.lower(): n for n in reversed(table.names)}
    key = next((lower[k] for k in _KEY if k in lower), None)
    if key is None:
        expected = f"a column that names the recording ({', '.join(_KEY)})"
        raise InputError(expected, ", ".join(table.names) or "none", file=file)
    texts = table.cells.texts(table.names.index(key))
    names = texts if endings else [_plain_name(t) for t in texts]
    first: dict[str, int] = {}
    for i, name in enumerate(names):
        if name in first:
            lines = f"lines {table.cells.line(first[name])} and {table.cells.line(i)}"
            raise InputError("one line a recording", f"{name} in {lines}", file=file, field=key)
        first[name] = i
    return key, names


def _plain_name(name: str) -> str:
    return _SUFFIX.sub("", name.replace("\\", "/"))


def match_names(
    wanted: list[tuple[str, ...]],
    names: list[str],
    *,
    file: Path,
    field: str,
    line: Any,
) -> dict[int, int]:
    """Which name belongs to which of the wanted: as text, else, one to one, as numbers.

    Args:
        wanted: What each of them may be called.
        names: The names there are, each once.
        file, field, line: For messages.

    Returns:
        Place in `wanted` → place in `names`; those that match nothing are absent.

    Raises:
        InputError: A name that means several of the wanted.
    """
    found = _matched(wanted, {n: j for j, n in enumerate(names)})
    if not found:
        # 7 for 007, 1708923255.0 for 1708923255: only where no two become one.
        numbers = [_as_integer(n) for n in names]
        given = {n: j for j, n in enumerate(numbers) if n is not None}
        theirs = [tuple(n for n in map(_as_integer, w) if n is not None) for w in wanted]
        sole = {n for w in theirs for n in w}
        if len(given) == sum(n is not None for n in numbers) and len(sole) == len(
            [w for w in theirs if w]
        ):
            found = _matched(theirs, given)
    owners: dict[int, int] = {}
    for i, j in found.items():
        if j in owners:
            both = f"{wanted[owners[j]][0]}, {wanted[i][0]}"
            expected = f"a name of one recording (this one could mean {both})"
            raise InputError(expected, names[j], file=file, row=f"line {line(j)}", field=field)
        owners[j] = i
    return found


def _matched(wanted: list[tuple[str, ...]], places: dict[str, int]) -> dict[int, int]:
    found = {}
    for i, names in enumerate(wanted):
        place = next((places[n] for n in names if n in places), None)
        if place is not None:
            found[i] = place
    return found


def _as_integer(text: str) -> str | None:
    """The integer that a text writes (``007``, ``7.0``), in its shortest form."""
    match = re.fullmatch(r"0*(\d+)(\.0*)?", text.strip())
    return None if match is None else match[1]


def read_label_table(file: Path) -> dict[str, dict[str, Any]]:
    """A CSV with a column of names and any of ``valid``, ``type``, ``demonstrator``.

    Returns:
        Demonstration → the values given for it (an empty cell of ``valid`` means no label).

    Raises:
        InputError: No such columns, a demonstration twice, or a word that is no truth value.
    """
    table = read_csv(file)
    lower = {n.lower(): n for n in reversed(table.names)}
    wanted = [c for c in ("valid", "type", "demonstrator") if c in lower]
    if not wanted or not any(k in lower for k in _KEY):
        expected = "columns demo_id and valid, type or demonstrator"
        raise InputError(expected, ", ".join(table.names) or "none", file=file)
    _, names = _keys(table, file, endings=True)
    out: dict[str, dict[str, Any]] = {name: {} for name in names}
    for column in wanted:
        for row, cell in enumerate(table.cells.texts(table.names.index(lower[column]))):
            value: object = cell or None
            if column == "valid":
                value = truth(cell, {})
                if value is not None and not isinstance(value, bool):
                    line = f"line {table.cells.line(row)}"
                    raise InputError("a truth value", cell, file=file, row=line, field="valid")
            out[names[row]][column] = value
    return out
