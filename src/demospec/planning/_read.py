"""What can be planned with: a rule file, the answer to a rule problem, a model folder."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from demospec.errors import InputError
from demospec.files import read_json
from demospec.rules import ClearanceRule, RuleSet, TypeRules


def read_plannable(path: str | os.PathLike[str]) -> RuleSet:
    """Rules from a file or folder.

    Raises:
        InputError: Neither rules nor a model, naming file and field.
    """
    import demospec.rules as rules

    reader = getattr(rules, "read_rules", None)
    if reader is not None:
        read: RuleSet = reader(path)
        return read
    return _hand_written(Path(path), read_json(path))


def _hand_written(path: Path, document: Any) -> RuleSet:
    types = document.get("types") if isinstance(document, dict) else None
    if not isinstance(types, dict) or not types:
        raise InputError("rules per type", document, file=path, field="types")
    rules = {}
    for name, entry in types.items():
        clearance = entry.get("clearance") or {}
        value = {str(k): float(v) for k, v in clearance.get("value", {}).items()}
        interval = {
            str(k): (float(a), float("inf") if b is None else float(b))
            for k, (a, b) in clearance.get("interval", {}).items()
        }
        rules[str(name)] = TypeRules(ClearanceRule(value, interval))
    return RuleSet(rules, metres_per_unit=document.get("metres_per_unit"))
