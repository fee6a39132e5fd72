"""The lines of a grid of fits as a table: means over randomisations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


def grid_table(lines: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Means over seeds: one row per model, count and type.

    Each row: ``accuracy`` and ``bacc`` on seen scenes (held-out paths) and unseen scenes, the
    same far from the boundary, the majority's accuracy, and the number of fits. Balanced
    accuracies are null where a type has one class only.
    """
    groups: dict[tuple[str, int, str], list[dict[str, Any]]] = {}
    for line in lines:
        for type_, scores in line["types"].items():
            groups.setdefault((line["model"], line["n"], type_), []).append(scores)
    rows = []
    for (model, n, type_), scores in groups.items():
        row: dict[str, Any] = {"model": model, "n": n, "type": type_, "fits": len(scores)}
        for where in ("seen", "unseen"):
            parts = [s[where] for s in scores if s[where] is not None]
            row[f"accuracy_{where}"] = _mean([p["accuracy"] for p in parts])
            row[f"majority_{where}"] = _mean([p["majority"] for p in parts])
            row[f"bacc_{where}"] = _mean([p["balanced_accuracy"] for p in parts])
            far = [p["far"]["balanced_accuracy"] for p in parts if "far" in p]
            row[f"bacc_{where}_far"] = _mean(far)
            known = [p["balanced_accuracy"] for p in parts if p["balanced_accuracy"] is not None]
            row[f"quartiles_{where}"] = (
                [float(q) for q in np.quantile(known, (0.25, 0.75))] if known else None
            )
            row[f"accuracies_{where}"] = [p["accuracy"] for p in parts]
        rows.append(row)
    return rows


def _mean(values: Sequence[float | None]) -> float | None:
    known = [v for v in values if v is not None]
    return float(np.mean(known)) if known else None
