"""An ensemble in one model folder: the members' arrays under their numbers, equal ones once."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError
from demospec.specification.models._folder import (
    ModelFolder,
    ModelWeights,
    read_model_folder,
    write_model_folder,
)
from demospec.specification.models._single import FittedModel


def write_members(
    folder: str | os.PathLike[str],
    members: Sequence[FittedModel],
    *,
    kind: str,
    types: tuple[str, ...],
    provenance: Mapping[str, Any],
    replace: bool = False,
) -> Path:
    """Writes the members as one model folder, whole or not at all."""
    stored = [_as_folder(member) for member in members]
    first = stored[0].weights
    weights: ModelWeights = {}
    for k, member in enumerate(stored):
        for name, array in member.weights.items():
            # What every member has alike (the field model's network, where it is not tuned) is
            # kept with the first.
            if k == 0 or name not in first or not np.array_equal(first[name], array):
                weights[f"{k}.{name}"] = array
    settings = {
        "members": [
            {"kind": m.kind, "settings": dict(m.settings), "arrays": sorted(m.weights)}
            for m in stored
        ]
    }
    return write_model_folder(
        folder, kind=kind, types=types, settings=settings, weights=weights,
        provenance={**provenance, "members": [dict(m.provenance) for m in stored]},
        replace=replace,
    )  # fmt: skip


def _as_folder(member: FittedModel) -> ModelFolder:
    # Every kind can write itself, and only that: what it wrote is read back.
    with tempfile.TemporaryDirectory() as place:
        return read_model_folder(member.save(Path(place) / "member"))


def read_members(stored: ModelFolder) -> Iterator[ModelFolder]:
    """The members of an ensemble's folder, each as if it had a folder of its own.

    Raises:
        InputError: Naming what is missing.
    """
    file = None if stored.path is None else stored.path / "config.json"
    members = stored.settings.get("members")
    if not isinstance(members, list) or len(members) < 2:
        raise InputError("a list of two or more members", members, file=file, field="members")
    told = stored.provenance.get("members")
    provenance = (
        told if isinstance(told, list) and len(told) == len(members) else [{}] * len(members)
    )
    for k, member in enumerate(members):
        field = f"settings.members.{k}"
        if not isinstance(member, dict):
            raise InputError("an object", member, file=file, field=field)
        kind, settings, names = (member.get(key) for key in ("kind", "settings", "arrays"))
        if not isinstance(kind, str) or kind == stored.kind:
            raise InputError("paper, field or irl", kind, file=file, field=f"{field}.kind")
        if not isinstance(settings, dict):
            raise InputError("an object", settings, file=file, field=f"{field}.settings")
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise InputError("names of arrays", names, file=file, field=f"{field}.arrays")
        about = provenance[k] if isinstance(provenance[k], dict) else {}
        weights = {name: _array(stored, k, name) for name in names}
        yield replace(stored, kind=kind, settings=settings, weights=weights, provenance=about)


def _array(stored: ModelFolder, member: int, name: str) -> Any:
    for owner in (member, 0):
        if f"{owner}.{name}" in stored.weights:
            return stored.weights[f"{owner}.{name}"]
    file = None if stored.path is None else stored.path / "weights.safetensors"
    raise InputError("an array of that name", "none", file=file, field=f"{member}.{name}")
