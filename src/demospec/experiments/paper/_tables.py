"""The numbers of a reproduction as CSV: one file a table, and one with all in long form."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from demospec.experiments.paper._beside import beside_rows
from demospec.files import read_json, writing_file

Row = Sequence[Any]


def write_tables(folder: Path) -> None:
    """Writes accuracy, repair, causal, parameter and plan tables, and ``results.csv``."""
    long: list[Row] = []
    for name, header, rows in _tables(folder):
        kept = [list(row) for row in rows]
        _write(folder / f"{name}.csv", header, kept)
        keys = [i for i, h in enumerate(header) if not h.startswith("=")]
        for row in kept:
            about = "; ".join(f"{header[i]} {row[i]}" for i in keys)
            long += [(name, about, h[1:], row[i]) for i, h in enumerate(header) if h[0] == "="]
    _write(folder / "results.csv", ("table", "row", "quantity", "value"), long)


def _write(path: Path, header: Sequence[str], rows: Iterable[Row]) -> None:
    with (
        writing_file(path) as temporary,
        temporary.open("w", newline="", encoding="utf-8") as stream,
    ):
        writer = csv.writer(stream)
        writer.writerow([h.removeprefix("=") for h in header])
        writer.writerows(["" if v is None else v for v in row] for row in rows)


def _tables(folder: Path) -> Iterable[tuple[str, tuple[str, ...], Iterable[Row]]]:
    """Name, header (measured quantities marked with ``=``) and rows."""
    for reading in ("uniform", "clustered"):
        rows = read_json(folder / f"accuracy-{reading}.json")["rows"]
        measured = (
            "accuracy_seen", "majority_seen", "bacc_seen", "bacc_seen_far",
            "accuracy_unseen", "majority_unseen", "bacc_unseen", "bacc_unseen_far",
        )  # fmt: skip
        header = ("model", "n", "type", "fits", *(f"={m}" for m in measured))
        yield (
            f"accuracy-{reading}",
            header,
            ([r[h.removeprefix("=")] for h in header] for r in rows),
        )
    yield (
        "beside-the-paper",
        ("quantity", "paper", "=here", "=verdict"),
        ([r.what, r.printed, r.ours, r.verdict] for r in beside_rows(folder)),
    )
    repairs = read_json(folder / "repairs.json")
    yield (
        "repairs",
        (
            "model",
            "particles",
            "type",
            "n",
            "=repaired_by_truth",
            "=accepted_by_model",
            "=moved_px",
        ),
        (
            [m, k, t, v["n"], v["repaired_by_truth"], v["accepted_by_model"], v["moved_px"]]
            for m, by in repairs.items()
            for k, types in by.items()
            for t, v in types.items()
        ),
    )
    causes = read_json(folder / "causes.json")
    yield (
        "causes",
        ("model", "type", "symbol", "=effect", "=low", "=high", "=p_corrected", "=causal"),
        (
            [m, e["type"], e["symbol"], e["effect"], *(e["interval"] or (None, None)),
             e["p_corrected"], e["causal"]]
            for m, found in causes.items()
            for e in found["effects"]
        ),
    )  # fmt: skip
    yield (
        "types",
        ("model", "from", "to", "=effect", "=low", "=high", "=p_corrected", "=differ"),
        (
            [m, e["from"], e["to"], e["effect"], *(e["interval"] or (None, None)),
             e["p_corrected"], e["differ"]]
            for m, found in causes.items()
            for e in found["types"]
        ),
    )  # fmt: skip
    yield (
        "boundaries",
        ("model", "type", "symbol", "to_type", "scenes", "=lost", "=gained", "=distance_px"),
        (
            [m, b["type"], b.get("symbol"), b.get("to"), b["n_scenes"], b["lost"], b["gained"],
             b["distance"]]
            for m, found in causes.items()
            for b in found["boundaries"]
        ),
    )  # fmt: skip
    yield (
        "causation",
        ("model", "type", "symbol", "probability", "=low", "=high"),
        (
            [m, c["type"], c["symbol"], name, *(c[name] or (None, None))]
            for m, found in causes.items()
            for c in found["causation"]
            for name in ("necessity", "sufficiency", "both")
        ),
    )
    solutions = read_json(folder / "solutions.json")
    yield (
        "identification",
        ("model", "way", "k", "=found"),
        (
            [m, way, k, v]
            for m, found in solutions.items()
            for way in ("accepted", "labelled", "printed")
            for k, v in zip(found["identification"]["k"], found["identification"][way], strict=True)
        ),
    )
    yield (
        "solutions",
        ("model", "type", "=n", "=valid_by_truth", "=diversity_px", "=regions"),
        (
            [m, t, v["n"], v["valid_by_truth"], v["diversity"], v["regions"]]
            for m, found in solutions.items()
            for t, v in found["samples"].items()
        ),
    )
    yield (
        "overlap",
        ("model", "one", "other", "scenes", "=overlap", "=low", "=high"),
        (
            [m, *p["types"], p["n_scenes"], p["overlap"], *(p["interval"] or (None, None))]
            for m, found in solutions.items()
            for p in found["overlap"]
        ),
    )
    people = read_json(folder / "parameters.json")["participants"]
    yield (
        "parameters",
        (
            "participant",
            "parameter",
            "=truth",
            "=at_least_L",
            "=at_greatest_L",
            "=hull_low",
            "=hull_high",
            "=hull_holds_truth",
            "=set_by_bound_at_least_L",
            "=set_by_bound_at_greatest_L",
        ),
        (row for person in people for row in _person(person)),
    )
    plans = read_json(folder / "plans.json")["plans"]
    yield (
        "plans",
        ("scene", "type", "status", "=length_px", "=keeps_true_rule"),
        ([p["scene"], p["type"], p["status"], p.get("length"), p.get("true_obeys")] for p in plans),
    )


def _person(person: dict[str, Any]) -> Iterable[Row]:
    answer, truth, holds = person["answer"], person["truth"], person["holds"]
    low, high, hull = answer["min"], answer["max"], answer["hull"]
    number = person["participant"]
    bound = [[name in answer[f"saturated_{end}"] for end in ("min", "max")]
             for name in ("T_min", *low["T_object"])]  # fmt: skip
    yield [
        number, "T_min", truth["T_min"], low["T_min"], high["T_min"], *hull["T_min"],
        holds["T_min"], *bound[0],
    ]  # fmt: skip
    for name, radius, on in zip(low["T_object"], truth["radius"], bound[1:], strict=True):
        ends = [e["T_min"] + e["T_object"][name] for e in (low, high)]
        yield [
            number, f"radius of {name}", radius, *ends, *hull["radius"][name], holds[name], *on
        ]  # fmt: skip
