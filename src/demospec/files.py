"""Reading and writing files without ever harming one.

Outputs are written to a temporary name beside their place and renamed; an existing output
is replaced only where the caller says so, and what the command reads is never written over
(`reading`).
"""

from __future__ import annotations

import ctypes
import json
import math
import os
import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from demospec.errors import DemospecError, InputError, OutputError

_inputs: ContextVar[tuple[Path, ...]] = ContextVar("_inputs", default=())


@contextmanager
def reading(paths: Iterable[str | os.PathLike[str]]) -> Iterator[None]:
    """While the block runs, nothing writes over these files or into the place of these folders."""
    found = tuple(Path(path).resolve() for path in paths)
    token = _inputs.set((*_inputs.get(), *found))
    try:
        yield
    finally:
        _inputs.reset(token)


@contextmanager
def writing_file(path: str | os.PathLike[str], *, replace: bool = True) -> Iterator[Path]:
    """Yields a temporary path beside `path`; renames it into place when the block succeeds.

    Raises:
        OutputError: `path` is a folder, exists and `replace` is False, or cannot be written.
    """
    target = Path(path)
    _refuse(target, replace=replace, folder=False)
    temporary: Path | None = None
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{target.name[:80]}.", suffix=target.suffix, dir=target.parent
        )
        os.close(handle)
        temporary = Path(name)
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        os.replace(temporary, target)
    except Exception as error:
        _refuse_fault_of_disk(target, error)
        raise
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


@contextmanager
def writing_folder(path: str | os.PathLike[str], *, replace: bool = False) -> Iterator[Path]:
    """Yields a temporary folder beside `path`; renames it into place when the block succeeds.

    Raises:
        OutputError: `path` exists (and is not an empty folder) and `replace` is False, or
            the disk refuses.
    """
    target = Path(path)
    _refuse(target, replace=replace, folder=True)
    temporary: Path | None = None
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name[:80]}.", dir=target.parent))
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o777 & ~umask)
        yield temporary
        old: Path | None = None
        if target.exists():
            if _exchanged(temporary, target):  # the name always has the old or the new one
                shutil.rmtree(temporary, ignore_errors=True)
                return
            # Where that is not to be had, the old one stays whole beside it until the new one
            # has its name.
            old = Path(tempfile.mkdtemp(prefix=f".{target.name[:80]}.old.", dir=target.parent))
            os.replace(target, old / "old")
        os.replace(temporary, target)
        if old is not None:
            shutil.rmtree(old, ignore_errors=True)
    except OutputError as error:  # of a file in it: the user knows the folder by its own name
        raise OutputError(str(error).replace(str(temporary), str(target))) from error
    except Exception as error:
        _refuse_fault_of_disk(target, error)
        raise
    finally:
        if temporary is not None and temporary.exists():
            shutil.rmtree(temporary, ignore_errors=True)


def _exchanged(first: Path, second: Path) -> bool:
    """Gives two folders each other's name in one step, where the system can (Linux)."""
    try:
        exchange = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    here, swap = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
    return bool(exchange(here, os.fsencode(first), here, os.fsencode(second), swap) == 0)


_FAULTS_OF_DISK = ("No space left", "disk is full", "Disk quota", "File too large", "os error")


def _refuse_fault_of_disk(target: Path, error: Exception) -> None:
    """OutputError for what the disk refused; libraries that write raise exceptions of their own."""
    if isinstance(error, OSError):
        raise OutputError(f"{target}: cannot write: {error.strerror or error}") from error
    said = str(error)
    if not isinstance(error, DemospecError) and any(words in said for words in _FAULTS_OF_DISK):
        raise OutputError(f"{target}: cannot write: {said}") from error


def check_free_folder(path: str | os.PathLike[str], *, replace: bool = False) -> None:
    """Refuses now what `writing_folder` would refuse after hours of work."""
    _refuse(Path(path), replace=replace, folder=True)


def check_free(
    paths: Iterable[str | os.PathLike[str]], *, replace: bool, folder: bool | None = None
) -> None:
    """Refuses, before the work, outputs that could not or must not be written after it.

    Args:
        paths: Where the command will write; two outputs cannot share a place.
        replace: What exists may be replaced.
        folder: Folders are written, or files; None for either.

    Raises:
        OutputError: One of them exists and `replace` is False, is read by the command, or
            cannot be made there.
    """
    seen: set[Path] = set()
    for path in paths:
        target = Path(path)
        try:
            place = target.resolve()
            if place in seen:
                raise OutputError(f"{target}: named for two outputs")
            seen.add(place)
            is_folder = target.is_dir() if folder is None else folder
            _refuse(target, replace=replace, folder=is_folder)
            _refuse_parent(target)
        except ValueError as error:  # a NUL byte
            raise OutputError(f"{str(path)!r}: cannot write: {error}") from error
        except OSError as error:
            raise OutputError(f"{target}: cannot write: {error.strerror or error}") from error


def _refuse_parent(target: Path) -> None:
    """OutputError where no file can be made beside `target`."""
    if len(os.fsencode(target.name)) > 255:
        raise OutputError(f"{target.name[:40]}…: cannot write: File name too long")
    above = next((p for p in target.absolute().parents if p.exists()), Path("/"))
    if not above.is_dir():
        raise OutputError(f"{target}: cannot write: {above} is not a folder")
    if not os.access(above, os.W_OK | os.X_OK):
        raise OutputError(f"{target}: cannot write: no permission to write in {above}")


