"""Which pictures the network says it knows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFilter

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, simulate_set
from demospec.errors import CannotJudgeError
from demospec.scene import Picture, Scene

pytest.importorskip("torch", reason="pip install 'demospec[vision]'")

from demospec.cli import main
from demospec.perception import detect_objects, load_network, observe
from demospec.perception.heads._familiarity import BLURRED, UNSEEN, UNSURE
from demospec.perception.network._distance_net import DistanceNet
from demospec.perception.training._familiarity import fit_familiarity, left_out, photographs
from demospec.specification import fit_model


@pytest.fixture(scope="module")
def drawn() -> list[np.ndarray]:
    return [
        scene.pixels()
        for size in (100, 160)
        for scene in simulate_set(
            train_scenes=0, test_scenes=6, demonstrations=1, seed=77, size_px=size
        )[0].scenes
    ]


def said_of(pixels: np.ndarray):
    said = observe(pixels, turns=(0,)).familiarity
    assert said is not None
    return said


def test_drawn_tables_are_familiar(drawn: list[np.ndarray]) -> None:
    assert sum(said_of(pixels).familiar for pixels in drawn) >= 11


def test_pictures_of_people_and_skies_are_not() -> None:
    asked = ("astronaut", "camera", "motorcycle_left", "hubble_deep_field")
    chosen = {name: pixels for name, pixels in photographs() if name in asked}
    assert len(chosen) == 4
    for name, pixels in chosen.items():
        said = said_of(pixels)
        assert not said.familiar, name
        assert said.reason in (UNSEEN, BLURRED)
        assert all(thing.confidence <= UNSURE for thing in detect_objects(pixels))


def test_blur_is_named(drawn: list[np.ndarray]) -> None:
    large = [Image.fromarray(p).resize((320, 320)) for p in drawn[:6]]
    said = [said_of(np.asarray(p.filter(ImageFilter.GaussianBlur(6)))) for p in large]
    assert [s.reason for s in said].count(BLURRED) >= 5


def test_weights_without_the_head_say_nothing(drawn: list[np.ndarray]) -> None:
    from demospec.perception.network._distance_net import folded

    network = folded(DistanceNet(load_network().size).eval())
    assert observe(drawn[0], network=network, turns=(0,)).familiarity is None


def test_a_head_finds_nothing_where_there_is_nothing() -> None:
    """Both kinds of one distribution: pictures left out are told apart no better than by a coin."""
    rng = np.random.default_rng(2)
    known, other = rng.normal(size=(160, 12)), rng.normal(size=(120, 12))
    names = [f"p{i // 5}" for i in range(120)]
    score, strange = left_out(known, other, names, 0)
    limit = np.quantile(score, 0.05)
    assert (strange < limit).mean() < 0.15
    held = fit_familiarity(known, other + 3.0, names, 0)
    z = np.sign(other + 3.0) * np.log1p(np.abs((other + 3.0 - held["center"]) / held["scale"]))
    assert (z @ held["weight"] + held["bias"] < 0).mean() > 0.95


def photographed(people: list[np.ndarray]) -> DemonstrationSet:
    scenes, items = [], []
    for i, pixels in enumerate(people):
        size = (pixels.shape[1], pixels.shape[0])
        scenes.append(Scene(f"s{i}", (5.0, 5.0), (90.0, 90.0), None, Picture(array=pixels)))
        for j in range(4):
            points = np.linspace([5, 5 + j], [size[0] * 0.9, size[1] * 0.9], 20)
            items.append(Demonstration(f"d{i}-{j}", f"s{i}", points, type="anna", valid=j % 2 == 0))
    return DemonstrationSet(tuple(scenes), Demonstrations.of(items), types=("anna",))


def test_nothing_is_learned_from_strange_pictures_alone() -> None:
    strange = [np.ascontiguousarray(p[:300, :300]) for name, p in photographs()
               if name in ("astronaut", "camera", "motorcycle_left")]  # fmt: skip
    with pytest.raises(CannotJudgeError, match=r"3 of 3.*unlike those of the training"):
        fit_model(photographed(strange), "field")


def test_detect_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str],
                        drawn: list[np.ndarray]) -> None:  # fmt: skip
    (pixels,) = [p for name, p in photographs() if name == "astronaut"]
    for file, picture, familiar in (("a.png", pixels, False), ("b.png", drawn[0], True)):
        Image.fromarray(picture).save(tmp_path / file)
        with pytest.raises(SystemExit):
            main(["detect", str(tmp_path / file), "--json"])
        out, err = capsys.readouterr()
        assert json.loads(out)["familiar"] is familiar
        assert ("unlike the pictures" in err) is not familiar
        assert ("reason" in json.loads(out)) is not familiar
