"""Ensembles: one folder, the mean logit with its gradient, a spread that is larger where new."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import (
    DifferentiableView,
    bezier_points,
    simulate_set,
    write_set,
)
from demospec.errors import InputError
from demospec.specification import (
    EnsembleModel,
    UncertainView,
    evaluate,
    fit_ensemble,
    fit_model,
    load_model,
    predict,
    repair,
)
from demospec.specification.models import resampled
from demospec.testing import colour_set, with_labels

pytest.importorskip("torch", reason="torch comes with demospec[vision]")

FILES = ("config.json", "provenance.json", "weights.safetensors")


@pytest.fixture(scope="module")
def trio():
    return fit_ensemble(colour_set(8), "paper", members=3, seed=4, steps=60, ablation="classifier")


def listed_set(scenes: int = 6):
    """Simulated scenes that list their objects and have no pictures: `field` fits in no time."""
    data, _ = simulate_set(train_scenes=scenes, test_scenes=1, demonstrations=6, seed=2)
    blind = tuple(s.with_changes(objects=s.objects, picture=None) for s in data.scenes)
    return replace(data, scenes=blind).of_split("train")


def test_one_member_is_the_plain_model_and_the_first_of_three(trio, tmp_path):
    data = colour_set(8)
    plain = fit_model(data, "paper", seed=4, steps=60, ablation="classifier")
    same = fit_model(data, "paper", members=1, seed=4, steps=60, ablation="classifier")
    for name, model in (("plain", plain), ("one", same), ("first", trio.members[0])):
        model.save(tmp_path / name)
    for file in FILES:
        expected = (tmp_path / "plain" / file).read_bytes()
        assert (tmp_path / "one" / file).read_bytes() == expected
        assert (tmp_path / "first" / file).read_bytes() == expected
    weights = [m.weights["w1"] for m in trio.members]
    assert not any(np.array_equal(weights[0], w) for w in weights[1:])


def test_it_judges_by_the_mean_logit_and_tells_the_members_spread(trio):
    data = colour_set(4, seed=9)
    paths = data.demonstrations.paths_xy()
    view = trio.see(data.scenes[0])
    views = [m.see(data.scenes[0]) for m in trio.members]
    logits = np.array([v.logits(paths, "sided") for v in views])
    np.testing.assert_allclose(view.logits(paths, "sided"), logits.mean(axis=0))
    p = view.p_valid(paths, "sided")
    np.testing.assert_array_equal(p > 0.5, view.logits(paths, "sided") > 0)
    np.testing.assert_array_equal(p, view.p_of_logits(view.logits(paths, "sided")))
    spread = np.array([v.p_valid(paths, "sided") for v in views]).std(axis=0, ddof=1)
    assert isinstance(view, UncertainView)
    np.testing.assert_allclose(view.p_valid_sd(paths, "sided"), spread)
    assert not isinstance(views[0], UncertainView)


def test_its_gradient_is_the_difference_quotient(trio):
    view = trio.see(colour_set(4).scenes[1])
    rng = np.random.default_rng(0)
    control = rng.uniform(10, 90, (5, 1, 2))
    ends = np.tile([10.0, 90.0], (5, 1))
    paths = bezier_points(ends, [90.0, 10.0], control, 40)
    logits, slope = view.control_logits_and_gradients(control, "sided")
    np.testing.assert_allclose(logits, view.logits(paths, "sided"), atol=1e-4)
    direction, h = rng.normal(size=control.shape), 0.05
    quotient = (
        view.control_logits(control + h * direction, "sided")
        - view.control_logits(control - h * direction, "sided")
    ) / (2 * h)
    np.testing.assert_allclose((slope * direction).sum(axis=(1, 2)), quotient, rtol=0.02, atol=2e-4)
    along = view.logits_and_gradients(paths, "sided")[1]
    assert np.isfinite(along).all()
    fixed = repair(view, control, "sided")
    assert fixed.p_valid.shape == (5,)


@pytest.mark.parametrize("kind", ["paper", "irl", "field"])
def test_saved_and_loaded_ensembles_agree(kind, tmp_path):
    data = listed_set() if kind == "field" else colour_set(4, 4)
    settings = {"steps": 4} if kind == "paper" else {}
    model = fit_model(data, kind, members=3, seed=1, **settings)
    again = fit_model(data, kind, members=3, seed=1, **settings)
    model.save(tmp_path / "m")
    again.save(tmp_path / "again")
    assert sorted(f.name for f in (tmp_path / "m").iterdir()) == sorted(FILES)
    for file in FILES:
        assert (tmp_path / "m" / file).read_bytes() == (tmp_path / "again" / file).read_bytes()
    loaded = load_model(tmp_path / "m")
    assert isinstance(loaded, EnsembleModel)
    loaded.save(tmp_path / "twice")
    for file in FILES:
        assert (tmp_path / "m" / file).read_bytes() == (tmp_path / "twice" / file).read_bytes()
    paths = data.demonstrations.paths_xy()
    for type_ in model.types:
        one, two = (m.see(data.scenes[1]) for m in (model, loaded))
        np.testing.assert_array_equal(one.logits(paths, type_), two.logits(paths, type_))
        np.testing.assert_array_equal(one.p_valid_sd(paths, type_), two.p_valid_sd(paths, type_))
    assert isinstance(model.see(data.scenes[0]), DifferentiableView) == (kind != "irl")
    said = [m.see(data.scenes[1]).logits(paths, model.types[0]) for m in model.members]
    assert any(not np.array_equal(said[0], other) for other in said[1:])


def test_arrays_that_are_alike_are_kept_once(tmp_path):
    from safetensors.numpy import load_file

    model = fit_model(colour_set(4, 4), "paper", members=2, steps=2)
    for member in model.members:
        member.weights["b1"] = np.zeros_like(member.weights["b1"])
    model.save(tmp_path / "m")
    names = set(load_file(tmp_path / "m" / "weights.safetensors"))
    assert {"0.b1", "0.w1", "1.w1"} <= names
    assert "1.b1" not in names
    np.testing.assert_array_equal(load_model(tmp_path / "m").members[1].weights["b1"], 0)


def test_guard_shuffled_labels_teach_nothing():
    rng = np.random.default_rng(3)
    data = colour_set(16, 12)
    shuffled = with_labels(data, rng.permutation(data.demonstrations.valid))
    model = fit_ensemble(shuffled, "paper", members=3, steps=80, ablation="classifier")
    score = evaluate(model, colour_set(40, 12, seed=4)).types["sided"].balanced_accuracy
    assert score is not None
    assert abs(score - 0.5) < 0.12


def test_members_disagree_more_on_scenes_that_they_have_not_seen():
    data, _ = simulate_set(train_scenes=6, test_scenes=6, demonstrations=20, seed=1)
    model = fit_ensemble(
        data.of_split("train"), "paper", members=4, steps=150, ablation="classifier"
    )
    spread = {}
    for split in ("train", "test"):
        found = predict(model, data.of_split(split))
        spread[split] = np.mean([i.p_valid_sd for i in found.items if i.type != "aggressive"])
    # 240 demonstrations each: 0.053 and 0.134 were seen, with other seeds 0.06 and 0.13 to 0.17.
    assert spread["test"] > 1.5 * spread["train"]


def test_resampled_scenes_keep_every_type_and_name_what_comes_again():
    data = colour_set(6, 3)
    d = data.demonstrations
    rare = d.type.copy()
    rare[(d.type == "any") & (d.scene_id != "s2")] = "sided"
    d.type = rare
    sizes = set()
    for seed in range(20):
        again = resampled(data, np.random.default_rng(seed))
        assert len(again.scenes) == 6
        assert len({s.scene_id for s in again.scenes}) == 6
        names = again.demonstrations.demo_id
        assert len(set(names)) == len(names)
        assert set(again.demonstrations.type) == {"sided", "any"}
        for i, name in enumerate(names):
            first = list(d.demo_id).index(name.partition("+")[0])
            np.testing.assert_array_equal(again.demonstrations.points(i), d.points(first))
            assert again.demonstrations.scene_id[i].partition("+")[0] == d.scene_id[first]
        sizes.add(len({s.scene_id.partition("+")[0] for s in again.scenes}))
    assert 6 > min(sizes) >= 1


def test_faults_are_named(tmp_path):
    data = colour_set(4, 4)
    for members in (0, 101, -1):
        with pytest.raises(InputError, match="members"):
            fit_model(data, "irl", members=members)
    with pytest.raises(InputError, match=r"scenes: .*two or more scenes"):
        fit_model(colour_set(1, 4), "irl", members=2)
    with pytest.raises(InputError, match="same types"):
        one, two = fit_model(data, "irl"), fit_model(data, "irl")
        two.types = ("other", "any")
        EnsembleModel([one, two], {})
    folder = fit_model(data, "irl", members=2).save(tmp_path / "m")
    config = json.loads((folder / "config.json").read_text())
    for change, says in (
        ({"members": [1, 2]}, r"settings\.members\.0"),
        ({"members": []}, "two or more members"),
        ({"members": [{"kind": "ensemble"}] * 2}, "kind"),
        ({"members": [{"kind": "irl", "settings": {}, "arrays": ["fog"]}] * 2}, r"0\.fog"),
    ):
        (folder / "config.json").write_text(json.dumps({**config, "settings": change}))
        with pytest.raises(InputError, match=says):
            load_model(folder)


def run(*arguments: object) -> None:
    with pytest.raises(SystemExit) as stopped:
        main([str(a) for a in arguments])
    assert stopped.value.code == 0


def test_the_commands_fit_an_ensemble_and_tell_its_spread(tmp_path, capsys):
    write_set(colour_set(3, 3), tmp_path / "set")
    run(
        "fit", tmp_path / "set", "--out", tmp_path / "m", "--model", "irl", "--members", 3, "--json"
    )
    assert json.loads(capsys.readouterr().out)["members"] == 3
    run("predict", tmp_path / "m", tmp_path / "set", "--json")
    entries = json.loads(capsys.readouterr().out)["predictions"]
    assert all(0 <= entry["p_valid_sd"] < 0.71 for entry in entries)
    run("predict", tmp_path / "m", tmp_path / "set")
    assert "spread" in capsys.readouterr().out