def _refuse(target: Path, *, replace: bool, folder: bool) -> None:
    if not target.exists():
        if folder:  # nor does a source get a folder more; a file beside its files is welcome
            _refuse_input(target, folder=True)
        if target.is_symlink():
            raise OutputError(f"{target}: is a link to something that is not there")
        return
    _refuse_input(target, folder=folder)
    if folder and target.is_dir():
        if not replace and any(target.iterdir()):
            raise OutputError(f"{target}: exists and is not empty (use --force to replace it)")
    elif folder:
        raise OutputError(f"{target}: is a file, a folder is to be written there")
    elif target.is_dir():
        raise OutputError(f"{target}: is a folder, a file is to be written there")
    elif not target.is_file():
        raise OutputError(f"{target}: is a device or a pipe, a file is to be written there")
    elif not replace:
        raise OutputError(f"{target}: exists (use --force to replace it)")


def _refuse_input(target: Path, *, folder: bool) -> None:
    """OutputError where an output would take the place of something that is being read."""
    place = target.resolve()
    for source in _inputs.get():
        # A report stands in the folder of its run.
        own = place.parent == source and place.name.startswith("report")
        above = folder and source.is_relative_to(place)
        if place == source or above or (place.is_relative_to(source) and not own):
            part = "" if place == source else f" ({'holds' if above else 'part of'} {source})"
            raise OutputError(f"{target}: is read by this command{part}: write to another place")


def write_json(path: str | os.PathLike[str], document: object, *, replace: bool = True) -> None:
    """Writes one JSON document, UTF-8, without NaN, through a temporary name."""
    with writing_file(path, replace=replace) as temporary:
        temporary.write_text(to_json(document) + "\n", encoding="utf-8")


def to_json(document: object) -> str:
    """JSON text, indented by one blank, without NaN (which no JSON reader need accept).

    Control characters and halves of surrogate pairs, which terminals obey and UTF-8 lacks, are
    written as escapes.
    """
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    return _UNSEEN.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


_UNSEEN = re.compile("[\x7f-\x9f\ud800-\udfff]")


def read_json(path: str | os.PathLike[str], *, limit_bytes: int = 1 << 30) -> Any:
    """Reads one JSON document.

    Args:
        path: The file.
        limit_bytes: More is refused.

    Raises:
        InputError: Unreadable, larger than `limit_bytes`, or what `parse_json` refuses.
    """
    file = Path(path)
    return parse_json(read_bytes(file, limit_bytes=limit_bytes), file=file)


def read_bytes(path: str | os.PathLike[str], *, limit_bytes: int = 1 << 30) -> bytes:
    """The bytes of a regular file; InputError where it cannot be read or is too large."""
    file = Path(path)
    try:
        if file.exists() and not file.is_file():
            raise InputError("a file", "a folder or device", file=file)
        size = file.stat().st_size
        if size > limit_bytes:
            raise InputError(f"at most {limit_bytes} bytes", f"{size} bytes", file=file)
        return file.read_bytes()
    except OSError as error:
        raise InputError("a readable file", error.strerror or str(error), file=file) from error
    except ValueError as error:  # a NUL byte in the path
        raise InputError("a readable file", str(error), file=repr(str(path))) from error


_LARGE = re.compile(r"[eE]\+?0*\d{3}|\d{309}")
"""Where a number may be beyond what a double holds (greatest 1.8e308)."""


def parse_json(
    data: bytes, *, file: str | os.PathLike[str] | None = None, row: int | None = None
) -> Any:
    """One JSON document from bytes.

    Args:
        data: UTF-8 text.
        file, row: For messages.

    Raises:
        InputError: Not UTF-8, not JSON, a key twice in one object, a number that is not finite
            or beyond a double's range, or half of a surrogate pair, which is no character.
    """

    def refuse(token: str) -> float:
        before = text[: text.find(token)]
        place = f"line {before.count(chr(10)) + 1} column {len(before) - before.rfind(chr(10))}"
        short = token if len(token) <= 20 else token[:20] + "…"
        raise InputError("a finite number", f"{short} at {place}", file=file, row=row)

    def finite(token: str) -> float:
        value = float(token)
        return value if math.isfinite(value) else refuse(token)

    def whole(token: str) -> int:
        return int(token) if len(token) < 309 else int(refuse(token))

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            key = next(k for k, n in Counter(k for k, _ in pairs).items() if n > 1)
            raise InputError("each key once", f"{key} twice", file=file, row=row)
        return found

    try:
        text = data.decode("utf-8")
        numbers: dict[str, Any] = (
            {"parse_float": finite, "parse_int": whole} if _LARGE.search(text) else {}
        )
        document = json.loads(text, parse_constant=refuse, object_pairs_hook=unique, **numbers)
        if "\\ud" in text or "\\uD" in text:
            json.dumps(document, ensure_ascii=False).encode()
        return document
    except UnicodeDecodeError as error:
        found = f"byte {data[error.start]:#04x} at offset {error.start}"
        raise InputError("UTF-8 text", found, file=file, row=row) from error
    except UnicodeEncodeError as error:
        found = f"half of a surrogate pair, \\u{ord(error.object[error.start]):04x}"
        raise InputError("text of whole characters", found, file=file, row=row) from error
    except json.JSONDecodeError as error:
        found = f"{error.msg} at line {error.lineno} column {error.colno}"
        raise InputError("a JSON document", found, file=file, row=row) from error
    except RecursionError as error:
        raise InputError(
            "a JSON document", "brackets nested too deep", file=file, row=row
        ) from error
    except ValueError as error:  # an integer with more digits than Python converts
        raise InputError("a JSON document", str(error), file=file, row=row) from error
