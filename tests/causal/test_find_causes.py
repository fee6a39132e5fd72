"""The analysis on object lists, where the truth is a formula."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.causal import Settings, estimate, find_causes, run_trials
from demospec.errors import CannotJudgeError, InputError
from demospec.scene import Disc, Picture, rectangle

SYMBOLS = ("utensil", "plate", "bowl", "glass")
QUICK = Settings(placements=3, draws=60)


def distances(paths, center):  # type: ignore[no-untyped-def]
    """(n,) from a point to densely sampled curves, without the library."""
    return np.sqrt(((paths - np.asarray(center)) ** 2).sum(axis=2)).min(axis=1)


def curves(scene, controls, n=2000):  # type: ignore[no-untyped-def]
    u = np.linspace(0, 1, n)[:, None]
    a, b = np.asarray(scene.start), np.asarray(scene.goal)
    return np.stack([(1 - u) ** 2 * a + 2 * u * (1 - u) * z + u**2 * b for z in controls])


def test_the_twelve_cells_are_right(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = find_causes(truth, scenes, settings=QUICK)
    assert len(found.effects) == 12
    assert set(found.relevant("careful")) == set(SYMBOLS)
    assert found.relevant("normal") == ("glass",)
    assert found.relevant("aggressive") == ()
    for cell in found.effects:
        assert cell.verdict == ("causal" if cell.causal else "none")
        assert cell.effect < 0 if cell.causal else cell.effect == 0
        assert cell.n_scenes == 20
        assert cell.interval is not None
        assert cell.interval[0] <= cell.effect <= cell.interval[1]
    assert found.placebo_is_null
    assert found.notes == ()
    assert all(pair.differ for pair in found.type_effects)
    base = {t: e.mean for t, e in found.base.items()}
    assert base["careful"] < base["normal"] < base["aggressive"] == 1.0


def test_effects_are_those_of_an_independent_recomputation(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    """From z_θ and places of the table: curves, distances and verdicts written out anew."""
    table = run_trials(truth, scenes[:4], ["glass"], ["careful"], settings=QUICK)
    wrong = total = 0
    for trial in table.trials:
        if trial.intervention in ("placebo", "unrelated"):
            assert np.array_equal(trial.after, table.before[trial.scene])
            continue
        scene = scenes[trial.scene]
        paths = curves(scene, table.controls[trial.scene])
        keeps = np.ones(len(paths), dtype=bool)
        for item in scene.objects:
            assert isinstance(item.footprint, Disc)
            keeps &= distances(paths, item.center) >= item.footprint.radius + 3.0
        wrong += (keeps != (table.before[trial.scene][0] > 0.5)).sum()
        keeps &= distances(paths, trial.center) >= 4.0 + 3.0
        wrong += (keeps != (trial.after[0] > 0.5)).sum()
        total += 2 * len(paths)
    assert total > 1000
    # The library samples the curves; a path within hundredths of the boundary may differ.
    assert wrong <= 0.003 * total


def test_effect_is_the_mean_over_scenes_of_means_within(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    table = run_trials(truth, scenes[:7], settings=QUICK)
    found = estimate(table, QUICK)
    for symbol in table.symbols:
        per_scene: dict[int, list[float]] = {}
        for trial in table.trials:
            if (trial.intervention, trial.symbol) == ("add", symbol):
                change = trial.after[0].mean() - table.before[trial.scene][0].mean()
                per_scene.setdefault(trial.scene, []).append(change)
        expected = np.mean([np.mean(v) for v in per_scene.values()])
        cell = found.effect(table.types[0], symbol)
        assert cell.effect == pytest.approx(expected)
        assert cell.after == pytest.approx(found.base[table.types[0]].mean + expected)


def test_paths_are_common_and_order_is_no_matter(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    few = scenes[:5]
    one = find_causes(truth, few, SYMBOLS, settings=QUICK)
    other = find_causes(truth, few[::-1], ["glass", "bowl"], ["normal", "careful"], settings=QUICK)
    for type_ in ("normal", "careful"):
        for symbol in ("glass", "bowl"):
            assert other.effect(type_, symbol).effect == pytest.approx(
                one.effect(type_, symbol).effect
            )
    assert find_causes(truth, few, SYMBOLS, settings=QUICK).effects == one.effects
    different = find_causes(truth, few, SYMBOLS, settings=replace(QUICK, seed=1))
    assert different.effects != one.effects


def test_small_responses_to_everything_are_no_causes(formula_model, truth, scenes) -> None:  # type: ignore[no-untyped-def]
    """Why there is a minimum effect: a paired test alone finds every little response."""

    def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
        p = truth.see(scene).p_valid(paths, "normal")
        return np.clip(0.9 * p + 0.08 - 0.01 * len(scene.objects), 0, 1)

    model = formula_model(formula)
    bold = find_causes(model, scenes, settings=replace(QUICK, minimum_effect=0.0))
    assert all(cell.causal for cell in bold.effects)
    found = find_causes(model, scenes, settings=QUICK)
    assert found.relevant("one") == ("glass",)
    assert {c.verdict for c in found.effects if c.symbol != "glass"} == {"none"}
    assert all(c.p_corrected < 0.05 for c in found.effects)


def test_verdicts_ignore_doubts_that_flip_nothing(formula_model, scenes) -> None:  # type: ignore[no-untyped-def]
    """Each object more costs a tenth of probability; only the third flips a verdict."""

    def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
        return np.full(len(paths), 0.95 - 0.1 * len(scene.objects))

    table = run_trials(formula_model(formula), scenes, ["glass"], settings=QUICK)
    soft = estimate(table, QUICK)
    hard = estimate(table, replace(QUICK, outcome="verdict"))
    assert soft.effects[0].effect == pytest.approx(-0.1)
    flips = np.mean([len(s.objects) == 4 for s in scenes])
    assert hard.effects[0].effect == pytest.approx(-flips)
    assert hard.settings.outcome == "verdict"


def test_large_but_uncertain_effects_are_undecided(formula_model, make_scene) -> None:  # type: ignore[no-untyped-def]
    def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
        odd = int(scene.scene_id) % 2
        added = len(scene.objects) - 4
        return np.full(len(paths), 0.5 + (0.4 if odd else -0.3) * added)

    scenes = [make_scene(4 * k + 3, f"{k:04d}") for k in range(10)]
    assert all(len(s.objects) == 4 for s in scenes)
    found = find_causes(formula_model(formula), scenes, ["glass"], settings=QUICK)
    cell = found.effects[0]
    assert cell.effect == pytest.approx(0.05)
    assert not cell.causal
    assert cell.verdict == "undecided"
    assert "undecided" in " ".join(found.sentences)


def test_types_that_accept_equally_many_other_paths_differ(formula_model, scenes) -> None:  # type: ignore[no-untyped-def]
    def formula(scene, paths, type_):  # type: ignore[no-untyped-def]
        middle = np.asarray(paths)[:, 32]
        left = (middle[:, 1] - 90) * 80 - (middle[:, 0] - 10) * -80 < 0
        return np.where(left, 1.0, 0.0) if type_ != "right" else np.where(left, 0.0, 1.0)

    model = formula_model(formula, ("left", "right", "west"))
    found = find_causes(model, scenes, settings=QUICK)
    pair = {(t.from_type, t.to_type): t for t in found.type_effects}
    assert pair["left", "right"].differ
    assert pair["left", "right"].disagreement.mean == 1.0
    assert abs(pair["left", "right"].effect) < 0.1
    assert not pair["left", "west"].differ
    assert pair["left", "west"].disagreement.mean == 0.0
    assert any("but not the same ones" in s for s in found.sentences)
    assert any("do not tell left and west apart" in s for s in found.sentences)


def test_removal_move_and_swap(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    settings = replace(QUICK, interventions=("add", "remove", "move", "swap"))
    found = find_causes(truth, scenes, settings=settings)
    others = {(c.intervention, c.type, c.symbol, c.onto): c for c in found.others}
    removed = others["remove", "normal", "glass", None]
    assert removed.effect > 0.05
    assert removed.causal
    assert others["remove", "normal", "bowl", None].effect == 0
    assert others["move", "normal", "bowl", None].changed == 0
    assert others["move", "normal", "glass", None].changed > 0.1
    swapped = others["swap", "normal", "glass", "utensil"]
    assert swapped.effect > 0.05
    with_plate = sum(any(o.symbol == "plate" for o in s.objects) for s in scenes)
    assert others["swap", "normal", "plate", "glass"].n_scenes == with_plate
    assert others["swap", "normal", "plate", "glass"].effect < 0
    assert others["swap", "aggressive", "plate", "glass"].effect == 0
    document = found.to_json()
    assert {c["intervention"] for c in document["others"]} == {"remove", "move", "swap"}
    assert all("onto" not in c for c in document["effects"])


def test_own_paths_instead_of_random_ones(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    bent = np.array([[10.0, 90.0], [10.0, 10.0], [90.0, 10.0]])
    straight = np.array([[10.0, 90.0], [90.0, 10.0]])
    paths = {s.scene_id: [bent, straight] for s in scenes}
    table = run_trials(truth, scenes, settings=QUICK, paths=paths)
    assert all(b.shape == (3, 2) for b in table.before)
    assert np.allclose(table.controls[0][1], [50, 50])


# What cannot be done is said.


def test_unknown_words_are_refused_with_the_known_ones(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=r"careful, normal, aggressive\), found reckless"):
        find_causes(truth, scenes, types=["reckless"])
    with pytest.raises(InputError, match="found vase"):
        find_causes(truth, scenes, ["glass", "vase"], settings=QUICK)
    with pytest.raises(InputError, match="at least one scene"):
        find_causes(truth, [])
    with pytest.raises(InputError, match="add, remove, move, swap, found burn"):
        Settings(interventions=("burn",))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="minimum_effect"):
        Settings(minimum_effect=1.5)
    with pytest.raises(InputError, match="placements"):
        Settings(placements=0)


def test_absent_symbols_are_skipped_aloud_where_allowed(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    table = run_trials(truth, scenes[:3], ["glass", "vase"], settings=QUICK, skip_absent=True)
    found = estimate(table, QUICK)
    assert "vase" in found.skipped
    assert any(note.startswith("vase: not added") for note in found.notes)
    assert any("vases" in s for s in found.sentences)
    assert found.to_json()["skipped"]["vase"]


def full_table(scene):  # type: ignore[no-untyped-def]
    """The scene with a cloth over all of it: room for nothing."""
    cloth = replace(scene.objects[0], id="cloth", symbol="cloth", center=(50.0, 50.0),
                    footprint=rectangle(0, 0, 100, 100))  # fmt: skip
    return replace(scene, objects=(*scene.objects, cloth))


def test_scenes_without_room_make_a_stated_smaller_n(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    some = [full_table(s) if i < 3 else s for i, s in enumerate(scenes[:12])]
    found = find_causes(truth, some, ["glass"], settings=QUICK)
    assert found.effect("normal", "glass").n_scenes == 9
    assert found.n_scenes == 12
    assert "glass: no room in 3 of 12 scenes (0000, 0001, 0002): n = 9" in found.notes
    assert any(note.startswith("placebo: no room in 3 of 12") for note in found.notes)


def test_no_room_anywhere_is_an_answer_without_numbers(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = find_causes(truth, [full_table(s) for s in scenes[:3]], ["glass"], settings=QUICK)
    cell = found.effects[0]
    assert cell.n_scenes == 0
    assert np.isnan(cell.effect)
    assert not cell.causal
    assert cell.verdict == "undecided"
    document = found.to_json()["effects"][0]
    assert document["effect"] is None
    assert document["interval"] is None
    assert "not applicable, the scenes have no pictures" in " ".join(found.sentences)


def test_a_placebo_that_found_no_room_is_said(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    bare = Picture(array=np.full((100, 100, 3), 200, dtype=np.uint8))
    tables = [replace(full_table(s), picture=bare) for s in scenes[:3]]
    found = find_causes(truth, tables, ["glass"], settings=QUICK)
    assert "No scene had room for the placebo" in " ".join(found.sentences)


def test_one_scene_gives_effects_without_claims(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = find_causes(truth, scenes[:1], settings=QUICK)
    assert all(c.interval is None and c.p is None and not c.causal for c in found.effects)
    assert found.effect("careful", "plate").effect < 0
    assert found.base["careful"].interval is None
    assert not any(t.differ for t in found.type_effects)


def test_too_few_scenes_to_be_significant_is_said(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    found = find_causes(truth, scenes[:4], settings=QUICK)
    assert not any(c.causal for c in found.effects)
    assert {c.verdict for c in found.effects} == {"undecided"}
    assert any("nothing can be significant" in note for note in found.notes)
    found = find_causes(truth, scenes[:7], settings=QUICK)
    assert any("cannot be significant after correction" in note for note in found.notes)


def test_scenes_that_cannot_be_judged_are_counted(truth, scenes) -> None:  # type: ignore[no-untyped-def]
    blind = [replace(s, objects=None) if i in (2, 5) else s for i, s in enumerate(scenes[:12])]
    found = find_causes(truth, blind, settings=QUICK)
    assert found.n_scenes == 10
    assert any("2 of 12 scenes could not be judged (0002, 0005)" in n for n in found.notes)
    with pytest.raises(CannotJudgeError, match="objects not listed"):
        find_causes(truth, [replace(s, objects=None) for s in scenes[:2]], ["glass"])
