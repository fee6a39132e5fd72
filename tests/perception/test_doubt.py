"""Doubt: larger where distances err more, the usual where weights know none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import spearmanr

from demospec.demonstrations import simulate_set
from demospec.perception import arrays_of, load_network, network_of, observe
from demospec.perception.heads import uncertainty_map
from demospec.perception.training import paint
from demospec.specification import PerceivedObject, fit_model


def test_distances_err_more_where_the_body_doubts() -> None:
    """Pictures that neither the network nor its doubt was shown; within 6 px of a rim."""
    doubts, errors = [], []
    for picture, planes in zip(*paint(9_000_018, 0, 40, 160), strict=True):
        observation = observe(picture, scale=1.0)
        exact = planes[0].astype(float)
        near = np.abs(exact) < 6
        doubts.append(observation.uncertainty[near])
        errors.append(np.abs(observation.answers[0] - exact)[near])
    doubt, error = np.concatenate(doubts), np.concatenate(errors)
    low, high = np.quantile(doubt, [0.25, 0.75])
    assert error[doubt > high].mean() > 3 * error[doubt < low].mean()
    assert spearmanr(doubt, error).statistic > 0.3
    # A guard: the same doubts in another order say nothing.
    shuffled = np.random.default_rng(0).permutation(doubt)
    assert abs(spearmanr(shuffled, error).statistic) < 0.05


@pytest.mark.parametrize("size", [(100, 100), (57, 133), (400, 300)])
def test_weights_without_doubt_doubt_as_usual(size: tuple[int, int]) -> None:
    network = load_network()
    state = {k: v for k, v in arrays_of(network).items() if not k.startswith("doubt.")}
    plain = network_of(state, dict(vars(network.size)))
    pixels = np.random.default_rng(1).integers(0, 255, (size[1], size[0], 3)).astype(np.uint8)
    observation = observe(pixels, network=plain)
    assert observation.uncertainty.shape == observation.distance.shape
    assert (observation.uncertainty == 1.0).all()
    assert observe(pixels, network=network).uncertainty.shape == observation.distance.shape


def test_doubt_lies_where_the_features_lie() -> None:
    """One strong feature in an odd-sized picture: the doubt peaks at its pixel."""
    network = network_of(arrays_of(load_network()), dict(vars(load_network().size)))
    for parameter in network.uncertainty.parameters():
        parameter.data.zero_()
    network.uncertainty[0].weight.data[0, 0, 1, 1] = 1.0
    network.uncertainty[2].weight.data[0, 0, 1, 1] = 1.0
    features = np.zeros((network.size.half, 40, 48), np.float32)  # 77 × 93 px, padded to 80 × 96
    features[0, 11, 30] = 2.0
    found = uncertainty_map(network, features, (93, 77))
    row, column = np.unravel_index(found.argmax(), found.shape)
    # Feature (11, 30) covers padded pixels 22 to 23 and 60 to 61; 1 px of padding lies before.
    assert row in (21, 22)
    assert column in (59, 60)
    assert found.max() > 2.0
    assert np.median(found) == 1.0


def test_a_part_is_as_uncertain_as_it_is_doubted() -> None:
    blank = np.zeros((2, 3), np.float32)
    plain = PerceivedObject(blank, {}, 0.4, (0.0, 0.0), False)
    assert plain.errors == 0.4
    doubt = np.array([[1, 2, 4], [0.5, 1, 1]], np.float32)
    np.testing.assert_allclose(
        PerceivedObject(blank, {}, 0.4, (0.0, 0.0), False, doubt).errors, 0.4 * doubt
    )


def test_a_path_beside_what_is_doubted_is_judged_less_surely() -> None:
    data, _ = simulate_set(train_scenes=6, test_scenes=4, demonstrations=6, seed=3)
    model = fit_model(data.of_split("train"), "field", seed=0)
    checked = 0
    for scene in data.of_split("test").scenes:
        view = model.see(scene, use_lists=False)
        for part in view.perceived:
            errors = part.errors
            assert errors.shape == part.distance.shape
            assert errors.min() > 0.05 * max(view.size) / 100
            # Where doubt is greater at the same distance, the logit is nearer to zero.
            ring = np.abs(part.distance - 5.0) < 0.4
            if ring.sum() < 20:
                continue
            logit = view.map_of("careful").values[ring]
            alone = (
                np.min([p.distance for p in view.perceived], axis=0)[ring] == part.distance[ring]
            )
            if alone.sum() < 20:
                continue
            distance = part.distance[ring][alone]

            def beside(values: np.ndarray, given: np.ndarray = distance) -> np.ndarray:
                """What of the values the distance does not explain."""
                line = np.stack([np.ones_like(given), given], axis=1)
                return values - line @ np.linalg.lstsq(line, values, rcond=None)[0]

            doubt, verdict = beside(errors[ring][alone]), beside(logit[alone])
            assert spearmanr(doubt, verdict).statistic < -0.5
            checked += 1
    assert checked >= 3
