"""Batches add up to the set, name rows of the file, and hold little memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_sets import rewrite_table

from demospec.demonstrations import count_rows, edit, iterate_batches, read_set, write_set
from demospec.errors import InputError
from demospec.testing import small_set, write_small_set


@settings(deadline=None, max_examples=15)
@given(rows=st.integers(1, 9), n=st.integers(1, 12), t=st.booleans())
def test_batches_add_up_to_the_set(
    tmp_path_factory: pytest.TempPathFactory, rows: int, n: int, t: bool
) -> None:
    root = write_small_set(tmp_path_factory.mktemp("s") / "set", n, t=t)
    whole = read_set(root)
    batches = list(iterate_batches(root, rows=rows))
    assert [len(b.demonstrations) for b in batches[:-1]] == [rows] * (len(batches) - 1)
    assert edit.joined([b.demonstrations for b in batches]) == whole.demonstrations
    for batch in batches:
        used = set(batch.demonstrations.scene_id)
        assert [s.scene_id for s in batch.scenes] == [
            s.scene_id for s in whole.scenes if s.scene_id in used
        ]
        assert batch.types == whole.types
    assert count_rows(root) == n


def test_faults_far_down_name_the_row_of_the_file(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set", 10)

    def change(items: list[dict]) -> list[dict]:
        items[7]["type"] = "reckless"
        return items

    rewrite_table(root, change)
    with pytest.raises(InputError, match=r"row 7, type: expected one of") as fault:
        list(iterate_batches(root, rows=3))
    with pytest.raises(InputError) as whole:
        read_set(root)
    assert str(fault.value) == str(whole.value)


def test_a_name_repeated_in_another_batch_is_refused(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set", 10)
    rewrite_table(root, lambda items: [*items, items[1]])
    with pytest.raises(InputError, match=r"row 10, demo_id: expected each demonstration once"):
        list(iterate_batches(root, rows=4))


def test_null_and_given_times_keep_their_rows(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set", 5, t=True)

    def change(items: list[dict]) -> list[dict]:
        items[1]["t"] = None
        items[4]["t"] = None
        return items

    rewrite_table(root, change)
    given_t = [d.t is not None for d in read_set(root).demonstrations]
    assert given_t == [True, False, True, True, False]
    streamed = [d.t is not None for b in iterate_batches(root, rows=2) for d in b.demonstrations]
    assert streamed == given_t
    write_set(read_set(root), tmp_path / "again")
    assert read_set(tmp_path / "again") == read_set(root)


CODE = """
import resource, sys
from demospec.demonstrations import check_set, iterate_batches
def used(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
for batch in iterate_batches(sys.argv[1], rows=100): break
before = used()
n = 0
for batch in iterate_batches(sys.argv[1], rows=500): n += len(batch.demonstrations)
check_set(sys.argv[1], rows=500)
print(n, used() - before)
"""


def test_memory_does_not_grow_with_the_set(tmp_path: Path) -> None:
    # 24,000 paths of 500 points: 190 MB of numbers, in row groups of two million points.
    from dataclasses import replace

    from demospec.demonstrations import Demonstrations

    n, m = 24_000, 500
    base = small_set(2, pictures=False)
    s = np.linspace(0, 1, m)[None, :, None]
    bulge = np.random.default_rng(0).uniform(-5, 5, (n, 1, 1))
    flat = (np.array([10.0, 90.0]) + s * np.array([80.0, -80.0]) + bulge * s * (1 - s)).reshape(
        -1, 2
    )

    def column(values: list) -> np.ndarray:
        out = np.empty(len(values), dtype=object)
        out[:] = values
        return out

    d = Demonstrations(
        demo_id=column([f"d{i}" for i in range(n)]), scene_id=column(["s0"] * n),
        type=column(["careful"] * n), demonstrator=column([None] * n),
        valid=np.arange(n).astype(np.int8) % 2, flat=flat, offsets=np.arange(n + 1) * m,
    )  # fmt: skip
    write_set(replace(base, demonstrations=d), tmp_path / "large")
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(tmp_path / "large")],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    count, grown = done.stdout.split()
    assert int(count) == n
    assert float(grown) < 120  # MB; the whole set in memory would be 190 MB and more


def test_samples_are_parts_of_the_set_in_its_order(tmp_path: Path) -> None:
    from demospec.demonstrations import sample_set

    root = write_small_set(tmp_path / "set", 60)
    whole = read_set(root)
    part = sample_set(root, per_type=7, seed=1, rows=11)
    assert [list(part.demonstrations.type).count(t) for t in whole.types] == [7, 7]
    names = list(whole.demonstrations.demo_id)
    places = [names.index(n) for n in part.demonstrations.demo_id]
    assert places == sorted(places)
    assert part.demonstrations == whole.demonstrations.rows(places)
    assert sample_set(root, per_type=7, seed=1, rows=60) == part  # whatever the batches
    assert sample_set(root, per_type=7, seed=1, rows=13, workers=2) == part  # whoever reads
    assert sample_set(root, per_type=7, seed=2) != part
    assert len(sample_set(root, per_type=1000).demonstrations) == 60


def test_a_sample_from_behind_a_url_is_the_same(tmp_path: Path) -> None:
    from demospec.demonstrations import sample_set

    pytest.importorskip("fsspec", reason="pip install 'demospec[distributed]'")
    root = write_small_set(tmp_path / "set", 60)
    part = sample_set(root, per_type=7, seed=1)
    assert sample_set(f"file://{root}", per_type=7, seed=1, rows=17) == part


def test_every_demonstration_has_the_same_chance(tmp_path: Path) -> None:
    from demospec.demonstrations import sample_set

    root = write_small_set(tmp_path / "set", 12, pictures=False)
    count = np.zeros(12)
    for seed in range(120):
        part = sample_set(root, per_type=2, seed=seed, rows=5)
        for name in part.demonstrations.demo_id:
            count[int(name[1:])] += 1
    # 120 draws of 2 of 6: 40 each, standard deviation about 5.
    assert count.sum() == 480
    assert np.abs(count - 40).max() < 22


def test_commands_answer_alike_in_batches(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import json

    from demospec.cli import _predict, main

    root = write_small_set(tmp_path / "set", 11)

    def change(items: list[dict]) -> list[dict]:
        return [{**item, "type": None} if i % 4 == 0 else item for i, item in enumerate(items)]

    rewrite_table(root, change)
    rule = {"clearance": {"relevant": ["glass"], "value": {"glass": 3.0}}}
    (tmp_path / "rule.json").write_text(json.dumps({"types": {"careful": rule, "normal": rule}}))

    def predicted() -> dict:
        with pytest.raises(SystemExit) as stop:
            main(["predict", str(tmp_path / "rule.json"), str(root), "--json"])
        assert stop.value.code == 0
        return json.loads(capsys.readouterr().out)

    at_once = predicted()
    monkeypatch.setattr(_predict, "LARGE", 3)
    assert predicted() == at_once
    assert len(at_once["predictions"]) == 14
