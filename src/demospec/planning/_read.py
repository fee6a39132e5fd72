"""What can be planned with: a rule file, the answer to a rule problem, a model folder."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.planning._constraint import Plannable
from demospec.planning._seen import SeeingModel
from demospec.rules import RuleSet, TypeRules

ANYONE = "anyone"
"""Name of the one type of an influence answer, which does not name one."""


def read_plannable(path: str | os.PathLike[str], data: DemonstrationSet | None = None) -> Plannable:
    """Rules from a file or folder.

    Accepts a rule file (the JSON of ``rules SET``, or a hand-written part of it), the answer
    of ``rules PROBLEM`` alone, of either family (its type is then called ``anyone``), and the
    folder of a model that can say its rules (``field``).

    Args:
        path: File or folder.
        data: The set that is planned in. Pixels are its own, so its scale counts, even where
            it says none; without a set the file's scale does.

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
        if isinstance(document, dict) and "types" not in document:
            document = _of_anyone(document, file)
        if not isinstance(document, RuleSet):
            document = rules_from_document(document, file=file)
        read = document
    if data is None:
        return read
    if isinstance(read, RuleSet):
        return replace(read, metres_per_unit=data.metres_per_unit)
    read.metres_per_unit = data.metres_per_unit  # type: ignore[attr-defined]
    return read


def _of_anyone(document: dict[str, Any], file: Path) -> dict[str, Any] | RuleSet:
    """The answer of ``rules PROBLEM`` as a rule of one type; other documents as they are."""
    if document.get("family") == "clearance" and "value" in document:
        settings = document.get("settings")
        distance = settings.get("distance") if isinstance(settings, dict) else None
        rule = {**document, "distance": distance or "footprint"}
        return {"types": {ANYONE: {"clearance": rule}}}
    if "hull" not in document:
        return document
    if document.get("status") == "infeasible":
        expected = "an answer to plan with (its `conflict` says why there is none)"
        raise InputError(expected, "infeasible", file=file, field="status")
    if "settings" in document:
        return {"types": {ANYONE: {"influence": document}}}
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
