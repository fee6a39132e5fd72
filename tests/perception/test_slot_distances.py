"""A slot's distance is to that thing alone, over the other things too."""

import numpy as np

from demospec.perception._fragments import PAIR_FEATURES, Joiner
from demospec.perception._judge import SlotJudge
from demospec.perception._slots import find_slots

NONE = np.zeros(PAIR_FEATURES)
NEVER = Joiner(NONE, NONE + 1, NONE, -9.0)


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
    neutral = SlotJudge(none[0], one, none, none[:, 0])
    slots = find_slots(answers, features, context, planes, (100, 100), neutral, NEVER)
    assert len(slots) == 2
    for slot, exact in zip(slots, (first, second), strict=True):
        assert np.abs(slot.distance - exact).max() < 0.5
