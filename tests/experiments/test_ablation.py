"""The ablation grid goes on where it stopped, and its clustered sets are what they say."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.experiments import GridSettings, grid_set, grid_table, rank_in_scene, run_grid

SMALL = {"train_scenes": 2, "test_scenes": 1, "steps": 2}


def test_a_grid_resumes_after_a_line_was_cut_off(tmp_path):
    pytest.importorskip("torch", reason="torch comes with demospec[vision]")
    file = tmp_path / "grid.jsonl"
    settings = GridSettings(models=("classifier", "irl"), counts=(1, 2), seeds=(0,), **SMALL)
    whole = run_grid(file, settings)
    assert [(line["model"], line["n"]) for line in whole] == [
        ("classifier", 1), ("classifier", 2), ("irl", 1), ("irl", 2),
    ]  # fmt: skip
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join(lines[:3]) + lines[3][:20])
    calls: list[float] = []
    again = run_grid(file, settings, progress=lambda _what, done, _total: calls.append(done))
    assert calls[0] == 2  # two of the four fits were there

    def scores(rows):
        return [{k: v for k, v in row.items() if not k.endswith("_seconds")} for row in rows]

    assert scores(again) == scores(whole)
    table = grid_table(again)
    assert {row["type"] for row in table} == {"careful", "normal", "aggressive"}
    assert all(row["bacc_seen"] is None for row in table if row["type"] == "aggressive")
    with pytest.raises(InputError, match="same settings"):
        run_grid(file, GridSettings(seeds=(0,), reading="clustered", **SMALL))


KILLED = """
import sys
from pathlib import Path
from demospec.experiments import GridSettings, run_grid

def show(what, done, total):
    print(int(done), flush=True)

settings = GridSettings(
    models=("classifier", "irl"), counts=(1,), seeds=(0, 1, 2),
    train_scenes=2, test_scenes=1, steps=2,
)
run_grid(Path(sys.argv[1]), settings, progress=show)
"""


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is of POSIX systems")
def test_a_grid_killed_in_the_middle_ends_like_one_that_was_not(tmp_path):
    pytest.importorskip("torch", reason="torch comes with demospec[vision]")
    file = tmp_path / "killed.jsonl"
    child = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(file)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    assert child.stdout is not None
    with child, child.stdout as said:
        done = next(int(line) for line in said if int(line) > 0)
        child.send_signal(signal.SIGKILL)
    assert child.returncode == -signal.SIGKILL
    assert 0 < done < 6
    settings = GridSettings(models=("classifier", "irl"), counts=(1,), seeds=(0, 1, 2), **SMALL)
    calls: list[float] = []
    again = run_grid(file, settings, progress=lambda _what, done, _total: calls.append(done))
    assert done <= calls[0] <= calls[-1] == 6
    whole = run_grid(tmp_path / "whole.jsonl", settings)

    def scores(rows):
        return [{k: v for k, v in row.items() if not k.endswith("_seconds")} for row in rows]

    assert scores(again) == scores(whole)


def test_clustered_demonstrators_repeat_their_habits():
    settings = GridSettings(reading="clustered", train_scenes=2, test_scenes=1)
    data, truth = grid_set(settings, 0)
    d = data.demonstrations
    rows = np.flatnonzero((d.scene_id == "0000") & (d.type == "normal"))
    middles = np.array([d.points(int(i))[50] for i in rows])
    gaps = np.linalg.norm(middles[:, None] - middles, axis=2)
    # 18 demonstrations of three habits: most have a neighbour within a few pixels.
    assert np.median(np.sort(gaps, axis=1)[:, 1]) < 4
    view = truth.see(data.scenes[0])
    said = view.p_valid(d.paths_xy(rows), "normal") > 0.5
    np.testing.assert_array_equal(said, d.valid[rows] == 1)
    assert rank_in_scene(data).max() == 17


def test_grid_settings_are_checked():
    for bad in ({"models": ("forest",)}, {"counts": (0,)}, {"reading": "both"}):
        with pytest.raises(InputError, match=next(iter(bad))):
            GridSettings(**bad)


def test_a_stacked_grid_says_what_single_fits_say_and_goes_on_where_it_stopped(tmp_path):
    pytest.importorskip("torch", reason="torch comes with demospec[vision]")
    models = ("full", "classifier", "irl")
    settings = GridSettings(models=models, counts=(1, 3), seeds=(0, 1), **SMALL)
    single = run_grid(tmp_path / "single.jsonl", settings)
    file = tmp_path / "stacked.jsonl"
    calls: list[float] = []
    stacked = run_grid(
        file, settings, stack=3, progress=lambda _what, done, _total: calls.append(done)
    )
    assert calls == sorted(calls)
    assert calls[-1] == 12
    assert {line.get("stack") for line in stacked if line["model"] != "irl"} == {2, 3}
    for one, many in zip(single, stacked, strict=True):
        assert {k: one[k] for k in ("seed", "model", "n")} == {
            k: many[k] for k in ("seed", "model", "n")
        }
        for type_, where in one["types"].items():
            for place in ("seen", "unseen"):
                a, b = where[place]["accuracy"], many["types"][type_][place]["accuracy"]
                assert abs(a - b) < 0.06  # two steps: many an answer is next to ½
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join(lines[:3]) + lines[3][:9])
    again = run_grid(file, settings, stack=3)
    assert [line["n"] for line in again] == [line["n"] for line in stacked]
    assert len(file.read_bytes().splitlines()) == 13
