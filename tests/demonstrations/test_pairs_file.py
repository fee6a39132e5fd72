"""``pairs.parquet``: read, written, checked, edited."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from demospec.cli import main
from demospec.demonstrations import (
    DemonstrationSet,
    Pair,
    check_set,
    edit,
    in_one_unit,
    read_set,
    write_set,
)
from demospec.errors import InputError
from demospec.testing import small_set

PAIRS = (Pair("d0", "d2"), Pair("d1", "d3", "careful"))


def with_pairs() -> DemonstrationSet:
    return replace(small_set(pictures=False), pairs=PAIRS)


def test_pairs_come_back_from_disk(tmp_path: Path) -> None:
    write_set(with_pairs(), tmp_path / "set")
    assert read_set(tmp_path / "set").pairs == PAIRS
    assert check_set(tmp_path / "set").readable
    write_set(small_set(pictures=False), tmp_path / "without")
    assert not (tmp_path / "without" / "pairs.parquet").exists()


def test_a_part_keeps_the_pairs_of_which_it_has_both() -> None:
    data = with_pairs()
    assert data.select([0, 2, 3]).pairs == PAIRS[:1]
    assert edit.drop(data, types=["careful"]).pairs == ()
    assert in_one_unit(data).pairs == PAIRS


def test_merged_sets_keep_their_pairs_under_the_new_names() -> None:
    data = edit.merge([with_pairs(), with_pairs()], ["a", "b"])
    assert data.pairs == (*PAIRS, Pair("b-d0", "b-d2"), Pair("b-d1", "b-d3", "careful"))


@pytest.mark.parametrize(
    ("pair", "message"),
    [
        (Pair("d0", "d0"), "row 0, pairs.other: expected two demonstrations that differ"),
        (Pair("d0", "d1"), "row 0, pairs.type: expected the type that prefers"),
        (Pair("d0", "d2", "bold"), "row 0, pairs.type: expected one of the set's types"),
    ],
)
def test_pairs_that_mean_nothing_are_refused(pair: Pair, message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(small_set(pictures=False), pairs=(pair,))


def write_parquet(file: Path, columns: dict[str, list[Any]]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table(columns), file)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"preferred": ["d0", "d9"], "other": ["d2", "d0"]}, "row 1, preferred: expected a dem"),
        ({"preferred": ["d0"], "other": [None]}, "row 0, other: expected .*, found null"),
        ({"preferred": ["d0"]}, "other: expected a column other"),
        ({"preferred": [0], "other": [2]}, "preferred: expected string, found int64"),
        ({"preferred": ["d0"], "other": ["d2"], "type": ["bold"]}, "row 0, pairs.type"),
    ],
)
def test_a_broken_file_is_named_by_reader_and_check(
    tmp_path: Path, columns: dict[str, list[Any]], message: str
) -> None:
    write_set(small_set(pictures=False), tmp_path / "set")
    write_parquet(tmp_path / "set" / "pairs.parquet", columns)
    with pytest.raises(InputError, match=message) as caught:
        read_set(tmp_path / "set")
    assert "pairs.parquet" in str(caught.value)
    report = check_set(tmp_path / "set")
    assert not report.readable
    assert "pairs.parquet" in json.dumps(report.to_json())


def test_a_table_of_pairs_is_added_to_a_set(tmp_path: Path) -> None:
    write_set(with_pairs(), tmp_path / "set")
    table = tmp_path / "pairs.csv"
    table.write_text("other,preferred\nd4,d0\n\n", encoding="utf-8")
    args = ["edit", "prefer", str(tmp_path / "set"), "--pairs", str(table), "--out"]
    with pytest.raises(SystemExit) as left:
        main([*args, str(tmp_path / "new")])
    assert left.value.code == 0
    assert read_set(tmp_path / "new").pairs == (*PAIRS, Pair("d0", "d4"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("preferred,other\nd0,d9\n", "row 0, other: expected a demonstration of the set"),
        ("preferred,other\nd0,d4\nd0,d1\n", "row 1, pairs.type: expected the type"),
        ("better,worse\nd0,d4\n", "expected the columns preferred, other"),
        ("preferred,other\nd0,\n", "row 0, other: expected a demonstration's id"),
        ("preferred,other\nd0\n", "row 0: expected 2 fields"),
        ("preferred,other\n", "expected at least one pair"),
        ("", "expected the columns"),
    ],
)
def test_a_broken_table_is_named_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    table = tmp_path / "pairs.csv"
    table.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        edit.prefer(with_pairs(), edit.read_pair_table(table))
