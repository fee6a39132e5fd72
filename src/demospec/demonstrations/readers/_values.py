"""Where a recording's scene, type, demonstrator and validity come from."""

from __future__ import annotations

from collections.abc import Mapping as MappingType
from typing import Any

import numpy as np

from demospec.demonstrations.readers._recording import Recording

AUTO = {
    "scene": ("scene", "scene_id", "scene_name"),
    "type": ("type", "user_type", "style"),
    "demonstrator": ("demonstrator", "demonstrator_id", "operator", "subject", "participant"),
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
    """What ``auto`` stands for in these recordings: a field, ``folder``, or ``none``."""
    for name in AUTO[what]:
        if any(name in r.fields for r in recordings):
            return name
    if what == "valid":
        folders = [r.folders[-1] for r in recordings if r.folders]
        if len(folders) == len(recordings) and all(
            truth(f, words) is not _NEITHER for f in folders
        ):
            return "folder"
    return "none"


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
    if isinstance(value, np.ndarray):
        kinds = {str(v) for v in value.tolist()}
        if len(kinds) > 1:
            raise recording.complain(
                f"one value of {source} in a recording", ", ".join(sorted(kinds)[:3]), what
            )
        value = value.tolist()[0] if len(value) else None
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return None
    if isinstance(value, float) and value.is_integer():
        value = int(value)
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
        return bool(value) if value in (0, 1) else words.get(f"{value:g}", _NEITHER)
    word = str(value).strip()
    if word in words:
        return words[word]
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
    if isinstance(value, np.ndarray):
        values = [truth(v, words) for v in np.unique(value).tolist()]
        bad = [v for v, t in zip(np.unique(value).tolist(), values, strict=True) if t is _NEITHER]
        if bad:
            raise _not_truth(recording, bad[0], source)
        if not values or all(v is None for v in values):
            return None
        return any(v is True for v in values)
    found = truth(value, words)
    if isinstance(found, _Neither):
        raise _not_truth(recording, value, source)
    return found


def _not_truth(recording: Recording, value: object, source: str) -> Exception:
    return recording.complain(
        "a truth value (true, false, 1, 0, valid, invalid, success, failure, …; "
        "other words: the key words of the mapping)",
        value,
        source,
    )
