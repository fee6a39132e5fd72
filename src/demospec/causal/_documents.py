"""Findings from their JSON document: what a report reads back."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeVar

from demospec.causal._results import (
    CausalFindings,
    Estimate,
    Placebo,
    Settings,
    SymbolEffect,
    TypeEffect,
)
from demospec.errors import InputError

T = TypeVar("T", Estimate, Placebo, Settings, SymbolEffect)


def findings_from_document(document: dict[str, Any]) -> CausalFindings:
    """The findings that `CausalFindings.to_json` wrote.

    Raises:
        InputError: A field is missing.
    """
    try:
        effects = tuple(_made(SymbolEffect, c) for c in document["effects"])
        return CausalFindings(
            types=tuple(document["base"]),
            symbols=tuple(dict.fromkeys(c.symbol for c in effects)),
            base={t: _made(Estimate, e) for t, e in document["base"].items()},
            effects=effects,
            others=tuple(_made(SymbolEffect, c) for c in document["others"]),
            placebo=tuple(_made(Placebo, p) for p in document["placebo"]),
            type_effects=tuple(_pair(t) for t in document["types"]),
            sentences=tuple(document["sentences"]),
            notes=tuple(document["notes"]),
            skipped=dict(document["skipped"]),
            n_scenes=int(document["n_scenes"]),
            settings=_made(Settings, document["settings"]),
        )
    except KeyError as error:
        raise InputError("a document of `demospec causes --json`", "no such field",
                         field=str(error.args[0])) from error  # fmt: skip


def _pair(document: dict[str, Any]) -> TypeEffect:
    interval = document["interval"]
    return TypeEffect(
        from_type=document["from"],
        to_type=document["to"],
        effect=document["effect"],
        interval=None if interval is None else (interval[0], interval[1]),
        p=document["p"],
        p_corrected=document["p_corrected"],
        differ=document["differ"],
        disagreement=_made(Estimate, document["disagreement"]),
        n_scenes=document["n_scenes"],
    )


def _made(kind: type[T], document: dict[str, Any]) -> T:
    """A dataclass from its fields: lists → tuples, null numbers of no scene → NaN."""
    values = {}
    for field in fields(kind):
        if field.name == "onto" and "onto" not in document:
            continue
        value = document[field.name]
        if isinstance(value, list):
            value = tuple(value)
        elif value is None and field.type == "float":
            value = float("nan")
        values[field.name] = value
    return kind(**values)
