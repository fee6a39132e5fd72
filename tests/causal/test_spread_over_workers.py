"""A causal analysis spread over processes gives the table of one process, bit for bit."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from demospec.causal import Settings, trials_of_set, trials_of_stored
from demospec.demonstrations import read_set, simulate_set, write_set
from demospec.errors import CannotJudgeError
from demospec.files import write_json
from demospec.rules import read_rules

QUICK = Settings(draws=8, placements=1, interventions=("add", "remove", "move", "swap"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data, truth = simulate_set(train_scenes=5, test_scenes=1, demonstrations=2, seed=4)
    where = tmp_path_factory.mktemp("spread")
    write_json(where / "truth.json", truth)
    return write_set(data, where / "set")


@pytest.mark.parametrize("paths", ["random", "demonstrations"])
def test_workers_change_nothing(folder: Path, paths: str) -> None:
    load = partial(read_rules, folder.parent / "truth.json")
    options = {"settings": QUICK, "paths": paths, "split": "train"}
    one = trials_of_set(load(), read_set(folder), **options)  # type: ignore[arg-type]
    two = trials_of_stored(load, folder, workers=2, **options)  # type: ignore[arg-type]
    assert two.scene_ids == one.scene_ids
    assert (two.types, two.symbols, two.notes) == (one.types, one.symbols, one.notes)
    assert len(two.trials) == len(one.trials) > 20
    for mine, other in zip(two.trials, one.trials, strict=True):
        assert mine.scene == other.scene
        assert (mine.intervention, mine.symbol, mine.center) == (
            other.intervention, other.symbol, other.center)  # fmt: skip
        assert np.array_equal(mine.after, other.after)
    for mine_p, other_p in zip(two.before, one.before, strict=True):
        assert np.array_equal(mine_p, other_p)


class Blind:
    """Judges nothing."""

    types = ("careful",)

    def see(self, scene: object) -> object:
        raise CannotJudgeError("eyes", "none", field="model")


def test_scenes_that_nobody_can_judge_are_refused_from_workers_too(folder: Path) -> None:
    with pytest.raises(CannotJudgeError, match="eyes"):
        trials_of_stored(Blind, folder, workers=2, settings=QUICK)  # type: ignore[arg-type]
