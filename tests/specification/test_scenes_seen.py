"""Scenes through a model's latent space, and the command that draws them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, check_set, read_set, simulate_set, write_set
from demospec.errors import CannotJudgeError, InputError
from demospec.rules import learn_rules
from demospec.scene import Scene
from demospec.specification import (
    PaperModel,
    PaperSettings,
    reconstruct_scenes,
    set_of_sampled_scenes,
)
from demospec.specification.models import FieldModel


@pytest.fixture(scope="module")
def data() -> DemonstrationSet:
    return simulate_set(train_scenes=4, test_scenes=2, demonstrations=4, seed=3)[0]


@pytest.fixture(scope="module")
def field(data: DemonstrationSet) -> FieldModel:
    return FieldModel.fit(data.of_split("train"))


@pytest.fixture(scope="module")
def paper(data: DemonstrationSet) -> PaperModel:
    return PaperModel.fit(data.of_split("train"), settings=PaperSettings(steps=20))


def test_the_field_model_encodes_and_decodes(data: DemonstrationSet, field: FieldModel) -> None:
    scene = data.scenes[4]
    code = field.encode(scene)
    assert (field.decode(code) == field.reconstruct(scene)).all()
    assert {slot.symbol for slot in code.slots} <= {*data.symbols, ""}


def test_errors_are_those_of_the_pictures(
    data: DemonstrationSet, field: FieldModel, paper: PaperModel
) -> None:
    test = data.of_split("test").scenes
    for model, least in ((field, 26.0), (paper, 5.0)):
        for scene, found in zip(test, reconstruct_scenes(model, test), strict=True):
            gap = found.picture / 255.0 - scene.pixels() / 255.0
            assert found.rmse == pytest.approx(np.sqrt((gap**2).mean()), rel=1e-5)
            assert found.psnr_db == pytest.approx(-10 * np.log10((gap**2).mean()), rel=1e-5)
            assert found.psnr_db > least


def test_sampled_sets_are_sound(
    data: DemonstrationSet, field: FieldModel, paper: PaperModel, tmp_path: Path
) -> None:
    for name, model in (("field", field), ("paper", paper)):
        made = set_of_sampled_scenes(model, data, 3, seed=1)
        write_set(made, tmp_path / name)
        report = check_set(tmp_path / name)
        assert [p for p in report.problems if p.severity == "error"] == []
        again = set_of_sampled_scenes(model, data, 3, seed=1)
        assert all(
            (a.pixels() == b.pixels()).all() for a, b in zip(made.scenes, again.scenes, strict=True)
        )
        listed = [scene.objects is not None for scene in read_set(tmp_path / name).scenes]
        assert listed == [name == "field"] * 3


def test_what_cannot_be_drawn_is_refused(data: DemonstrationSet, field: FieldModel) -> None:
    with pytest.raises(InputError, match="a field or paper model"):
        reconstruct_scenes(learn_rules(data), data.scenes)
    with pytest.raises(CannotJudgeError):
        reconstruct_scenes(field, [Scene("s", (0.0, 0.0), (9.0, 9.0))])
    with pytest.raises(InputError, match="at least 1"):
        set_of_sampled_scenes(field, data, 0)


def test_the_command_draws_what_was_seen_and_new_scenes(
    data: DemonstrationSet, field: FieldModel, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_set(data, tmp_path / "set")
    field.save(tmp_path / "model")
    first = [str(tmp_path / "model"), str(tmp_path / "set"), "--out", str(tmp_path / "seen")]
    with pytest.raises(SystemExit) as stop:
        main(["scenes", *first, "--scene", "0004", "--json"])
    assert stop.value.code == 0
    told = json.loads(capsys.readouterr().out)
    assert told == json.loads((tmp_path / "seen" / "scenes.json").read_text())
    assert [row["scene_id"] for row in told["scenes"]] == ["0004"]
    assert (tmp_path / "seen" / told["scenes"][0]["file_name"]).is_file()
    with pytest.raises(SystemExit) as stop:
        main(["scenes", *first[:3], str(tmp_path / "new"), "--sample", "2", "--json"])
    assert stop.value.code == 0
    assert len(read_set(tmp_path / "new").scenes) == 2
    capsys.readouterr()
    with pytest.raises(SystemExit) as stop:
        main(["scenes", *first[:3], str(tmp_path / "x"), "--scene", "absent"])
    assert stop.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not (tmp_path / "x").exists()
