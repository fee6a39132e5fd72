"""What can be planned with: a rule file, the answer to a rule problem, a model folder."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from demospec.errors import InputError
from demospec.planning._constraint import Plannable
from demospec.planning._seen import SeeingModel
from demospec.rules import RuleSet, TypeRules

ANYONE = "anyone"
"""Name of the one type of an influence answer, which does not name one."""


def read_plannable(path: str | os.PathLike[str], metres_per_unit: float | None = None) -> Plannable:
    """Rules from a file or folder.

    Accepts a rule file (the JSON of ``rules SET``, or a hand-written part of it), the answer
    of ``rules PROBLEM`` alone (its type is then called ``anyone``), and the folder of a model
    that can say its rules (``field``).

    Args:
        path: File or folder.
        metres_per_unit: The scale of the set that is planned in; by default the file's own.

    Raises:
        InputError: None of these, naming file and field.
    """
    from demospec.files import read_json
    from demospec.rules import rules_from_document

    file = Path(path)
    if file.is_dir():
        return _model(file, metres_per_unit)
    document = read_json(file)
    if isinstance(document, dict) and "types" not in document and "hull" in document:
        return RuleSet({ANYONE: TypeRules(influence=document)}, metres_per_unit=metres_per_unit)
    read = rules_from_document(document, file=file)
    return read if metres_per_unit is None else replace(read, metres_per_unit=metres_per_unit)


def _model(folder: Path, metres_per_unit: float | None) -> Plannable:
    from demospec.specification import load_model

    model = load_model(folder)
    if isinstance(model, RuleSet):
        return model if metres_per_unit is None else replace(model, metres_per_unit=metres_per_unit)
    if not isinstance(model, SeeingModel):
        expected = "a rule file, or a model that can say its rules (field)"
        raise InputError(expected, f"model {type(model).__name__}", file=folder)
    if metres_per_unit is not None:
        model.metres_per_unit = metres_per_unit  # type: ignore[attr-defined]
    return model
