"""Boundaries over scenes, probabilities of causation, and rejected demonstrations without."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from demospec.causal import (
    Settings,
    Trial,
    TrialTable,
    boundary_between,
    boundary_effects,
    but_for_rejected,
    causation,
    run_trials,
)
from demospec.cli import main
from demospec.demonstrations import simulate_set, write_set
from demospec.rules import rules_from_document


def _trials(before: list[float], after: list[float]) -> TrialTable:
    """One scene, one type, one place of one glass."""
    return TrialTable(
        scene_ids=("a",),
        types=("one",),
        symbols=("glass",),
        controls=(np.zeros((len(before), 2)),),
        before=(np.array([before]),),
        trials=(Trial(0, "add", "glass", 0, (0.0, 0.0), np.array([after])),),
        notes=(),
        skipped={},
    )


def test_certain_answers_are_counted() -> None:
    # Accepted in both; lost twice; rejected in both; gained (a glass that helps) once.
    (found,) = causation(_trials([1, 1, 1, 0, 0], [1, 0, 0, 0, 1]))
    assert found.both == (0.4, 0.4)
    assert found.necessity == pytest.approx((2 / 3, 2 / 3))
    assert found.sufficiency == pytest.approx((2 / 3, 2 / 3))


def test_uncertain_answers_give_the_bounds_of_tian_and_pearl() -> None:
    (found,) = causation(_trials([0.7], [0.4]))
    assert found.both == pytest.approx((0.3, 0.6))
    assert found.necessity == pytest.approx((0.5, 1.0))
    assert found.sufficiency == pytest.approx((0.3 / 0.7, 0.6 / 0.7))
    # Any joint distribution with these margins lies within: the two extremes and independence.
    assert found.both[0] <= 0.7 * 0.6 <= found.both[1]
    (nothing,) = causation(_trials([0.0, 0.0], [1.0, 1.0]))
    assert (nothing.necessity, nothing.sufficiency, nothing.both) == (None, None, (0.0, 0.0))


def test_certain_rules_have_no_width_and_what_matters_to_nobody_causes_nothing(  # type: ignore[no-untyped-def]
    truth, scenes
) -> None:
    table = run_trials(truth, scenes[:8], settings=Settings(placements=2, draws=40))
    found = {(c.type, c.symbol): c for c in causation(table)}
    for cell in found.values():
        assert cell.both[0] == cell.both[1]
    assert found["normal", "plate"].both == (0.0, 0.0)
    assert found["normal", "plate"].necessity in (None, (0.0, 0.0))
    assert found["aggressive", "glass"].necessity is None  # rejects nothing
    glass = found["normal", "glass"]
    assert glass.both[0] > 0
    # A clearance only ever takes paths away: P(accepted, then rejected) is the effect.
    effect = table.scene_differences("add", "glass")[0][table.types.index("normal")].mean()
    assert glass.both[0] == pytest.approx(-effect)


def test_boundaries_move_where_a_type_minds_the_symbol(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = boundary_effects(truth, scenes[:4], grid=15)
    cells = {(e.type, e.symbol or e.to_type): e for e in found}
    assert len(found) == 3 * 4 + 3
    assert cells["careful", "plate"].lost > 0
    assert cells["careful", "plate"].gained == 0
    assert cells["careful", "plate"].distance
    assert (cells["normal", "plate"].lost, cells["normal", "plate"].distance) in ((0, 0), (0, None))
    assert cells["aggressive", "glass"].distance is None  # accepts everything: no boundary
    # careful accepts nothing that normal rejects.
    between = cells["careful", "normal"]
    assert between.lost == 0
    assert between.gained > 0
    one = [boundary_between(truth.see(s), "careful", "normal", grid=15) for s in scenes[:4]]
    assert between.gained == pytest.approx(np.mean([b.gained for b in one]))
    assert one[0].type == "careful → normal"


@pytest.fixture(scope="module")
def small(tmp_path_factory):  # type: ignore[no-untyped-def]
    data, document = simulate_set(train_scenes=3, test_scenes=0, demonstrations=4, seed=5)
    folder = tmp_path_factory.mktemp("causation") / "set"
    write_set(data, folder, documents={"truth.json": document})
    return data, rules_from_document(document), folder


def test_rejected_demonstrations_without_each_object(small) -> None:  # type: ignore[no-untyped-def]
    data, truth, _ = small
    found = but_for_rejected(truth, data, 3)
    rejected = {str(i) for i, v in zip(data.demonstrations.demo_id, data.demonstrations.valid,
                                       strict=True) if v == 0}  # fmt: skip
    assert found
    assert {r.demo_id for r in found} <= rejected
    # The rule that made the labels rejects them, and accepts everything on an empty table.
    assert {r.kind for r in found} <= {"one", "together"}
    assert "one" in {r.kind for r in found}
    for case in found:
        if case.kind == "one":
            assert "had " in case.found.sentence


def test_the_command_writes_all_three(small, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    _, _, folder = small
    out = tmp_path / "causes.json"
    with pytest.raises(SystemExit) as stop:
        main(["causes", str(folder / "truth.json"), str(folder), "--boundaries",
                 "--but-for", "1", "--placements", "1", "--draws", "10", "--symbols", "glass",
                 "--out", str(out)])  # fmt: skip
    assert stop.value.code == 0
    document = json.loads(out.read_text())
    assert {c["symbol"] for c in document["causation"]} == {"glass"}
    assert [b.get("to") for b in document["boundaries"]][-1] == "aggressive"
    assert {b["type"] for b in document["but_for"]} <= {"careful", "normal"}
    said = capsys.readouterr().out
    assert "Boundary of validity" in said
    assert "rejects this path" in said
