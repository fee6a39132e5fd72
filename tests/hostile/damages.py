"""Damages to documents, tables and files, and the judgement of what a command made of them."""

from __future__ import annotations

import copy
import json
import os
import resource
import shutil
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from demospec.cli import main

Damage = Callable[[Path], None]
"""Harms one thing in the folder that a command is about to work in."""


class Raw(str):
    """JSON text that stands in the document as it is."""


VALUES: dict[str, Any] = {
    "null": None,
    "true": True,
    "zero": 0,
    "minus one": -1,
    "a half": 0.5,
    "1e308": 1e308,
    "-1e308": -1e308,
    "1e400": Raw("1e400"),
    "NaN": Raw("NaN"),
    "2^70": 2**70,
    "10^400": Raw("1" + "0" * 400),
    "-2^63": -(2**63),
    "empty text": "",
    "a number as text": "3",
    "surrogate": "\ud800",
    "escape": "\x1b[2J\x07\r",
    "NUL": "a\x00b",
    "long text": "x" * 5000,
    "up and away": "../../x",
    "markup": "<script>alert(1)</script>",
    "empty list": [],
    "list of lists": [[[]]],
    "list of texts": ["a", "a"],
    "list of numbers": [1e308, -1e308, 0],
    "empty object": {},
    "object": {"a": {"b": None}},
}


def places(document: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every key and index of a document; of a long list the first two."""
    yield at
    if isinstance(document, dict):
        for key, value in document.items():
            yield from places(value, (*at, key))
    elif isinstance(document, list):
        for i, value in enumerate(document[:2]):
            yield from places(value, (*at, i))


def text_of(document: Any) -> str:
    """JSON text with `Raw` parts as they are."""
    raw: list[str] = []

    def marked(value: Any) -> Any:
        if isinstance(value, Raw):
            raw.append(str(value))
            return f"@raw{len(raw) - 1}@"
        if isinstance(value, dict):
            return {key: marked(v) for key, v in value.items()}
        return [marked(v) for v in value] if isinstance(value, list) else value

    text = json.dumps(marked(document))
    for i, part in enumerate(raw):
        text = text.replace(f'"@raw{i}@"', part)
    return text


def changed(document: Any, at: tuple[Any, ...], value: Any) -> Any:
    """A copy with another value at a place."""
    if not at:
        return value
    copied = copy.deepcopy(document)
    inner = copied
    for step in at[:-1]:
        inner = inner[step]
    inner[at[-1]] = value
    return copied


def without(document: Any, at: tuple[Any, ...]) -> Any:
    """A copy without a key or an item."""
    copied = copy.deepcopy(document)
    inner = copied
    for step in at[:-1]:
        inner = inner[step]
    del inner[at[-1]]
    return copied


def document_damages(document: Any) -> Iterator[tuple[str, str]]:
    """Name and JSON text of every damaged version of a document."""
    for at in places(document):
        where = ".".join(map(str, at)) or "all"
        for name, value in VALUES.items():
            yield f"{where} = {name}", text_of(changed(document, at, value))
        if at:
            yield f"{where} gone", text_of(without(document, at))
        if at and isinstance(at[-1], str):
            for name, key in (("surrogate", "\udfff"), ("escape", "\x1b[1m"), ("long", "k" * 2000)):
                inner = document
                for step in at:
                    inner = inner[step]
                renamed = changed(without(document, at), (*at[:-1], key), inner)
                yield f"{where} renamed to {name}", text_of(renamed)
    if isinstance(document, dict) and document:
        key = next(iter(document))
        body = text_of(document)
        yield "a key twice", "{" + f"{json.dumps(key)}: null, " + body[1:]
    body = text_of(document)
    yield "half of it", body[: len(body) // 2]
    yield "nested deep", "[" * 100_000
    yield "nothing", ""


def json_file(name: str, document: Any) -> Iterator[tuple[str, Damage]]:
    """Damages of one JSON file of a folder."""
    for what, text in document_damages(document):

        def write(root: Path, text: str = text) -> None:
            (root / name).write_text(text, encoding="utf-8", errors="surrogatepass")

        yield f"{name}: {what}", write


def first_line(name: str) -> Callable[[Any], Iterator[tuple[str, Damage]]]:
    """Damages of the first line of a file of JSON lines."""

    def damages(document: Any) -> Iterator[tuple[str, Damage]]:
        for what, text in document_damages(document):

            def write(root: Path, text: str = text) -> None:
                lines = (root / name).read_text(encoding="utf-8").splitlines()
                lines[0] = text
                (root / name).write_text("\n".join(lines) + "\n", encoding="utf-8")

            yield f"{name}, line 1: {what}", write

    return damages


def file_damages(name: str) -> Iterator[tuple[str, Damage]]:
    """Damages of the bytes of any file, and of what stands in its place."""

    def bytes_of(change: Callable[[bytes], bytes]) -> Damage:
        return lambda root: (root / name).write_bytes(change((root / name).read_bytes())) and None

    for share in (0.0, 0.3, 0.9):
        yield f"{name}: cut at {share}", bytes_of(lambda b, s=share: b[: int(len(b) * s)])
    for at in (0.0, 0.25, 0.5, 0.75, 0.99):

        def flip(b: bytes, at: float = at) -> bytes:
            i = int(len(b) * at)
            return b[:i] + bytes([b[i] ^ 0xFF]) + b[i + 1 :]

        yield f"{name}: a byte flipped at {at}", bytes_of(flip)
    yield f"{name}: zeros", bytes_of(lambda b: bytes(len(b)))
    yield f"{name}: UTF-16", bytes_of(lambda b: b.decode("latin1").encode("utf-16"))

    def folder(root: Path) -> None:
        (root / name).unlink()
        (root / name).mkdir()

    def pipe(root: Path) -> None:
        (root / name).unlink()
        os.mkfifo(root / name)

    def loop(root: Path) -> None:
        (root / name).unlink()
        (root / name).symlink_to((root / name).name)

    yield f"{name}: a folder", folder
    yield f"{name}: a pipe", pipe
    yield f"{name}: a link to itself", loop
    yield f"{name}: gone", lambda root: (root / name).unlink()


@dataclass(frozen=True)
class Case:
    """One damaged situation and the command that meets it."""

    name: str
    damage: Damage
    arguments: tuple[str, ...]
    source: Path
    """Folder that is copied for it."""


class TooLong(BaseException):
    """More than ten seconds of this process's time."""


def fault_of(case: Case, room: Path, capsys: pytest.CaptureFixture[str]) -> str | None:
    """What is wrong with how the command took the case; None where nothing is."""
    shutil.rmtree(room, ignore_errors=True)
    shutil.copytree(case.source, room)
    os.chdir(room)
    case.damage(room)
    before = digest(room)
    capsys.readouterr()

    def stop(*_: object) -> None:
        raise TooLong

    old = signal.signal(signal.SIGVTALRM, stop)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size + (1 << 30), limits[1]))
    signal.setitimer(signal.ITIMER_VIRTUAL, 10)
    code: object
    try:
        main(list(case.arguments))
    except SystemExit as ended:
        code = ended.code or 0
    except TooLong:
        return f"{case.name}: over ten seconds"
    except BaseException as error:
        return f"{case.name}: raised {type(error).__name__}: {error}"
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, old)
        resource.setrlimit(resource.RLIMIT_AS, limits)
    out, err = capsys.readouterr()
    if case.name == "undamaged" and code != 0:
        return f"{' '.join(case.arguments)}: {err[-300:]}"
    fault = _words(code, out, err) or _files(code, before, digest(room))
    return None if fault is None else f"{case.name} [{' '.join(case.arguments)[:90]}]: {fault}"


