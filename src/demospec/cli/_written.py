"""What a command may write: nothing that it reads, and nothing that exists without `--force`."""

from __future__ import annotations

import contextlib
import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from demospec.cli._common import Force

OUTPUTS = ("out", "picture", "table", "overlay", "relevant_rules")
"""Parameters of commands that name what is written; every other path is read."""

RESUMED = ("demo", "reproduce", "studio")
"""Commands that go on with what is under their `--out`; each checks that it is its own."""


def keeping(name: str, function: Callable[..., None]) -> Callable[..., None]:
    """The command `name`, in which nothing that it reads or that exists is written over.

    Every place is checked before the work. A command that has no `--force` of its own gets one,
    and writes files only.
    """
    outputs = {"convert": (*OUTPUTS[:1], "set_folder"), "report": ("out",)}.get(name, OUTPUTS)
    known = inspect.signature(function, eval_str=True)
    own = "force" in known.parameters
    makes = [p for p in outputs if p in known.parameters]

    @functools.wraps(function)
    def kept(**arguments: Any) -> None:
        from demospec.files import check_free, reading

        force = arguments["force"] if own else arguments.pop("force", False)
        with reading(_existing(v for k, v in arguments.items() if k not in makes)):
            if name not in RESUMED and not arguments.get("dry_run", False):
                folder = None if own else bool(arguments.get("markdown", False))
                places = _places(arguments, makes)
                check_free(places.values(), replace=force, folder=folder)
            function(**arguments)

    if own or not makes or name in RESUMED:
        return kept
    extra = inspect.Parameter(
        "force", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Force
    )
    kept.__signature__ = known.replace(  # type: ignore[attr-defined]
        parameters=[*known.parameters.values(), extra]
    )
    return kept


def _places(arguments: Mapping[str, Any], makes: Iterable[str]) -> dict[str, Path]:
    """The outputs that were asked for, by parameter."""
    given = {name: arguments.get(name) for name in makes}
    return {name: Path(value) for name, value in given.items() if value is not None}


def _existing(values: Iterable[Any]) -> list[Path]:
    """The files and folders among some arguments, and among lists of them."""
    found = []
    for value in values:
        several = value if isinstance(value, list | tuple) else [value]
        for one in several:
            if isinstance(one, Path) or (isinstance(one, str) and one):
                with contextlib.suppress(OSError, ValueError):
                    if Path(one).exists():
                        found.append(Path(one))
    return found
