"""`CausalFindings` from the JSON document that `CausalFindings.to_json` makes."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from demospec.causal._results import (
    CausalFindings,
    DosePoint,
    DoseResponse,
    Estimate,
    Placebo,
    Settings,
    SymbolEffect,
    TypeEffect,
)
from demospec.errors import InputError
from demospec.rules import fit_from_json


def findings_from_document(document: dict[str, Any]) -> CausalFindings:
    """The findings of a document of ``demospec causes --json``.

    Raises:
        InputError: A field is missing or of another form.
    """
    try:
        effects = tuple(_of(SymbolEffect, e) for e in document["effects"])
        return CausalFindings(
            types=tuple(document["base"]),
            symbols=tuple(dict.fromkeys(e.symbol for e in effects)),
            base={t: _of(Estimate, e) for t, e in document["base"].items()},
            effects=effects,
            others=tuple(_of(SymbolEffect, e) for e in document["others"]),
            placebo=tuple(_of(Placebo, p) for p in document["placebo"]),
            type_effects=tuple(
                _of(
                    TypeEffect,
                    {
                        **t,
                        "from_type": t["from"],
                        "to_type": t["to"],
                        "disagreement": _of(Estimate, t["disagreement"]),
                    },
                )
                for t in document["types"]
            ),
            sentences=tuple(document["sentences"]),
            notes=tuple(document["notes"]),
            skipped=dict(document["skipped"]),
            n_scenes=document["n_scenes"],
            settings=_of(Settings, document["settings"]),
            unrelated=tuple(_of(Placebo, p) for p in document.get("unrelated", ())),
            dose=tuple(
                DoseResponse(
                    curve["type"],
                    curve["symbol"],
                    tuple(_of(DosePoint, point) for point in curve["points"]),
                )
                for curve in document.get("dose_response", ())
            ),
            labels={
                name: fit_from_json(fit, f"labels.{name}")
                for name, fit in document.get("labels", {}).items()
            },
        )
    except (KeyError, TypeError, AttributeError) as error:
        found = f"{type(error).__name__} {error}"
        raise InputError("a document of `demospec causes`", found) from error


def _of(kind: Any, document: dict[str, Any]) -> Any:
    """A results class from its fields; lists become tuples, null effects NaN."""
    given: dict[str, Any] = {}
    for field in fields(kind):
        if field.name not in document:
            continue
        value = document[field.name]
        if isinstance(value, list):
            value = tuple(value)
        if value is None and field.type == "float":
            value = float("nan")
        given[field.name] = value
    return kind(**given)