def _words(code: object, out: str, err: str) -> str | None:
    if code not in (0, 2):
        return f"exit {code}: {err.strip()[-300:]}"
    said = err.splitlines()
    if code == 2 and (not said or not said[-1].startswith("demospec: ")):
        return f"no one line: {err[-200:]!r}"
    if code == 2 and len(said[-1]) < 25:
        return f"says nothing: {said[-1]!r}"
    if any(ord(c) < 32 and c not in "\n\t" for c in out + err):
        return f"a control character: {(out + err)[-200:]!r}"
    if code == 0 and out.startswith("{"):
        try:
            json.loads(out, parse_constant=lambda c: 1 / 0)
        except (ValueError, ZeroDivisionError):
            return "its JSON is none"
    return None


def _files(code: object, before: dict[str, bytes], after: dict[str, bytes]) -> str | None:
    for name, content in before.items():
        if after.get(name) != content:
            return f"changed {name}"
    new = [name for name in after if name not in before]
    if code == 2 and new:
        return f"left {', '.join(new[:3])}"
    if any(part.startswith(".") for name in new for part in name.split("/")):
        return f"litter: {', '.join(new[:3])}"
    return None


def digest(root: Path) -> dict[str, bytes]:
    """The content of every file under a folder."""
    files = sorted(p for p in root.rglob("*") if p.is_file() or p.is_fifo() or p.is_symlink())
    return {str(p.relative_to(root)): p.read_bytes() if p.is_file() else b"no file" for p in files}
