"""A detection's distance is to that thing alone, over the other things too."""

import numpy as np

from demospec.perception.heads import PAIR_FEATURES, MergingHead, ObjectnessHead
from demospec.perception.inference import find_detections

NONE = np.zeros(PAIR_FEATURES)
NEVER = MergingHead(NONE, NONE + 1, NONE, -9.0)


def test_distance_to_one_thing_is_right_over_another():
    y, x = np.mgrid[0:100, 0:100] + 0.5
    first = np.hypot(x - 20, y - 30) - 9
    second = np.hypot(x - 70, y - 60) - 6
    answers = np.zeros((12, 100, 100), np.float32)
    answers[0] = np.minimum(first, second)
    features, context = np.zeros((4, 52, 52), np.float32), np.zeros((4, 13, 13), np.float32)
    planes = np.full((3, 100, 100), 0.5, np.float32)
    looks, words = 7 + 4 + 7 + 9 + 3 * 4, 8
    one, none = np.ones(looks, np.float32), np.zeros((words, looks), np.float32)
    neutral = ObjectnessHead(none[0], one, none, none[:, 0])
    detections = find_detections(answers, features, context, planes, (100, 100), neutral, NEVER)
    assert len(detections) == 2
    for detection, exact in zip(detections, (first, second), strict=True):
        assert np.abs(detection.distance - exact).max() < 0.5


def test_near_the_answers_count_and_far_off_the_rim():
    """A faint handle: no rim of its own, but lower answers on its side."""
    y, x = np.mgrid[0:100, 0:100] + 0.5
    disc = np.hypot(x - 40, y - 50) - 8
    bump = 0.8 * np.exp(-((x - 51) ** 2 + (y - 50) ** 2) / 4.0)
    answers = np.zeros((12, 100, 100), np.float32)
    answers[0] = disc - np.where(disc > 1.7, bump, 0.0)
    features, context = np.zeros((4, 52, 52), np.float32), np.zeros((4, 13, 13), np.float32)
    planes = np.full((3, 100, 100), 0.5, np.float32)
    looks, words = 7 + 4 + 7 + 9 + 3 * 4, 8
    one, none = np.ones(looks, np.float32), np.zeros((words, looks), np.float32)
    neutral = ObjectnessHead(none[0], one, none, none[:, 0])
    (detection,) = find_detections(answers, features, context, planes, (100, 100), neutral, NEVER)
    near = (disc > 0) & (disc < 2.5)
    np.testing.assert_allclose(detection.distance[near], answers[0][near], atol=0.02)
    far = disc > 13.5
    assert np.abs(detection.distance - disc)[far].max() < 0.3  # whatever is answered there
    answers[0][far] = 9.0
    (other,) = find_detections(answers, features, context, planes, (100, 100), neutral, NEVER)
    np.testing.assert_array_equal(other.distance[far], detection.distance[far])
    inside = disc < -1
    assert (detection.distance[inside] < 0).all()
