"""The paper's model and the IRL baseline: guards against fooling oneself, files, gradients."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet, bezier_points, simulate_set
from demospec.errors import InputError
from demospec.scene import Picture
from demospec.specification import evaluate, fit_model, load_model
from demospec.testing import colour_set, with_labels

torch = pytest.importorskip("torch", reason="torch comes with demospec[vision]")

# The decoder has no part in a verdict and takes two thirds of the time: guards go without it,
# except where the fixture below trains the whole model.
QUICK = {"paper": {"steps": 80, "ablation": "classifier"}, "irl": {}}


@pytest.fixture(scope="module")
def colour_model():
    return fit_model(colour_set(), "paper", seed=0, steps=120)


def balanced(model, data: DemonstrationSet) -> float:
    value = evaluate(model, data).types["sided"].balanced_accuracy
    assert value is not None
    return value


def test_learns_what_only_the_picture_tells(colour_model):
    assert balanced(colour_model, colour_set(20, seed=9)) > 0.85


@pytest.mark.parametrize("kind", ["paper", "irl"])
def test_guard_shuffled_labels_teach_nothing(kind):
    rng = np.random.default_rng(3)
    data = colour_set(16, 12)
    shuffled = with_labels(data, rng.permutation(data.demonstrations.valid))
    model = fit_model(shuffled, kind, seed=0, **QUICK[kind])
    # 40 fresh scenes of 12: the standard error is 0.023 if demonstrations were independent.
    assert abs(balanced(model, colour_set(40, 12, seed=4)) - 0.5) < 0.12


@pytest.mark.parametrize("kind", ["paper", "irl"])
def test_guard_blank_pictures_teach_nothing(kind):
    model = fit_model(colour_set(16, 12, blank=True), kind, seed=0, **QUICK[kind])
    assert abs(balanced(model, colour_set(40, 12, seed=4, blank=True)) - 0.5) < 0.08


def test_guard_a_trained_model_is_blind_without_the_picture(colour_model):
    assert abs(balanced(colour_model, colour_set(40, 12, seed=4, blank=True)) - 0.5) < 0.08


def test_guard_swapped_pictures_destroy_the_verdict(colour_model):
    data = colour_set(20, 12, seed=5)
    pictures = [scene.picture for scene in data.scenes]
    # Every second pair of neighbours (one red, one blue) trades pictures: half stay right.
    for i in range(0, 20, 4):
        pictures[i], pictures[i + 1] = pictures[i + 1], pictures[i]
    assert abs(balanced(colour_model, _with_pictures(data, pictures)) - 0.5) < 0.08


def test_guard_on_simulated_scenes_the_picture_carries_the_verdict():
    data, _ = simulate_set(train_scenes=6, test_scenes=1, demonstrations=30, seed=1)
    data = data.of_split("train")
    d = data.demonstrations
    held_out = np.array([int(i.rsplit("-", 1)[-1].lstrip("cna") or 0) % 3 == 0 for i in d.demo_id])
    model = fit_model(data.select(~held_out), "paper", ablation="classifier", steps=200)
    own = evaluate(model, data.select(held_out)).types["careful"].balanced_accuracy
    pictures = [s.picture for s in data.scenes]
    swapped = _with_pictures(data.select(held_out), pictures[1:] + pictures[:1])
    other = evaluate(model, swapped).types["careful"].balanced_accuracy
    assert own is not None
    assert other is not None
    assert own > 0.72
    assert other < own - 0.12


def _with_pictures(data: DemonstrationSet, pictures: list[Picture | None]) -> DemonstrationSet:
    from dataclasses import replace

    scenes = tuple(replace(s, picture=p) for s, p in zip(data.scenes, pictures, strict=True))
    return replace(data, scenes=scenes)


@pytest.mark.parametrize("order", [2, 3])
def test_gradient_is_the_difference_quotient_of_the_logit(order):
    model = fit_model(colour_set(4, 4), "paper", steps=5, order=order)
    view = model.see(colour_set(4, 4).scenes[0])
    rng = np.random.default_rng(0)
    control = rng.uniform(10, 90, (5, order - 1, 2))
    paths = bezier_points(np.tile([10.0, 90.0], (5, 1)), [90.0, 10.0], control, 40)
    logits, slope = view.logits_and_gradients(paths, "sided")
    np.testing.assert_allclose(logits, view.logits(paths, "sided"), atol=1e-5)
    direction = rng.normal(size=control.shape)
    nothing = np.zeros((5, 2))
    change = bezier_points(nothing, nothing, direction, 40)
    h = 0.05
    quotient = (
        view.logits(paths + h * change, "sided") - view.logits(paths - h * change, "sided")
    ) / (2 * h)
    np.testing.assert_allclose((slope * change).sum(axis=(1, 2)), quotient, rtol=0.02, atol=2e-4)


@pytest.mark.parametrize("kind", ["paper", "irl"])
def test_saved_and_loaded_models_agree_and_the_same_seed_gives_the_same_bytes(kind, tmp_path):
    data = colour_set(4, 4)
    settings = {"steps": 5} if kind == "paper" else {}
    for name in ("a", "b"):
        fit_model(data, kind, seed=7, **settings).save(tmp_path / name)
    files = ("config.json", "weights.safetensors", "provenance.json")
    assert sorted(f.name for f in (tmp_path / "a").iterdir()) == sorted(files)
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    model, loaded = fit_model(data, kind, seed=7, **settings), load_model(tmp_path / "a")
    paths = data.demonstrations.paths_xy()
    for type_ in model.types:
        one = model.see(data.scenes[1]).logits(paths, type_)
        np.testing.assert_array_equal(one, loaded.see(data.scenes[1]).logits(paths, type_))


def test_another_seed_gives_other_weights():
    one, two = (fit_model(colour_set(2, 2), "paper", steps=2, seed=s) for s in (0, 1))
    assert not np.array_equal(one.weights["w1"], two.weights["w1"])


@pytest.mark.parametrize("size", [64, 250])
def test_any_picture_size(colour_model, size):
    assert balanced(colour_model, colour_set(12, seed=8, size=size)) > 0.8


@pytest.mark.parametrize("ablation", ["full", "autoencoder", "classifier"])
def test_ablations_train_and_reconstruct_or_say_why_not(ablation):
    data = colour_set(4, 4)
    model = fit_model(
        data, "paper", steps=150 if ablation != "classifier" else 2, ablation=ablation
    )
    if ablation == "classifier":
        with pytest.raises(InputError, match="decoder"):
            model.reconstruct(data.scenes[0])
        return
    for scene in data.scenes:
        seen = model.reconstruct(scene).astype(float).mean(axis=(0, 1))
        true = scene.pixels().astype(float).mean(axis=(0, 1))
        assert np.abs(seen - true).max() < 45
    assert model.sample_scenes(3, np.random.default_rng(0)).shape == (3, 100, 100, 3)


def test_settings_are_checked():
    for name, value in (("ablation", "none"), ("beta", -1), ("steps", 0), ("colour", 1)):
        with pytest.raises(InputError, match=name):
            fit_model(colour_set(2, 2), "paper", **{name: value})
    with pytest.raises(InputError, match="paper"):
        fit_model(colour_set(2, 2), "forest")


def test_a_device_that_is_not_there_is_named():
    absent = "cuda:97"  # whoever runs this
    for name in ("toaster", absent):
        with pytest.raises(InputError, match=f"device: expected a device .*found {name}"):
            fit_model(colour_set(2, 2), "paper", steps=2, device=name)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
def test_a_gpu_learns_what_the_cpu_learns():
    here, there = (
        fit_model(colour_set(4, 4), "paper", steps=20, device=d) for d in ("cpu", "cuda")
    )
    for name, value in here.weights.items():
        np.testing.assert_allclose(there.weights[name], value, atol=1e-3)


def _saved(folder: Path) -> Path:
    return fit_model(colour_set(2, 2), "paper", steps=2).save(folder)


HEAD = '"format":"demospec-model"'


@pytest.mark.parametrize(
    ("file", "content", "says"),
    [
        ("config.json", "[1]", "config.json"),
        ("config.json", f'{{{HEAD},"version":1,"kind":"wood","types":["a"]}}', "kind"),
        ("config.json", f'{{{HEAD},"version":9,"kind":"paper","types":["a"]}}', "version"),
        ("config.json", f'{{{HEAD},"version":1,"kind":"paper","types":[]}}', "types"),
        (
            "config.json",
            f'{{{HEAD},"version":1,"kind":"paper","types":["a"],"settings":{{"order":7}}}}',
            "w1",
        ),
        ("weights.safetensors", "not tensors at all", "weights.safetensors"),
        ("weights.safetensors", "", "weights.safetensors"),
        ("provenance.json", "7", "provenance.json"),
    ],
)
def test_damaged_model_folders_are_named(tmp_path, file, content, says):
    folder = _saved(tmp_path / "m")
    (folder / file).write_text(content)
    with pytest.raises(InputError, match=says):
        load_model(folder)


def test_weights_that_are_not_finite_are_refused(tmp_path):
    from safetensors.numpy import load_file, save_file

    folder = _saved(tmp_path / "m")
    weights = load_file(folder / "weights.safetensors")
    weights["b1"][0] = np.nan
    save_file(weights, folder / "weights.safetensors")
    with pytest.raises(InputError, match="b1"):
        load_model(folder)
