"""Interventions on pictures: where they change pixels, and that list and picture agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.causal import Settings, editor_for, estimate, trials_of_set
from demospec.demonstrations import simulate_set
from demospec.rules import rules_from_document
from demospec.scene import Editor, Picture, cut_out


@pytest.fixture(scope="module")
def simulated():  # type: ignore[no-untyped-def]
    """(set, truth): six composed scenes."""
    return simulate_set(seed=11, train_scenes=6, test_scenes=0, demonstrations=1)


@pytest.fixture(scope="module")
def photographs(simulated):  # type: ignore[no-untyped-def]
    """The same pictures without a word on how they were made: a user's own."""
    return tuple(replace(s, recipe=None) for s in simulated[0].scenes)


def changed(before, after):  # type: ignore[no-untyped-def]
    return (before.pixels() != after.pixels()).any(axis=2)


def far_from(scene, center, radius):  # type: ignore[no-untyped-def]
    h, w = scene.pixels().shape[:2]
    x, y = np.meshgrid(np.arange(w) + 0.5, np.arange(h) + 0.5)
    return np.hypot(x - center[0], y - center[1]) > radius


def test_catalogue_items_change_only_their_place(simulated) -> None:  # type: ignore[no-untyped-def]
    data, _ = simulated
    editor = editor_for(data.scenes)
    scene = data.scenes[0]
    for symbol in data.symbols:
        thing = editor.templates(symbol, scene)[0]
        after = thing.put(scene, (50.0, 30.0), 0.7)
        radius = thing.radius_px(scene)
        assert len(after.objects) == len(scene.objects) + 1
        new = after.objects[-1]
        assert new.symbol == symbol
        assert np.hypot(*(np.asarray(new.center) - (50, 30))) < 1
        difference = changed(scene, after)
        assert difference.sum() > 10
        assert not difference[far_from(scene, (50, 30), 2 * radius + 15)].any()
        x0, y0, x1, y1 = new.outline.bounds
        assert max(x1 - x0, y1 - y0) <= 2 * radius + 1e-6


def test_train_scenes_get_train_items(simulated) -> None:  # type: ignore[no-untyped-def]
    data, _ = simulated
    editor = Editor(data.scenes)
    train = {t.name for t in editor.templates("glass", data.scenes[0])}
    test = {t.name for t in editor.templates("glass", replace(data.scenes[0], split="test"))}
    assert train
    assert test
    assert not train & test


def test_user_pictures_get_cut_outs_of_their_own_objects(photographs) -> None:  # type: ignore[no-untyped-def]
    editor = Editor(photographs)
    source = next(s for s in photographs for o in s.objects if o.symbol == "glass")
    glass = next(o for o in source.objects if o.symbol == "glass")
    assert all("cut from scene" in t.name for t in editor.templates("glass", photographs[0]))
    target = photographs[-1]
    after = cut_out(source, glass.id).laid(target, (30.0, 20.0), "new")
    new = after.objects[-1]
    shift = np.round(np.asarray(new.center) - glass.center).astype(int)
    assert np.allclose(np.asarray(new.center) - glass.center, shift)  # whole pixels
    # Well inside the outline the pixels are the glass's own.
    x, y = np.meshgrid(np.arange(100) + 0.5, np.arange(100) + 0.5)
    inside = new.outline.signed_distance(np.stack([x, y], axis=-1)) < -1.0
    assert inside.sum() > 10
    moved = np.roll(source.pixels(), (shift[1], shift[0]), axis=(0, 1))
    assert np.array_equal(after.pixels()[inside], moved[inside])
    assert not changed(target, after)[far_from(target, new.center, 20)].any()


def test_a_symbol_that_no_picture_shows_comes_from_the_catalogue(photographs) -> None:  # type: ignore[no-untyped-def]
    editor = Editor(photographs, metres_per_unit=0.0082)
    things = editor.templates("drill", photographs[0])
    assert things
    assert all(t.name.startswith("builtin/") for t in things)
    assert not Editor(photographs, source="cutouts").templates("drill", photographs[0])
    assert not editor.templates("unicorn", photographs[0])


def test_moving_a_cut_out_keeps_its_name_and_frees_its_place(photographs) -> None:  # type: ignore[no-untyped-def]
    editor = Editor(photographs)
    scene = photographs[0]
    item = scene.objects[0]
    to = (50.0, 8.0) if np.hypot(item.center[0] - 50, item.center[1] - 8) > 30 else (50.0, 92.0)
    after = editor.move(scene, item.id, to)
    assert sorted(o.id for o in after.objects) == sorted(o.id for o in scene.objects)
    new = next(o for o in after.objects if o.id == item.id)
    assert np.hypot(*(np.asarray(new.center) - to)) < 1
    difference = changed(scene, after)
    for center in (item.center, new.center):
        assert difference[~far_from(scene, center, 3)].any()


