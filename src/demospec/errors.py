"""The exception family: everything demospec raises on purpose.

The command line turns an `InputError` into exit status 2 and one line on stderr, and a
`MissingExtraError` into exit status 2 and the pip command that brings the extra.
"""

from __future__ import annotations

import os
from typing import Any
from unicodedata import category


class DemospecError(Exception):
    """Base of every exception that demospec raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions are rebuilt from their one-line message, which is not how ours are made;
        # raised in a worker process they must reach the parent whole.
        return _revived, (type(self), self.args, self.__dict__)


class InputError(DemospecError):
    """Something the user gave cannot be used: says where, what was expected, what came.

    Args:
        expected: What would have been accepted, in words.
        found: What came instead, in words or as a short value.
        file: The file (or folder) it came from, if any.
        row: Zero-based row or item in that file, if any; or ``line N`` as an editor counts.
        field: Name of the column, key, option or argument, if any.
    """

    def __init__(
        self,
        expected: str,
        found: object,
        *,
        file: str | os.PathLike[str] | None = None,
        row: int | str | None = None,
        field: str | None = None,
    ) -> None:
        self.expected = expected
        self.found = _short(found)
        self.file = None if file is None else os.fspath(file)
        self.row = row
        self.field = field
        where = []
        if self.file is not None:
            where.append(_short(self.file, 300))
        if row is not None:
            place = _short(str(row))
            where.append(place if place.startswith("line ") else f"row {place}")
        if field is not None:
            where.append(_short(field, 300))
        places = ", ".join(where)
        line = f"expected {_short(expected, 600)}, found {self.found}"
        super().__init__(f"{places}: {line}" if places else line)

    def at(
        self,
        *,
        file: str | os.PathLike[str] | None = None,
        row: int | str | None = None,
        field: str | None = None,
    ) -> InputError:
        """The same complaint with a place added (places already known are kept)."""
        return type(self)(
            self.expected,
            self.found,
            file=self.file if self.file is not None else file,
            row=self.row if self.row is not None else row,
            field=self.field if self.field is not None else field,
        )


class CannotJudgeError(InputError):
    """A model lacks what it needs to judge a scene (objects not listed, or no picture)."""


class OutputError(DemospecError):
    """The output path cannot be used (it exists, the disk is full, no permission)."""


class MissingExtraError(DemospecError):
    """An optional library is absent: names it and the pip command that brings it.

    Args:
        library: Import name of the absent library.
        extra: The extra of demospec that brings it.
        what: What needed it, in words.
    """

    def __init__(self, library: str, extra: str, what: str) -> None:
        self.library = library
        self.extra = extra
        super().__init__(f"{what} needs {library}: run  pip install 'demospec[{extra}]'")


class MissingPackageError(DemospecError):
    """A Debian package is absent: names it and the command that brings it.

    Args:
        package: Name of the Debian package.
        what: What needed it, in words.
    """

    def __init__(self, package: str, what: str) -> None:
        self.package = package
        super().__init__(
            f"{what} needs the Debian package {package}: run  apt-get install {package}"
        )


def _revived(
    kind: type[DemospecError], arguments: tuple[Any, ...], state: dict[str, Any]
) -> DemospecError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(state)
    return error


def _short(value: object, limit: int = 120) -> str:
    """One printable line of at most `limit` characters."""
    text = value if isinstance(value, str) else repr(value)
    text = " ".join(text.split())
    if not text.isprintable():
        text = "".join("?" if category(c)[0] == "C" else c for c in text)
    return text if len(text) <= limit else text[: limit - 1] + "…"
