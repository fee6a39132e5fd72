"""Demonstrations in columns: picking rows, views, equality; sets: selecting and indexing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    checked_points,
    simulate_set,
)
from demospec.errors import InputError
from demospec.scene import Scene


def some(counts: list[int], seed: int = 0) -> list[Demonstration]:
    rng = np.random.default_rng(seed)
    return [
        Demonstration(f"d{i}", "s", rng.uniform(0, 9, (n, 2)), "t", None, i % 2 == 0,
                      np.arange(n) / 10 if i % 3 else None)
        for i, n in enumerate(counts)
    ]  # fmt: skip


@given(
    counts=st.lists(st.integers(1, 9), min_size=1, max_size=12),
    picks=st.lists(st.integers(0, 11), max_size=15),
)
@settings(deadline=None, max_examples=50)
def test_picking_rows_equals_picking_from_the_list(counts: list[int], picks: list[int]) -> None:
    items = some(counts)
    columns = Demonstrations.of(items)
    assert list(columns) == items
    rows = [p % len(items) for p in picks]
    assert list(columns.rows(rows)) == [items[r] for r in rows]
    mask = np.array([i in rows for i in range(len(items))])
    assert list(columns.rows(mask)) == [item for item, m in zip(items, mask, strict=True) if m]
    assert list(columns[1::2]) == items[1::2]
    assert columns[-1] == items[-1]


def test_paths_are_views_not_copies() -> None:
    columns = Demonstrations.of(some([3, 4]))
    assert np.shares_memory(columns.points(1), columns.flat)
    assert all(np.shares_memory(p, columns.flat) for p in columns.paths_xy())
    with pytest.raises(IndexError):
        _ = columns[2]


def test_points_of_another_width_are_refused() -> None:
    with pytest.raises(InputError, match=r"3 numbers a point.*2 in demonstration d0"):
        Demonstrations.of(some([3]), columns=3)


def test_checked_points_cannot_be_changed() -> None:
    points = checked_points([[1, 2], [3, 4]])
    with pytest.raises(ValueError, match="read-only"):
        points[0] = 0


def test_a_set_selects_splits_and_rows_by_scene() -> None:
    data, _ = simulate_set(train_scenes=2, test_scenes=1, demonstrations=2)
    test = data.of_split("test")
    assert [s.split for s in test.scenes] == ["test"]
    assert set(test.demonstrations.scene_id) == {"0002"}
    careful = data.select(data.demonstrations.type == "careful")
    assert len(careful.demonstrations) == 6
    assert careful.scenes == data.scenes
    for scene_id, rows in data.rows_by_scene().items():
        assert set(data.demonstrations.scene_id[rows]) == {scene_id}
        assert len(rows) == 6
    with pytest.raises(InputError, match="scenes of split val"):
        data.of_split("val")
    with pytest.raises(InputError, match="a scene of the set"):
        data.scene("9999")


def test_a_set_checks_itself_in_memory_too() -> None:
    scene = Scene("s", (0.0, 0.0), (1.0, 1.0))
    items = Demonstrations.of(some([2]))
    for change, message in (
        ({"types": ()}, "one of the set's types"),
        ({"scenes": ()}, "at least one scene"),
        ({"scenes": (scene, scene)}, "each scene once"),
        ({"metres_per_unit": -1.0}, "a number from 1e-12 to 1e.09"),
        ({"columns": ("x", "y", "z")}, "3 numbers a point"),
    ):
        arguments = {"scenes": (scene,), "demonstrations": items, "types": ("t",)} | change
        with pytest.raises(InputError, match=message):
            DemonstrationSet(**arguments)  # type: ignore[arg-type]