def test_the_placebo_changes_the_picture_and_not_the_list(simulated) -> None:  # type: ignore[no-untyped-def]
    data, _ = simulated
    editor = editor_for(data.scenes)
    found = 0
    for scene in data.scenes:
        after = editor.placebo(scene, (50.0, 25.0), np.random.default_rng(0))
        if after is not None:
            found += changed(scene, after).any()
            assert after.objects == scene.objects
    assert found >= 4


def test_a_model_that_sees_patches_of_table_is_not_trusted(formula_model, simulated) -> None:  # type: ignore[no-untyped-def]
    """A placebo that moves the model is called out in the notes and in the sentences."""
    data, _ = simulated
    originals = {s.scene_id: s.pixels() for s in data.scenes}

    def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
        touched = not np.array_equal(scene.pixels(), originals[scene.scene_id])
        return np.full(len(paths), 0.4 if touched else 0.9)

    settings = Settings(placements=2, draws=5)
    table = trials_of_set(formula_model(formula), data, settings=settings)
    found = estimate(table, settings)
    assert not found.placebo_is_null
    assert found.placebo[0].effect == pytest.approx(-0.5)
    assert any("not to be trusted" in n for n in found.notes)
    assert any(s.startswith("Warning") for s in found.sentences)


def test_hidden_lists_leave_the_model_with_pictures_alone(formula_model, simulated) -> None:  # type: ignore[no-untyped-def]
    data, _ = simulated

    def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
        assert scene.objects is None
        assert scene.recipe is None
        return np.full(len(paths), scene.pixels().mean() / 255)

    settings = Settings(placements=1, draws=3, hide_lists=True)
    table = trials_of_set(formula_model(formula), data, settings=settings)
    assert len(table.trials) >= 6 * 4


def test_pictures_and_lists_lead_to_the_same_table(simulated) -> None:  # type: ignore[no-untyped-def]
    data, document = simulated
    truth = rules_from_document(document)
    settings = Settings(placements=2, draws=40)
    found = estimate(trials_of_set(truth, data, settings=settings), settings)
    assert found.placebo_is_null
    assert all(c.effect == 0 for c in found.effects if c.type == "aggressive")
    assert all(c.effect < 0 for c in found.effects if c.type == "careful")
    bare = replace(data, scenes=tuple(replace(s, picture=None, recipe=None) for s in data.scenes))
    lists = estimate(trials_of_set(truth, bare, settings=settings), settings)
    assert any(note.startswith("no pictures") for note in lists.notes)
    assert all(c.effect == 0 for c in lists.effects if c.type == "aggressive")


def test_notes_on_types_that_were_hardly_shown(simulated) -> None:  # type: ignore[no-untyped-def]
    data, document = simulated
    truth = rules_from_document(document)
    d = data.demonstrations
    keep = (d.type != "careful") | (d.scene_id == "0002")
    keep &= d.type != "aggressive"
    settings = Settings(placements=1, draws=5)
    table = trials_of_set(truth, data.select(keep), settings=settings)
    assert any("careful: demonstrated in one scene only (0002)" in n for n in table.notes)
    assert "aggressive: not demonstrated in these scenes" in table.notes


def test_pictures_larger_than_others_keep_their_own_frame(photographs) -> None:  # type: ignore[no-untyped-def]
    wide = np.full((60, 160, 3), 120, dtype=np.uint8)
    scene = replace(photographs[0], picture=Picture(array=wide), objects=())
    after = cut_out(photographs[0], photographs[0].objects[0].id).laid(scene, (150.0, 30.0), "new")
    assert after.pixels().shape == wide.shape


def test_scenes_without_lists_are_looked_at_for_free_places(formula_model, simulated) -> None:  # type: ignore[no-untyped-def]
    """What is put into a picture whose objects nobody listed must not cover one of them."""
    pytest.importorskip("torch", reason="the vision extra brings torch")
    data, _ = simulated
    blind = replace(data, scenes=tuple(replace(s, objects=None, recipe=None) for s in data.scenes))
    settings = Settings(placements=3, draws=3)
    model = formula_model(lambda scene, paths, type_: np.full(len(paths), 0.5))
    table = trials_of_set(model, blind, symbols=["glass"], settings=settings)
    assert any("6 of 6 scenes list no objects" in note for note in table.notes)
    added = [t for t in table.trials if t.intervention == "add"]
    assert len(added) == 18
    covered = [
        min(float(o.outline.signed_distance(t.center)) for o in data.scenes[t.scene].objects) < 2
        for t in added
    ]
    assert sum(covered) <= 1
