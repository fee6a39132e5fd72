"""demospec turns demonstrations into specifications that people can read, check and plan with.

``import demospec`` is light: rooms load on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.causal import find_causes
    from demospec.demonstrations import DemonstrationSet, read_set, simulate_set, write_set
    from demospec.errors import DemospecError, InputError
    from demospec.planning import plan_path
    from demospec.rules import learn_rules, read_rules
    from demospec.specification import fit_model, load_model

_HOME = {
    "DemonstrationSet": "demospec.demonstrations",
    "DemospecError": "demospec.errors",
    "InputError": "demospec.errors",
    "find_causes": "demospec.causal",
    "fit_model": "demospec.specification",
    "learn_rules": "demospec.rules",
    "load_model": "demospec.specification",
    "plan_path": "demospec.planning",
    "read_rules": "demospec.rules",
    "read_set": "demospec.demonstrations",
    "simulate_set": "demospec.demonstrations",
    "write_set": "demospec.demonstrations",
}

__all__ = [
    "DemonstrationSet",
    "DemospecError",
    "InputError",
    "find_causes",
    "fit_model",
    "learn_rules",
    "load_model",
    "plan_path",
    "read_rules",
    "read_set",
    "simulate_set",
    "write_set",
]


__getattr__ = names_of(__name__, _HOME)


def __dir__() -> list[str]:
    return sorted(__all__)
