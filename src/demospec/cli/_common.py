"""Shared options of the commands, output as JSON or table, progress bars."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from unicodedata import category

import typer
from typer.core import TyperGroup

from demospec.progress import Progress

if TYPE_CHECKING:
    from rich.text import Text

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout.")]
Seed = Annotated[int, typer.Option("--seed", min=0, max=2**31 - 1, help="Random seed.")]
Out = Annotated[Path | None, typer.Option("--out", help="File to write the result to (JSON).")]
OutFolder = Annotated[Path, typer.Option("--out", help="Folder to write.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite an existing output.")]
Workers = Annotated[
    int, typer.Option("--workers", min=1, max=1024, help="Worker processes on this machine.")
]
Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster", metavar="ADDRESS", help="Dask scheduler to use, such as tcp://HOST:8786."
    ),
]
SetFolder = Annotated[Path, typer.Argument(metavar="SET", help="A demonstration set (folder).")]
ModelPath = Annotated[
    Path, typer.Argument(metavar="MODEL", help="A model folder, or a rule file (JSON).")
]
Ruler = Annotated[
    tuple[float, float, float, float, str] | None,
    typer.Option(
        "--ruler",
        metavar="X1 Y1 X2 Y2 LENGTH",
        help="Two points of the picture and how far apart they are, such as 12 80 90 80 30cm.",
    ),
]


def measured(ruler: tuple[float, float, float, float, str]) -> float:
    """Metres per unit, by what --ruler says."""
    from demospec import frames
    from demospec.errors import InputError

    try:
        length = frames.metres_of_words(ruler[4])
        return frames.ruler(ruler[:2], ruler[2:4], length)
    except InputError as error:
        raise error.at(field="--ruler") from error


class FullSentences(TyperGroup):
    """A group whose help has every command's first sentence whole, over several lines if need be.

    (Typer ends it with three dots where the terminal's line ends.)
    """

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        rows = [(n, c.get_short_help_str(10_000)) for n, c in commands if c and not c.hidden]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def one_thread() -> None:
    """Linear algebra on one thread, here and in worker processes; call before NumPy is loaded.

    Arrays here are small: further threads wait for each other. On two busy cores two threads
    took 2.8 times the processor time of one for the repairs of a run.
    """
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    # Worker processes keep the memory of one step for the next: without it a sixth of the time
    # of a fit went into pages given back and asked for again. (Read when a process starts.)
    os.environ.setdefault("MALLOC_MMAP_THRESHOLD_", str(1 << 25))
    os.environ.setdefault("MALLOC_TRIM_THRESHOLD_", str(1 << 32))
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(1)


def print_json(document: object) -> None:
    """One JSON document on stdout, nothing else."""
    from demospec.files import to_json

    text = to_json(document)
    if (sys.stdout.encoding or "utf-8").lower().replace("-", "") != "utf8":
        import json

        text = json.dumps(document, indent=1, allow_nan=False)
    sys.stdout.write(text + "\n")


def save_json(document: object, out: Path | None) -> None:
    """Writes the document where `--out` says, and says so on stderr."""
    if out is not None:
        from demospec.files import write_json

        write_json(out, document)
        say(f"wrote {out}")


def plain(text: str) -> str:
    """Text of which no part is a command to the terminal, whatever names are in it."""
    if text.isprintable():
        return text
    return "".join(c if category(c)[0] != "C" or c == "\n" else "?" for c in text)


def spelt(text: str) -> Text:
    """`plain` text for a table."""
    from rich.text import Text

    return Text(plain(text))


def say(message: str) -> None:
    """A message for the person: stderr, so that stdout stays data."""
    sys.stderr.write(plain(message) + "\n")


def show(text: object) -> None:
    """Text of the answer: stdout."""
    sys.stdout.write(plain(str(text)) + "\n")


def print_table(
    title: str, header: Sequence[str], rows: Sequence[Sequence[Any]], note: str = ""
) -> None:
    """A table on stdout, numbers right-aligned; without rows only title and note."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, show_header=any(header))
    for i, name in enumerate(header):
        numeric = all(isinstance(row[i], (int, float)) for row in rows) and bool(rows)
        table.add_column(spelt(name), justify="right" if numeric else "left")
    for row in rows:
        table.add_row(*[spelt(_cell(value)) for value in row])
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    if title:  # not the table's own title, which would wrap at the table's width
        console.print(spelt(title))
    if rows:
        console.print(table)
    if note:
        console.print(spelt(note))


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


@contextmanager
def progress_bar(after_s: float = 2.0) -> Iterator[Progress]:
    """Progress bars on stderr for stages that last; shown once `after_s` seconds have passed."""
    shown = _Bars(after_s)
    try:
        yield shown
        shown.finish()
    finally:
        shown.close()


@contextmanager
def goes_on(out: Path) -> Iterator[None]:
    """Says on Ctrl-C that the same command takes a run up again where it was."""
    try:
        yield
    except KeyboardInterrupt:
        if out.is_dir():
            say(f"{out} keeps what is done: the same command goes on from there")
        raise


class _Bars:
    def __init__(self, after_s: float) -> None:
        self.after_s = after_s
        self.began = time.monotonic()
        self.bars: Any = None
        self.tasks: dict[str, Any] = {}

    def __call__(self, what: str, done: float, total: float) -> None:
        if self.bars is None:
            if time.monotonic() - self.began < self.after_s:
                return
            self._open()
        if what not in self.tasks:
            self.tasks[what] = self.bars.add_task(what, total=total)
        self.bars.update(self.tasks[what], completed=done, total=total)

    def _open(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
        from rich.progress import TimeRemainingColumn as Remaining

        self.bars = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f}%"),
            TimeElapsedColumn(),
            Remaining(),
            console=Console(stderr=True),
            speed_estimate_period=300.0,  # steps of a long run may be a minute apart
        )
        self.bars.start()

    def finish(self) -> None:
        """The work is done: also stages that ended before their last step was told."""
        for task in self.tasks.values():
            total = next(t.total for t in self.bars.tasks if t.id == task)
            self.bars.update(task, completed=total)

    def close(self) -> None:
        if self.bars is not None:
            self.bars.stop()
