"""The `demospec` command: its subcommands, and what every error turns into.

Exit status: 0 success, 2 bad input or a missing extra (one line on stderr), 1 our own failure,
130 on Ctrl-C.
"""

from __future__ import annotations

import importlib
import inspect
import io
import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer

from demospec.cli._common import FullSentences, say
from demospec.cli._groups import COMMANDS, GROUPS, epilog
from demospec.cli._written import keeping
from demospec.errors import DemospecError


def build_app(names: Sequence[str] = COMMANDS) -> typer.Typer:
    """The Typer application with the commands `names`."""
    app = typer.Typer(
        name="demospec",
        cls=Grouped,
        help="Turn robot demonstrations into specifications that people can read, check and "
        "plan with.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    for name in names:
        function = name.replace("-", "_")
        module = importlib.import_module(f"demospec.cli._{function}")
        register = getattr(module, "register", None)
        if register is not None:  # a command with subcommands
            register(app, epilog(name))
        else:
            command = keeping(name, getattr(module, function))
            app.command(name, epilog=epilog(name))(_with_seed(command))

    @app.callback(invoke_without_command=True)
    def version(
        version: bool = typer.Option(False, "--version", help="Print the version and stop."),
    ) -> None:
        if version:
            from importlib.metadata import version as installed

            typer.echo(f"demospec {installed('demospec')}")
            raise typer.Exit()

    return app


class Grouped(FullSentences):
    """The commands under the titles of `GROUPS`, in their order."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        width = max(len(name) for name in COMMANDS)
        with formatter.section("Commands"):
            for title, names in GROUPS:
                known = [(name, self.get_command(ctx, name)) for name in names]
                rows = [(n.ljust(width), c.get_short_help_str(10_000)) for n, c in known if c]
                with formatter.section(title):
                    formatter.write_dl(rows)


def _with_seed(function: Callable[..., None]) -> Callable[..., None]:
    """The command with a hidden `--seed`: a script may pass one to every command."""
    signature = inspect.signature(function, eval_str=True)
    if "seed" in signature.parameters:
        return function

    def seeded(seed: int, **arguments: Any) -> None:
        function(**arguments)

    option = typer.Option("--seed", min=0, hidden=True, help="No effect: nothing here is random.")
    extra = inspect.Parameter(
        "seed", inspect.Parameter.KEYWORD_ONLY, default=0, annotation=Annotated[int, option]
    )
    seeded.__doc__ = function.__doc__
    seeded.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[*signature.parameters.values(), extra]
    )
    return seeded


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; the console entry point."""
    # Before it builds a schema, pydantic reads the entry points of every installed package for
    # plugins, of which we have none.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    _write_what_can_be()
    given = sys.argv[1:] if arguments is None else arguments
    # One command needs no other: to describe them all to Typer takes longer than to parse.
    names = given[:1] if given and given[0] in COMMANDS else COMMANDS
    try:
        status = build_app(names)(args=arguments, standalone_mode=False)
        raise SystemExit(status if isinstance(status, int) else 0)
    except SystemExit as ended:
        if ended.code == 130:  # newer versions of Typer catch Ctrl-C, and say nothing
            _say("stopped")
        raise
    except KeyboardInterrupt:
        _say("stopped")
        raise SystemExit(130) from None
    except DemospecError as error:
        _say(str(error))
        raise SystemExit(2) from None
    except BrokenPipeError:
        # Whoever read our output closed it (`demospec … | head`): nothing is wrong.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        raise SystemExit(0) from None
    except UnicodeEncodeError as error:
        if not any(_broken(word) for word in given):
            _usage_or_failure(error)
        _say("expected arguments in UTF-8, found " + next(filter(_broken, given)))
        raise SystemExit(2) from None
    except OSError as error:  # what the system refuses is no mistake of ours
        if os.environ.get("DEMOSPEC_TRACEBACK"):
            raise
        _say(f"{error.filename or 'the system'}: {error.strerror or error}")
        raise SystemExit(2) from None
    except Exception as error:
        _usage_or_failure(error)


def _broken(word: str) -> bool:
    """Whether an argument holds bytes that are no UTF-8."""
    return any("\ud800" <= c <= "\udfff" for c in word)


def _write_what_can_be() -> None:
    """No letter that the terminal lacks, and no stream that is closed, ends a command."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, io.StringIO())
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


def _usage_or_failure(error: Exception) -> None:
    # Typer carries its own copy of click in newer versions: ask the exception, not its class.
    if type(error).__name__ == "Abort":
        _say("stopped")
        raise SystemExit(130) from None
    message = getattr(error, "format_message", None)
    if message is not None:
        _say(" ".join(str(message()).split()))
        raise SystemExit(int(getattr(error, "exit_code", 2))) from None
    if os.environ.get("DEMOSPEC_TRACEBACK"):
        raise error
    _say(
        f"internal failure: {type(error).__name__}: {error} "
        "(this is our mistake; set DEMOSPEC_TRACEBACK=1 to see where)"
    )
    raise SystemExit(1) from None


def _say(message: str) -> None:
    say("demospec: " + " ".join(message.splitlines()))
