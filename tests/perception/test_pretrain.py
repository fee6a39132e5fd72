"""The recipe: deterministic, whatever the workers; checkpoints whole; bad settings refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from demospec.cli import main
from demospec.errors import InputError
from demospec.perception import (
    NetworkSize,
    PretrainSettings,
    load_network,
    observe,
    pretrain,
    recipe_of,
)

SMALL = NetworkSize(8, 8, 8, 4)


def tiny(**changes: object) -> PretrainSettings:
    plain = {
        "steps": 4,
        "batch": 2,
        "pool": 16,
        "size_px": 40,
        "body": SMALL,
        "seed": 3,
        "judge_pictures": 4,
        "joiner_pictures": 4,
        "doubt_pictures": 4,
        "familiarity_pictures": 4,
    }
    return PretrainSettings(**{**plain, **changes})  # type: ignore[arg-type]


def weights(file: Path) -> dict[str, np.ndarray]:
    return {k: v.numpy() for k, v in load_network(file).state_dict().items()}


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    torch.set_num_threads(1)
    file = tmp_path_factory.mktemp("network") / "first.safetensors"
    pretrain(file, tiny(), command="as in the test")
    return file


def alike(a: Path, b: Path) -> bool:
    one, other = weights(a), weights(b)
    return one.keys() == other.keys() and all((one[k] == other[k]).all() for k in one)


def test_the_same_settings_give_the_same_weights(first: Path, tmp_path: Path) -> None:
    pretrain(tmp_path / "again.safetensors", tiny())
    pretrain(tmp_path / "other.safetensors", tiny(seed=4))
    assert alike(first, tmp_path / "again.safetensors")
    assert not alike(first, tmp_path / "other.safetensors")


@pytest.mark.slow
def test_weights_do_not_depend_on_the_workers(first: Path, tmp_path: Path) -> None:
    pretrain(tmp_path / "painted.safetensors", tiny(workers=1))
    assert alike(first, tmp_path / "painted.safetensors")


def test_the_recipe_is_saved_inside(first: Path) -> None:
    recipe = recipe_of(first)
    assert recipe["steps_done"] == 4
    assert recipe["command"] == "as in the test"
    assert recipe["settings"]["seed"] == 3
    assert recipe["began_from"] is None
    assert observe(np.full((40, 40, 3), 90, np.uint8), network=load_network(first)).grid == (
        160,
        160,
    )


def test_going_on_keeps_the_first_recipe(first: Path, tmp_path: Path) -> None:
    out = tmp_path / "second.safetensors"
    pretrain(out, tiny(init=str(first), steps=2, lr=1e-4))
    recipe = recipe_of(out)
    assert recipe["began_from"]["settings"]["seed"] == 3
    assert recipe["steps_done"] == 2
    before, after = weights(first), weights(out)
    trained = [k for k in before if k.startswith("backbone.")]
    gap = [np.abs(before[k] - after[k]).max() for k in trained]
    assert 0 < max(gap) < 0.01  # gone on from there, not begun anew
    with pytest.raises(InputError, match="init"):
        pretrain(tmp_path / "x.safetensors", tiny(init=str(first), body=NetworkSize(16, 8, 8, 4)))


def test_no_steps_from_given_weights_fit_the_heads_alone(first: Path, tmp_path: Path) -> None:
    out = tmp_path / "judged.safetensors"
    pretrain(out, tiny(init=str(first), steps=0, seed=8))
    before, after = weights(first), weights(out)
    changed = {k for k in before if (before[k] != after[k]).any()}
    assert not any(k.startswith("backbone.") for k in changed)
    assert any(k.startswith("uncertainty.") for k in changed)


def test_ctrl_c_leaves_whole_weights(tmp_path: Path) -> None:
    out = tmp_path / "stopped.safetensors"

    def stop(what: str, done: float, total: float) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pretrain(out, tiny(), progress=stop)
    assert 1 <= recipe_of(out)["steps_done"] <= 2
    load_network(out)


@pytest.mark.parametrize(
    ("field", "value"),
    [("steps", 0), ("batch", 0), ("workers", -1), ("lr", 0.0), ("lr", float("nan")),
     ("reuse", 0.0), ("clear_share", 1.0), ("rendered", 1.5), ("judge_pictures", 0),
     ("joiner_pictures", 0), ("doubt_pictures", 0), ("size_px", 8), ("average", 1.5)],
)  # fmt: skip
def test_bad_settings_are_refused(field: str, value: float) -> None:
    with pytest.raises(InputError, match=field):
        tiny(**{field: value})


@pytest.mark.parametrize(
    "arguments",
    [["--out", "x.txt"], ["--out", "no/such/x.safetensors"],
     ["--out", "x.safetensors", "--lr", "2"],
     ["--out", "x.safetensors", "--init", "absent.safetensors", "--steps", "1"]],
)  # fmt: skip
def test_bad_commands_exit_2_in_one_line(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["pretrain", *arguments])
    assert stop.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
