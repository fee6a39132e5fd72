"""Where a recording's scene, type, demonstrator and validity come from."""

from __future__ import annotations

import re
from collections.abc import Mapping as MappingType
from typing import Any

import numpy as np

from demospec.demonstrations.readers._recording import Recording

AUTO = {
    "scene": ("scene", "scene_id", "scene_name"),
    "type": ("type", "user_type", "style"),
    "demonstrator": ("demonstrator", "demonstrator_id", "operator", "subject", "participant",
                     "annotator"),
    "valid": (
        "valid", "is_valid", "success", "is_success", "successful", "next.success", "accepted",
        "outcome", "label",
    ),
}  # fmt: skip
"""Field names that ``auto`` looks for, in this order."""

TRUE_WORDS = frozenset([
    "true", "yes", "y", "1", "valid", "success", "successful", "succeeded", "accepted", "accept",
    "good", "ok", "pass", "passed", "positive",
])  # fmt: skip
FALSE_WORDS = frozenset([
    "false", "no", "n", "0", "invalid", "failure", "failed", "fail", "rejected", "reject", "bad",
    "unacceptable", "negative", "not_valid",
])  # fmt: skip
UNKNOWN_WORDS = frozenset(["", "none", "null", "nan", "unknown", "na", "n/a", "?"])


def automatic(what: str, recordings: list[Recording], words: MappingType[str, bool]) -> str:
    """What ``auto`` stands for in these recordings: a field, ``folder``, ``folder:N`` or ``none``.

    Fields are found in whatever case they are written.

    Raises:
        InputError: Folders of two levels could say whether a recording was accepted.
    """
    known: dict[str, str] = {}
    for recording in recordings:
        for field in recording.fields:
            known.setdefault(field.lower(), field)
    for name in AUTO[what]:
        found = name if any(name in r.fields for r in recordings) else known.get(name)
        if found is not None and (name != "label" or _says_truth(recordings, found, words)):
            return found
    if what == "valid":
        depth = min(len(r.folders) for r in recordings)
        levels = [
            k for k in range(depth)
            if all(isinstance(truth(r.folders[k], words), bool) for r in recordings)
        ]  # fmt: skip
        if len(levels) > 1:
            expected = "folders of one level that say what was accepted (--valid folder:N)"
            raise recordings[0].complain(expected, "/".join(recordings[0].folders), "valid")
        if levels and all(len(r.folders) == levels[0] + 1 for r in recordings):
            return "folder"
        if levels:
            return f"folder:{levels[0] + 1}"
    return "none"


def _says_truth(recordings: list[Recording], name: str, words: MappingType[str, bool]) -> bool:
    """Whether a field holds truth values and nothing else: a ``label`` may be that of a class."""
    for recording in recordings:
        value = recording.fields.get(name)
        said = value.tolist() if isinstance(value, np.ndarray) else value
        for item in dict.fromkeys(map(str, said)) if isinstance(said, list) else [said]:
            if isinstance(truth(item, words), _Neither):
                return False
    return True


def value_of(recording: Recording, source: str, what: str) -> Any:
    """The value that `source` names (see `Mapping`); None where this recording has none.

    Raises:
        InputError: No such folder.
    """
    if source == "none":
        return None
    if source == "file":
        return recording.name
    if source.startswith("always:"):
        return source.removeprefix("always:")
    if source == "folder" or source.startswith("folder:"):
        return _folder(recording, source, what)
    return recording.fields.get(source.removeprefix("field:"))


def refuse_unknown(recordings: list[Recording], source: str, what: str) -> None:
    """InputError where `source` names a field that no recording has (some may lack it)."""
    keyword = source in ("none", "file", "folder") or source.startswith(("always:", "folder:"))
    name = source.removeprefix("field:")
    if not keyword and not any(name in r.fields for r in recordings):
        known = ", ".join(dict.fromkeys(f for r in recordings[:50] for f in r.fields)) or "none"
        raise recordings[0].complain(f"a field {name} (there are: {known})", "none", what)


