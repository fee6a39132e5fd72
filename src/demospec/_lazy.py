"""Public names of a package that load their module on first use."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def names_of(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """A ``__getattr__`` for `package`: each public name is taken from its module on first use.

    Args:
        package: ``__name__`` of the package.
        homes: Public name → module, relative to the package (``influence._solve``) or absolute
            (``demospec.geometry``); ``module:name`` where the name in the module is another,
            ``module:`` for the module itself.
    """

    def getattribute(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, inner = homes[name].partition(":")
        whole = homes[name].endswith(":")
        path = module if module.startswith("demospec.") else f"{package}.{module}"
        found = importlib.import_module(path)
        return found if whole else getattr(found, inner or name)

    return getattribute
