"""Prediction and scoring against labels, with formulas in the place of models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, bezier_points
from demospec.errors import CannotJudgeError, InputError
from demospec.specification import evaluate, predict, wilson_interval
from demospec.specification.evaluation import clustered_interval, score
from demospec.testing import DiscModel, disc_scene


def disc_set(n: int = 20, *, types: tuple[str | None, ...] = ("careful",)) -> DemonstrationSet:
    scenes = (
        disc_scene((50, 50, 12)),
        replace(disc_scene((30, 40, 8), (70, 60, 8)), scene_id="two"),
        replace(disc_scene(), scene_id="unlisted", objects=None),
    )
    rng = np.random.default_rng(0)
    model = DiscModel()
    items = []
    for scene in scenes:
        for k in range(n):
            path = bezier_points((10.0, 90.0), (90.0, 10.0), rng.uniform(0, 100, 2), 60)
            type_ = types[k % len(types)]
            valid = None
            if scene.objects is not None:
                valid = bool(model.see(scene).logits(path[None], type_ or "careful")[0] > 0)
            name = f"{scene.scene_id}-{k}"
            items.append(Demonstration(name, scene.scene_id, path, type_, "p", valid))
    return DemonstrationSet(
        scenes, Demonstrations.of(items), types=("careful", "bold"), symbols=("glass",)
    )


def test_predict_answers_for_every_demonstration_and_never_reads_labels():
    data = disc_set(types=("careful", None))
    answer = predict(DiscModel(), data)
    blind = data.demonstrations.rows(np.arange(len(data.demonstrations)))
    blind.valid = np.full(len(blind), -1, np.int8)
    assert predict(DiscModel(), replace(data, demonstrations=blind)).items == answer.items
    assert list(dict.fromkeys(p.demo_id for p in answer.items)) == list(data.demonstrations.demo_id)
    both = [p.type for p in answer.items if p.demo_id == "discs-1"]
    assert both == ["careful", "bold"]
    assert list(answer.unjudged) == ["unlisted"]
    nulls = [p for p in answer.items if p.p_valid is None]
    assert {p.scene_id for p in nulls} == {"unlisted"}
    assert all(p.p_valid in (0.0, 1.0) for p in answer.items if p.scene_id != "unlisted")


def test_predict_refuses_where_no_scene_can_be_judged():
    data = disc_set()
    rows = data.demonstrations.scene_id == "unlisted"
    with pytest.raises(CannotJudgeError, match="unlisted"):
        predict(DiscModel(), data.select(rows))


def test_evaluate_a_model_that_made_the_labels_is_perfect_and_says_what_is_left_out():
    data = disc_set(types=("careful", "bold"))
    answer = evaluate(DiscModel(), data, truth=DiscModel())
    careful, bold = answer.types["careful"], answer.types["bold"]
    assert careful.balanced_accuracy == 1.0
    assert bold.balanced_accuracy is None
    assert bold.accuracy == bold.majority == 1.0
    assert answer.left_out == 20  # the unlisted scene has no labels
    assert answer.far["careful"].n < careful.n
    document = answer.to_json()
    assert document["types"]["bold"]["balanced_accuracy"] is None
    assert document["types"]["careful"]["far"]["accuracy"] == 1.0
    with pytest.raises(InputError, match="valid"):
        evaluate(DiscModel(), data.select(data.demonstrations.valid < 0))


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.tuples(st.booleans(), st.booleans(), st.integers(0, 5)), min_size=1, max_size=60)
)
def test_scores_equal_their_definition(rows):
    right, valid, scene = (np.array(column) for column in zip(*rows, strict=True))
    found = score(right, valid, scene)
    assert found.accuracy == pytest.approx(right.mean())
    assert found.majority == pytest.approx(max(valid.mean(), 1 - valid.mean()))
    if valid.all() or not valid.any():
        assert found.balanced_accuracy is None
        centre = found.accuracy
    else:
        want = (right[valid].mean() + right[~valid].mean()) / 2
        assert found.balanced_accuracy == pytest.approx(want)
        centre = want
    low, high = found.interval
    assert 0 <= low <= centre + 1e-9
    assert centre - 1e-9 <= high <= 1


def test_wilson_is_the_known_interval():
    # Newcombe 1998, table I: 81 of 263 → 0.2553 to 0.3662.
    low, high = wilson_interval(81 / 263, 263)
    assert (round(low, 4), round(high, 4)) == (0.2553, 0.3662)


@pytest.mark.parametrize("within", [0.0, 0.8])
def test_interval_covers_the_truth_for_demonstrations_that_hang_together(within):
    rng = np.random.default_rng(0)
    p, scenes, each, runs = 0.7, 20, 8, 400
    hits = 0
    for _ in range(runs):
        common = rng.random(scenes) < p
        own = rng.random((scenes, each)) < p
        copies = rng.random((scenes, each)) < np.sqrt(within)
        right = np.where(copies, common[:, None], own).ravel()
        low, high = clustered_interval(right, np.repeat(np.arange(scenes), each))
        hits += low <= p <= high
    # 95 % nominal; 400 runs have a standard error of 1.1 points.
    assert 0.90 <= hits / runs <= 0.995
