"""Readings are chosen by numbers: other numbers, other words."""

from __future__ import annotations

from typing import Any

import pytest

from demospec.reproduction._readings import accuracy_reading, causes_reading, repair_reading


def _repairs(share: float | None, n: int) -> dict[str, Any]:
    value = {"vacuous": share is None, "repaired_by_truth": share, "n": n}
    return {"field": {"1": {"careful": value}}}


@pytest.mark.parametrize(
    ("share", "n", "words"),
    [(0.5, 200, "below"), (0.95, 200, "above"), (0.75, 200, "not to be told from"),
     (0.5, 4, "not to be told from"), (None, 0, "nothing to repair")],
)  # fmt: skip
def test_repair_is_set_beside_the_printed_share_by_its_interval(
    share: float | None, n: int, words: str
) -> None:
    assert words in repair_reading(_repairs(share, n))[0]


def _effects(causal: set[tuple[str, str]]) -> dict[str, Any]:
    cells = [
        {"type": t, "symbol": s, "causal": (t, s) in causal}
        for t in ("careful", "normal", "aggressive")
        for s in ("utensil", "plate", "bowl", "glass")
    ]
    return {"truth": {"effects": cells}}


def test_causes_are_counted_cell_by_cell() -> None:
    printed = {("careful", s) for s in ("utensil", "plate", "bowl", "glass")} | {
        ("normal", "glass")
    }
    assert "in 12 of 12 cells." in causes_reading(_effects(printed))[0]
    told = causes_reading(_effects(printed - {("normal", "glass")} | {("normal", "bowl")}))[0]
    assert "in 10 of 12 cells; not in normal + bowl, normal + glass." in told


def test_the_nearest_reading_of_the_protocol_is_found_not_named_beforehand() -> None:
    near, far = (0.72, 0.99), (0.6, 0.7)
    for name, means in (
        ("clustered", {"uniform": far, "clustered": near}),
        ("uniform", {"uniform": near, "clustered": far}),
    ):
        words = accuracy_reading(means, "")
        assert f"is the {name} reading: 99.0%, as printed" in words
    split = accuracy_reading({"uniform": (0.72, 0.9), "clustered": (0.95, 0.98)}, "")
    assert "is the clustered reading" in split
    assert "Over both ends the uniform reading is nearer" in split
