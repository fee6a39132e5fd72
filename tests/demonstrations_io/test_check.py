"""Each oddity is found where it is, and nothing is found in a clean set."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_sets import change_line, rewrite_table

from demospec.cli import main
from demospec.demonstrations import check_set, read_set
from demospec.demonstrations._table import from_arrow, schema
from demospec.demonstrations.validation._faults import table_faults
from demospec.errors import InputError
from demospec.testing import bulged_path, write_small_set


def kinds(root: Path) -> set[str]:
    report = check_set(root)
    assert report.readable
    return set(report.kinds)


def changed(root: Path, row: int, **values: object) -> None:
    def change(items: list[dict]) -> list[dict]:
        items[row] = {**items[row], **values}
        return items

    rewrite_table(root, change)


def test_a_clean_set_is_clean(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    root = write_small_set(tmp_path / "set", 12)
    report = check_set(root)
    assert report.to_json()["kinds"] == {}
    assert report.counts["demonstrations"] == 12
    assert report.counts["types"]["careful"] == {"valid": 4, "invalid": 2, "unlabelled": 0}
    assert report.counts["by_scene"]["s1"] == {"valid": 4, "invalid": 2, "unlabelled": 0}
    with pytest.raises(SystemExit) as stop:
        main(["check", str(root), "--json"])
    assert stop.value.code == 0
    assert json.loads(capsys.readouterr().out)["warnings"] == 0


@pytest.mark.parametrize(
    ("kind", "row", "values"),
    [
        ("duplicate", 4, {"points": bulged_path(-5).tolist(), "valid": False}),
        ("contradiction", 4, {"points": bulged_path(-5).tolist(), "valid": True}),
        ("start_mismatch", 1, {"points": [[30.0, 70.0], [90.0, 10.0]]}),
        ("goal_mismatch", 1, {"points": [[10.0, 90.0], [60.0, 40.0]]}),
        ("y_points_up", 1, {"points": [[10.0, 10.0], [90.0, 90.0]]}),
        ("outside_picture", 1, {"points": [[10.0, 90.0], [120.0, 50.0], [90.0, 10.0]]}),
        ("no_motion", 1, {"points": [[10.0, 90.0]]}),
        (
            "uneven_sampling",
            1,
            {"points": [[10.0, 90.0], [11, 89], [12, 88], [13, 87], [90.0, 10.0]]},
        ),
        ("resting_ends", 1, {"points": [[10.0, 90.0]] * 6 + bulged_path(4).tolist()}),
        ("time_not_increasing", 1, {"t": [0.0, 0.1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]}),
    ],
)
def test_odd_paths_are_named(tmp_path: Path, kind: str, row: int, values: dict) -> None:
    root = write_small_set(tmp_path / "set", 12)
    changed(root, row, **values)
    report = check_set(root)
    assert report.readable
    assert report.kinds[kind] == 1
    (problem,) = [p for p in report.problems if p.kind == kind]
    assert problem.row == row
    assert problem.file.endswith("demonstrations.parquet")


def test_odd_labels_and_scenes_are_named(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set", 12)

    def change(items: list[dict]) -> list[dict]:
        items = [i for i in items if i["scene_id"] == "s0"]
        return [{**i, "valid": True} for i in items]

    rewrite_table(root, change)
    assert kinds(root) == {
        "one_class",
        "type_without_demonstrations",
        "scene_without_demonstrations",
    }
    change_line(root, 1, lambda d: d.update(objects=[]))
    change_line(root, 0, lambda d: d["objects"][0].update(center=[150.0, 0.0]))
    assert {"objects_not_listed", "object_outside"} <= kinds(root)
    rewrite_table(root, lambda items: [{**i, "valid": None} for i in items])
    assert "unlabelled_type" in kinds(root)


def test_many_warnings_are_counted_and_some_listed(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set", 60)
    rewrite_table(root, lambda items: [{**i, "points": [[1.0, 1.0], [2.0, 2.0]]} for i in items])
    report = check_set(root, rows=7)
    assert report.kinds["start_mismatch"] == 60
    assert sum(p.kind == "start_mismatch" for p in report.problems) == 20


number = st.one_of(st.floats(0, 100), st.none(), st.sampled_from([np.nan, np.inf, 1e300, -3.0]))
point = st.one_of(st.lists(number, min_size=2, max_size=2), st.lists(number, max_size=3), st.none())
clean_path = st.lists(st.lists(st.floats(0, 100), min_size=2, max_size=2), min_size=1, max_size=4)
row = st.fixed_dictionaries(
    {
        "demo_id": st.one_of(st.text(max_size=3), st.none()),
        "scene_id": st.one_of(st.just("s0"), st.none()),
        "points": st.one_of(clean_path, clean_path, st.lists(point, max_size=4), st.none()),
        "t": st.one_of(st.none(), st.lists(number, max_size=4)),
    }
)


@settings(deadline=None, max_examples=300)
@given(rows=st.lists(row, max_size=6), columns=st.integers(2, 3))
def test_every_fault_that_reading_meets_is_reported_and_no_other(
    rows: list[dict], columns: int
) -> None:
    import pyarrow as pa

    loose = pa.schema([pa.field(f.name, f.type) for f in schema()])
    table = pa.Table.from_pylist(rows, schema=loose)
    file = Path("demonstrations.parquet")
    faults, good, whole = table_faults(table, file=file, columns=columns, first_row=0)
    assert whole
    # Row by row, reading (which stops at the first fault) is the oracle.
    for i in range(len(rows)):
        try:
            from_arrow(table.slice(i, 1), file=file, columns=columns, first_row=i)
            fine = True
        except InputError:
            fine = False
        assert fine == bool(good[i])
        assert fine == (i not in {f.row for f in faults})
    kept = from_arrow(table.filter(good), file=file, columns=columns) if good.any() else []
    assert len(kept) == int(good.sum())


def test_check_and_read_agree_on_the_examples_format(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set", pictures=False)
    assert check_set(root).readable
    assert len(read_set(root).demonstrations) == check_set(root).counts["demonstrations"]
