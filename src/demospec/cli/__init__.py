"""The command line: a thin face over functions that a library user can call."""

from demospec.cli._app import main

__all__ = ["main"]
