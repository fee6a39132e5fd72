"""What can be planned with: a rule file, the answer to a rule problem, a model folder."""

from __future__ import annotations

import os
from pathlib import Path

from demospec.errors import InputError
from demospec.rules import RuleSet, TypeRules

ANYONE = "anyone"
"""Name of the one type of an influence answer, which does not name one."""


def read_plannable(path: str | os.PathLike[str]) -> RuleSet:
    """Rules from a file or folder.

    Accepts a rule file (the JSON of ``rules SET``, or a hand-written part of it), the answer
    of ``rules PROBLEM`` alone (its type is then called ``anyone``), and the folder of a model
    that can say its rules (``field``).

    Raises:
        InputError: None of these, naming file and field.
    """
    from demospec.files import read_json
    from demospec.rules import rules_from_document

    file = Path(path)
    if file.is_dir():
        return _rules_of_model(file)
    document = read_json(file)
    if isinstance(document, dict) and "types" not in document and "hull" in document:
        return RuleSet({ANYONE: TypeRules(influence=document)})
    return rules_from_document(document, file=file)


def _rules_of_model(folder: Path) -> RuleSet:
    from demospec.specification import load_model

    model = load_model(folder)
    if isinstance(model, RuleSet):
        return model
    rules = getattr(model, "rules", None)
    if isinstance(rules, RuleSet):
        return rules
    expected = "a rule file, or a model that can say its rules (field)"
    raise InputError(expected, f"model {type(model).__name__}", file=folder)
