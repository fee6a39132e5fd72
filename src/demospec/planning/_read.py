"""What can be planned with: a rule file, the answer to a rule problem, a model folder."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.planning._constraint import Plannable
from demospec.planning._seen import SeeingModel
from demospec.rules import ANYONE, RuleSet, TypeRules, rules_for_set


def read_plannable(path: str | os.PathLike[str], data: DemonstrationSet | None = None) -> Plannable:
    """Rules from a file or folder.

    Accepts a rule file (the JSON of ``rules SET``, or a hand-written part of it), the answer
    of ``rules PROBLEM`` alone, of either family (its type is then called ``anyone``), and the
    folder of a model that can say its rules (``field``).

    Args:
        path: File or folder.
        data: The set that is planned in: rules are brought to its unit and scale
            (`rules_for_set`). Without a set the file's unit counts.

    Raises:
        InputError: None of these, naming file and field.
    """
    from demospec.files import read_json
    from demospec.rules import rules_from_document

    file = Path(path)
    read: Plannable
    if file.is_dir():
        read = _model(file)
    else:
        document = read_json(file)
        read = _without_settings(document, file) or rules_from_document(document, file=file)
    if data is None:
        return read
    if isinstance(read, RuleSet):
        try:
            return rules_for_set(read, data)
        except InputError as error:
            raise error.at(file=file) from error
    read.metres_per_unit = data.metres_per_unit  # type: ignore[attr-defined]
    return read


def _without_settings(document: Any, file: Path) -> RuleSet | None:
    """An influence answer that says its hull alone: too little to judge by, not to keep out of.

    None for other documents.
    """
    if not isinstance(document, dict) or "hull" not in document or "settings" in document:
        return None
    if "types" in document or document.get("status") == "infeasible":
        return None
    hull = document["hull"]
    if not isinstance(hull, dict) or not {"T_min", "radius"} <= hull.keys():
        raise InputError("T_min and radius", hull, file=file, field="hull")
    return RuleSet({ANYONE: TypeRules(influence=document)})


def _model(folder: Path) -> Plannable:
    from demospec.specification import load_model

    model = load_model(folder)
    if isinstance(model, (RuleSet, SeeingModel)):
        return model
    expected = "a rule file, or a model that can say its rules (field)"
    raise InputError(expected, f"model {type(model).__name__}", file=folder)
