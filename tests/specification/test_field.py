"""The field model: guards against fooling oneself, files, order of the types, gradients."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet, bezier_points, simulate_set
from demospec.errors import CannotJudgeError, InputError
from demospec.scene import Picture
from demospec.specification import ControlPlane, evaluate, fit_model, load_model
from demospec.specification.models import is_nested_in
from demospec.testing import with_labels

pytest.importorskip("torch", reason="torch comes with demospec[vision]")

FILES = ("config.json", "weights.safetensors", "provenance.json")


@pytest.fixture(scope="module")
def data() -> DemonstrationSet:
    return simulate_set(train_scenes=8, test_scenes=8, demonstrations=12, seed=7)[0]


@pytest.fixture(scope="module")
def model(data):
    return fit_model(data.of_split("train"), "field", seed=0)


def unlisted(data: DemonstrationSet, pictures: list[Picture | None] | None = None):
    """The set without lists of objects, with other pictures if given."""
    pictures = pictures or [s.picture for s in data.scenes]
    scenes = tuple(
        replace(s, objects=None, picture=p) for s, p in zip(data.scenes, pictures, strict=True)
    )
    return replace(data, scenes=scenes)


def balanced(model, data: DemonstrationSet, type_: str = "careful") -> float:
    value = evaluate(model, data).types[type_].balanced_accuracy
    assert value is not None
    return value


def test_judges_unseen_scenes_from_their_pictures_alone(model, data):
    assert balanced(model, unlisted(data.of_split("test"))) > 0.85


def test_judges_unseen_scenes_from_their_lists(model, data):
    assert balanced(model, data.of_split("test")) > 0.93
    assert balanced(model, data.of_split("test"), "normal") > 0.93


def test_guard_shuffled_labels_teach_nothing(data):
    rng = np.random.default_rng(3)
    train = data.of_split("train")
    d = train.demonstrations
    valid = d.valid.copy()
    for type_ in data.types:
        mine = np.flatnonzero(d.type == type_)
        valid[mine] = rng.permutation(valid[mine])
    shuffled = fit_model(with_labels(train, valid), "field", seed=0)
    assert abs(balanced(shuffled, unlisted(data.of_split("test"))) - 0.5) < 0.12


def test_guard_a_blank_picture_says_nothing(model, data):
    test = data.of_split("test")
    blank = Picture(array=np.full((100, 100, 3), 128, np.uint8))
    assert abs(balanced(model, unlisted(test, [blank] * len(test.scenes))) - 0.5) < 0.05


def test_guard_swapped_pictures_destroy_most_of_the_verdict(model, data):
    test = data.of_split("test")
    pictures = [s.picture for s in test.scenes]
    own = balanced(model, unlisted(test))
    other = balanced(model, unlisted(test, pictures[1:] + pictures[:1]))
    # A path that bends far out of the picture is valid in any scene: not quite one half.
    assert other < 0.68
    assert other < own - 0.15


@pytest.mark.parametrize("listed", [True, False])
def test_a_type_that_cares_less_accepts_whatever_the_careful_one_accepts(model, data, listed):
    rng = np.random.default_rng(0)
    for scene in data.of_split("test").scenes[:3]:
        plane = ControlPlane(model.see(scene, use_lists=listed))
        controls = rng.uniform(-20, 120, (400, 1, 2))
        careful, normal, bold = (plane.logits(controls, t) > 0 for t in data.types)
        assert (careful & ~normal).mean() < 0.01
        assert (normal & ~bold).sum() == 0


@pytest.mark.parametrize("order", [2, 3, 4])
@pytest.mark.parametrize("listed", [True, False])
def test_gradient_in_the_control_points_is_the_difference_quotient(model, data, order, listed):
    scene = data.of_split("test").scenes[0]
    plane = ControlPlane(model.see(scene, use_lists=listed), order=order)
    rng = np.random.default_rng(order)
    controls = rng.uniform(10, 90, (30, order - 1, 2))
    direction = rng.normal(size=controls.shape)
    _, slope = plane.logits_and_gradients(controls, "careful")
    assert np.isfinite(slope).all()
    assert (np.abs(slope).sum(axis=(1, 2)) > 0).all()
    h = 2e-3
    high = plane.logits(controls + h * direction, "careful")
    low = plane.logits(controls - h * direction, "careful")
    quotient = (high - low) / (2 * h)
    found = (slope * direction).sum(axis=(1, 2))
    gap = np.abs(found - quotient) / (1.0 + np.abs(quotient))
    # A map read bilinearly has kinks between its pixels: a few curves stand on one.
    assert np.median(gap) < 0.02
    assert np.mean(gap > 0.15) < 0.15


def test_gradient_along_polylines_of_few_points(model, data):
    scene = data.of_split("test").scenes[1]
    view = model.see(scene, use_lists=False)
    rng = np.random.default_rng(1)
    paths = rng.uniform(10, 90, (20, 5, 2))
    _, slope = view.logits_and_gradients(paths, "careful")
    direction = rng.normal(size=paths.shape)
    h = 2e-3
    high = view.logits(paths + h * direction, "careful")
    low = view.logits(paths - h * direction, "careful")
    quotient = (high - low) / (2 * h)
    gap = np.abs((slope * direction).sum(axis=(1, 2)) - quotient) / (1.0 + np.abs(quotient))
    assert np.median(gap) < 0.02
    assert np.mean(gap > 0.15) < 0.15


def test_the_number_of_points_does_not_matter(model, data):
    view = model.see(data.of_split("test").scenes[0], use_lists=False)
    control = np.random.default_rng(2).uniform(0, 100, (200, 1, 2))
    ends = np.array(view.scene.start[:2]), np.array(view.scene.goal[:2])
    few, many = (
        view.logits(bezier_points(np.tile(ends[0], (200, 1)), ends[1], control, n), "careful")
        for n in (60, 400)
    )
    assert np.mean((few > 0) != (many > 0)) < 0.01
    assert np.abs(few - many).mean() < 0.05


def test_saved_and_loaded_models_agree_and_the_same_seed_gives_the_same_bytes(
    model, data, tmp_path
):
    again = fit_model(data.of_split("train"), "field", seed=0)
    model.save(tmp_path / "a")
    again.save(tmp_path / "b")
    for file in FILES:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    loaded = load_model(tmp_path / "a")
    scene = data.of_split("test").scenes[0]
    paths = data.of_split("test").demonstrations.paths_xy()[:20]
    for listed in (True, False):
        one, two = model.see(scene, use_lists=listed), loaded.see(scene, use_lists=listed)
        for type_ in data.types:
            np.testing.assert_array_equal(one.logits(paths, type_), two.logits(paths, type_))


def test_a_set_without_lists_is_fitted_on_what_is_seen(data):
    blind = fit_model(unlisted(data.of_split("train")), "field", seed=0)
    assert balanced(blind, unlisted(data.of_split("test"))) > 0.65


def test_a_set_without_pictures_is_fitted_on_its_lists_and_cannot_see(data):
    train = data.of_split("train")
    bare = replace(train, scenes=tuple(replace(s, picture=None) for s in train.scenes))
    model = fit_model(bare, "field", seed=0)
    assert balanced(model, data.of_split("test")) > 0.93
    with pytest.raises(CannotJudgeError):
        model.see(replace(data.scenes[0], objects=None))


def test_pictures_of_another_size_mean_the_same(model, data):
    import PIL.Image

    scene = data.of_split("test").scenes[0]
    from_set = fit_model(data.of_split("train"), "field", seed=0)
    from_set.scale = None  # the longer side of a picture is a hundred map pixels
    large = np.asarray(PIL.Image.fromarray(scene.pixels()).resize((200, 200)))
    big = replace(
        scene,
        picture=Picture(array=large),
        objects=None,
        start=tuple(2 * v for v in scene.start),
        goal=tuple(2 * v for v in scene.goal),
    )
    one = model.see(scene, use_lists=False)
    two = from_set.see(big)
    assert two.size == (200.0, 200.0)
    assert abs(len(one.perceived) - len(two.perceived)) <= 2


def test_any_type_names(data):
    names = {"careful": "ärztin", "normal": "type 2", "aggressive": "Z"}
    train = data.of_split("train")
    rows = train.demonstrations.rows(np.arange(len(train.demonstrations)))
    rows.type = np.array([names[t] for t in rows.type], dtype=object)
    renamed = replace(train, demonstrations=rows, types=tuple(names.values()))
    model = fit_model(renamed, "field", seed=0)
    assert set(model.types) == set(names.values())
    assert model.rules.of_type("type 2").clearance.relevant == ("glass",)


def test_an_unknown_setting_is_refused(data):
    with pytest.raises(InputError, match="fine_tune"):
        fit_model(data.of_split("train"), "field", speed=3)


@pytest.mark.slow
def test_tuning_leaves_the_shipped_network_alone_and_brings_it_nearer_to_the_outlines(data):
    from demospec.perception import arrays_of, load_network, observe
    from demospec.perception.training import TuneSettings, tuned_network

    torch = pytest.importorskip("torch")
    scenes = list(data.of_split("train").scenes)[:4]
    network = load_network()
    before = {k: v.clone() for k, v in arrays_of(network).items()}
    settings = TuneSettings(steps=30, batch=4, generated=8, lr=1e-4)
    tuned = tuned_network(network, scenes, 1.6, seed=0, settings=settings)
    assert all(torch.equal(v, before[k]) for k, v in arrays_of(network).items())

    def miss(which) -> float:
        """Mean error of the distance, weighted towards the rims as in training."""
        y, x = np.mgrid[0:100, 0:100] + 0.5
        places = np.stack([x, y], axis=-1)
        total, weights = 0.0, 0.0
        for scene in scenes:
            exact = np.min([o.outline.signed_distance(places) for o in scene.objects], axis=0)
            seen = observe(scene.pixels(), network=which, scale=1.6, turns=(0,))
            weight = (np.abs(exact) < 30) / (1.0 + np.abs(1.6 * exact) / 3.0)
            total += float((weight * np.abs(seen.distance_at(places) - exact)).sum())
            weights += float(weight.sum())
        return total / weights

    assert miss(tuned) < miss(network)
    again = tuned_network(network, scenes, 1.6, seed=0, settings=settings)
    assert miss(again) == miss(tuned)


def test_nested_types_are_nested_in_every_scene_that_is_only_seen(model, data):
    # Between classes that nobody is sure of, mean clearances could say otherwise.
    careful, normal = (model.rules.of_type(t) for t in ("careful", "normal"))
    assert is_nested_in(normal, careful)
    assert not is_nested_in(careful, normal)
    rng = np.random.default_rng(1)
    for scene in data.of_split("test").scenes:
        plane = ControlPlane(model.see(scene, use_lists=False))
        controls = rng.uniform(-20, 120, (200, 1, 2))
        strict, loose = (plane.logits(controls, t) for t in ("careful", "normal"))
        assert (loose >= strict - 1e-5).all()
