"""Fragments of one thing are merged; things that only lie beside each other are not."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.perception import KINDS, load_network
from demospec.perception import level_sets as shapes
from demospec.perception.heads import PAIR_FEATURES, MergingHead, ObjectnessHead
from demospec.perception.inference import (
    HIGHEST,
    Segment,
    find_detections,
    merged,
    pairs,
    saddles,
    segments_in,
)

LONG = 5 + KINDS.index("long")
BLANK = np.full((3, 100, 100), 0.5, np.float32)


def answers_to(distance: np.ndarray, long: np.ndarray) -> np.ndarray:
    """(12, 100, 100): that distance; long things where asked, flat ones elsewhere."""
    out = np.zeros((12, 100, 100), np.float32)
    out[0] = distance
    out[5] = 3.0
    out[LONG] = np.where(long, 5.0, 0.0)
    return out


def ladle(offset_px: float, *, gap_px: float = 4.0) -> np.ndarray:
    """A round head at (30, 50); a handle to the right, moved off its axis by `offset_px`."""
    y, x = (np.mgrid[0:100, 0:100] + 0.5).astype(np.float32)
    head = np.hypot(x - 30, y - 50) - 5
    start = 35 + gap_px
    bar = shapes.capsule(x, y, start, 50 + offset_px, start + 30, 50 + offset_px, 1.2, 1.2)
    # Between them the network is unsure: nothing is seen, but little is missing.
    unsure = np.abs(shapes.capsule(x, y, 34, 50, start + 1, 50 + offset_px, 0.0, 0.0)) + 0.3
    return answers_to(np.minimum(np.minimum(head, bar), unsure), x > 36)


@pytest.fixture(scope="module")
def joiner() -> MergingHead:
    return MergingHead.of(load_network())


def slots_of(answers: np.ndarray, joiner: MergingHead) -> tuple:
    features, context = np.zeros((4, 52, 52), np.float32), np.zeros((4, 13, 13), np.float32)
    looks = 7 + 4 + 7 + 9 + 3 * 4
    one, none = np.ones(looks, np.float32), np.zeros((8, looks), np.float32)
    judge = ObjectnessHead(none[0], one, none, none[:, 0])
    return find_detections(answers, features, context, BLANK, (100, 100), judge, joiner)


def test_a_handle_is_joined_to_the_head_it_points_at(joiner):
    answers = ladle(0.0)
    before = answers.copy()
    (detection,) = slots_of(answers, joiner)
    assert detection.elongation > 3
    assert detection.distance[49:51, 33:70].min(axis=0).max() < 0.5, (
        "the gap between them is bridged"
    )
    assert np.array_equal(answers, before)
    never = MergingHead(
        np.zeros(PAIR_FEATURES), np.ones(PAIR_FEATURES), np.zeros(PAIR_FEATURES), -9.0
    )
    assert len(slots_of(answers, never)) == 2


def test_a_bar_beside_a_plate_stays_apart(joiner):
    y, x = (np.mgrid[0:100, 0:100] + 0.5).astype(np.float32)
    plate = np.hypot(x - 40, y - 50) - 18
    bar = shapes.capsule(x, y, 62, 30, 62, 75, 1.2, 1.2)
    assert len(slots_of(answers_to(np.minimum(plate, bar), x > 60), joiner)) == 2


def test_saddles_are_the_lowest_ways():
    """Against paths of least greatest value, by union-find over sorted pixels."""
    rng = np.random.default_rng(3)
    from scipy.ndimage import gaussian_filter

    for _ in range(5):
        field = gaussian_filter(rng.normal(size=(100, 100)), 3).astype(np.float32)
        field = field / field.std() * 1.5 + 1.0
        parts = segments_in(answers_to(field, field < 9), BLANK)
        found = saddles(parts, answers_to(field, field < 9))
        exact = lowest_ways(field, [p.rim[0] - 0.5 for p in parts])
        low = exact < HIGHEST - 0.1
        assert low.any()
        gap = found[low] - exact[low]
        assert (gap > -1e-5).all()
        assert (gap < 0.11).all()
        assert np.isinf(found[exact > HIGHEST]).all()


def lowest_ways(field: np.ndarray, points: list[np.ndarray]) -> np.ndarray:
    height, width = field.shape
    parent = np.arange(field.size)

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    seeds = [int(y) * width + int(x) for x, y in points]
    out = np.full((len(seeds), len(seeds)), np.inf)
    done = np.zeros(field.size, bool)
    for flat in np.argsort(field, axis=None):
        done[flat] = True
        r, c = divmod(int(flat), width)
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                if 0 <= r + dr < height and 0 <= c + dc < width:
                    other = (r + dr) * width + c + dc
                    if done[other] and root(other) != root(int(flat)):
                        parent[root(other)] = root(int(flat))
        if field.flat[flat] > HIGHEST:
            break
        roots = [root(s) if done[s] else -1 - k for k, s in enumerate(seeds)]
        for i, a in enumerate(roots):
            for j, b in enumerate(roots):
                if i != j and a == b:
                    out[i, j] = min(out[i, j], field.flat[flat])
    return out


def test_order_of_the_parts_does_not_matter(joiner):
    answers = ladle(0.0)
    parts = segments_in(answers, BLANK)
    assert len(parts) == 2
    for order in (parts, parts[::-1]):
        ((members, bridges),) = merged(order, answers, joiner)
        assert sorted(members) == [0, 1]
        assert len(bridges) == 1
    ahead = [f for _, _, f in pairs(parts, answers)]
    back = [f for _, _, f in pairs(parts[::-1], answers)]
    assert np.allclose(ahead, back)


def test_a_lone_part_has_no_partner(joiner):
    y, x = (np.mgrid[0:100, 0:100] + 0.5).astype(np.float32)
    answers = answers_to(np.hypot(x - 30, y - 50) - 5, x > 200)
    (part,) = segments_in(answers, BLANK)
    assert isinstance(part, Segment)
    assert merged([part], answers, joiner) == [([0], [])]
    assert merged([], answers, joiner) == []