def _folder(recording: Recording, source: str, what: str) -> str:
    _, _, level = source.partition(":")
    depth = len(recording.folders)
    at = int(level) - 1 if level.isdecimal() and int(level) > 0 else depth - 1
    if level and not level.isdecimal():
        raise recording.complain("folder or folder:N with N from 1", source, what)
    if not 0 <= at < depth:
        where = "/".join(recording.folders) or "no folder"
        raise recording.complain(f"a folder for {source}", where, what)
    return recording.folders[at]


def text_of(recording: Recording, source: str, what: str) -> str | None:
    """A word, or None. An array with one value a point must hold one value throughout."""
    value = value_of(recording, source, what)
    if isinstance(value, np.ndarray) or (isinstance(value, list) and value):
        value = np.asarray(value, dtype=object if isinstance(value, list) else None)
        kinds = {str(v) for v in value.tolist()}
        if len(kinds) > 1:
            raise recording.complain(
                f"one value of {source} in a recording", ", ".join(sorted(kinds)[:3]), what
            )
        value = value.tolist()[0] if len(value) else None
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return None
    if isinstance(value, float) and abs(value) >= 2**53:
        expected = "a name as text or integer (as a floating-point number it has lost digits)"
        raise recording.complain(expected, value, what)
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, (dict, list)):
        raise recording.complain("a word", value, what)
    text = str(value).strip()
    return text or None


class _Neither:
    pass


_NEITHER = _Neither()


def truth(value: Any, words: MappingType[str, bool]) -> bool | _Neither | None:
    """Whether a word or number means accepted; None for unknown; `_NEITHER` for anything else."""
    if value is None:
        return None
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, float, np.integer, np.floating)):
        if np.isnan(value):
            return None
        whole = float(value).is_integer()
        return bool(value) if value in (0, 1) else words.get(str(int(value)) if whole else
                                                             str(value), _NEITHER)  # fmt: skip
    word = str(value).strip()
    if word in words:
        return words[word]
    if re.fullmatch(r"\+?[01](\.0*)?", word):
        return "1" in word
    word = word.lower().replace(" ", "_").replace("-", "_")
    if word in UNKNOWN_WORDS:
        return None
    if word in TRUE_WORDS:
        return True
    return False if word in FALSE_WORDS else _NEITHER


def validity_of(recording: Recording, source: str, words: MappingType[str, bool]) -> bool | None:
    """Accepted, rejected, or None where nobody said.

    A flag with one value a point counts as set where any point sets it (success flags are
    raised at the moment of success).
    """
    value = value_of(recording, source, "valid")
    if isinstance(value, (np.ndarray, list)):
        said = _flags(recording, value, source)
        values = [truth(v, words) for v in said]
        bad = [v for v, t in zip(said, values, strict=True) if t is _NEITHER]
        if bad:
            raise _not_truth(recording, bad[0], source)
        if not values or all(v is None for v in values):
            return None
        return any(v is True for v in values)
    found = truth(value, words)
    if isinstance(found, _Neither):
        raise _not_truth(recording, value, source)
    return found


def _flags(recording: Recording, value: np.ndarray | list[Any], source: str) -> list[Any]:
    """The different values of a flag: one a point, one a step between points, or one in all."""
    points = len(recording.cells or recording.points)
    flat = value.tolist() if isinstance(value, np.ndarray) else value
    if len(flat) not in (0, 1, points - 1, points):
        found = f"{len(flat)} values for {points} points"
        raise recording.complain("one flag, or one a point or step", found, source)
    out: list[Any] = []
    for item in flat:
        item = item[0] if isinstance(item, list) and len(item) == 1 else item
        if isinstance(item, (dict, list)):
            raise _not_truth(recording, item, source)
        if item not in out:
            out.append(item)
    return out


def _not_truth(recording: Recording, value: object, source: str) -> Exception:
    return recording.complain(
        "a truth value (true, false, 1, 0, valid, invalid, success, failure, …; "
        "other words: the key words of the mapping)",
        value,
        source,
    )
