"""Writing an edited set with the record of where it came from."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._store import PARQUET, write_set
from demospec.errors import InputError
from demospec.files import read_json


def write_edited(
    data: DemonstrationSet,
    folder: str | os.PathLike[str],
    *,
    operation: str,
    arguments: Mapping[str, Any],
    inputs: Sequence[str | os.PathLike[str]],
    keep_truth: bool = False,
    replace_existing: bool = False,
) -> Path:
    """Writes an edited set with ``provenance.json``: the operation, its arguments, its inputs.

    Args:
        data: What to write.
        folder: A new folder, outside every input.
        inputs: The sets it was made from; their digests and their own provenance are recorded.
        keep_truth: Copy the first input's ``truth.json`` (a rule that the operation leaves true).

    Raises:
        InputError: `folder` is one of the inputs or lies in one.
        OutputError: It exists, or cannot be written.
    """
    refuse_inside(inputs, folder)
    documents = {"provenance.json": provenance(data, operation, arguments, inputs)}
    truth = Path(inputs[0]) / "truth.json"
    if keep_truth and truth.is_file():
        documents["truth.json"] = read_json(truth)
    return write_set(data, folder, replace_existing=replace_existing, documents=documents)


def provenance(
    data: DemonstrationSet,
    operation: str,
    arguments: Mapping[str, Any],
    inputs: Sequence[str | os.PathLike[str]],
) -> dict[str, Any]:
    """The record of an edit."""
    return {
        "operation": operation,
        "arguments": dict(arguments),
        "demospec": version("demospec"),
        "inputs": [_input(Path(i)) for i in inputs],
        "scenes": len(data.scenes),
        "demonstrations": len(data.demonstrations),
    }


def refuse_inside(inputs: Sequence[str | os.PathLike[str]], folder: str | os.PathLike[str]) -> None:
    """InputError where writing `folder` would change one of the inputs."""
    target = Path(os.path.realpath(folder))
    for path in inputs:
        source = Path(os.path.realpath(path))
        if target == source or source in target.parents or target in source.parents:
            raise InputError("a place outside the input", "a place in it", file=target)


def _input(root: Path) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": root.name, "sha256": {}}
    for name in ("dataset.json", "scenes/metadata.jsonl", PARQUET):
        with open(root / name, "rb") as stream:
            entry["sha256"][name] = hashlib.file_digest(stream, "sha256").hexdigest()
    if (root / "provenance.json").is_file():
        entry["provenance"] = read_json(root / "provenance.json")
    return entry
