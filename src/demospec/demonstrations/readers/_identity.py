"""Names: text as it is written, fit to be kept; numbers that stand for one thing only."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from demospec.demonstrations.readers._recording import Recording
from demospec.errors import InputError

MAX_NAME = 1000
"""Characters in a name; a set's files are read with the same limit."""


def checked_name(text: str, *, what: str, file: Path | None, row: int | str | None) -> str:
    """The name, if a set can keep it.

    Raises:
        InputError: Empty, too long, or with characters that are no text (NUL, half of a pair).
    """
    if not text:
        raise InputError("a name", "an empty one", file=file, row=row, field=what)
    if len(text) > MAX_NAME:
        found = f"{len(text)} characters"
        raise InputError(f"at most {MAX_NAME} characters", found, file=file, row=row, field=what)
    if "\0" in text or any("\ud800" <= c <= "\udfff" for c in text):
        found = ascii(text[:60])
        raise InputError("a name that is text", found, file=file, row=row, field=what)
    return text


def refuse_repeats(recordings: list[Recording]) -> None:
    """InputError where two recordings have one name; both are named."""
    for name, n in Counter(r.name for r in recordings).items():
        if n > 1:
            one, other = [r for r in recordings if r.name == name][:2]
            where = " and ".join(_where(r) for r in (one, other))
            raise other.complain("each name once", f"{name} {n} times: {where}", "name")


def _where(recording: Recording) -> str:
    file = recording.file
    name = "" if file is None else "/".join(file.parts[-2:])
    return f"{name} {recording.row}".strip() if recording.row is not None else name
