"""Conformal verdicts: coverage over many sets, the smallest error rate, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest
from test_commands import document, run

from demospec.demonstrations import simulate_set, write_set
from demospec.errors import InputError
from demospec.specification import conformal
from demospec.specification.evaluation import pooled_quantile
from demospec.testing import colour_set


def test_a_new_scene_is_covered_at_the_stated_rate_however_unequal_the_scenes():
    """Groups with effects of their own and very different sizes; exact by exchangeability."""
    rng = np.random.default_rng(0)
    alpha, scenes, rounds = 0.2, 14, 3000
    wrong = 0.0
    for _ in range(rounds):
        groups = [
            rng.normal(rng.normal(0, 2), 1, rng.choice([1, 3, 40])) for _ in range(scenes + 1)
        ]
        margin = pooled_quantile(groups[:-1], alpha)
        wrong += float((groups[-1] > margin).mean())
    # Standard error of the mean over rounds is below 0.007.
    assert wrong / rounds < alpha + 0.02
    assert wrong / rounds > alpha - 0.1  # not by refusing to say anything


class Sided:
    """Logit by the side of the diagonal, ± noise: wrong in the scenes of one colour."""

    types = ("sided",)

    def see(self, scene):
        return self

    def logits(self, paths, type):
        middle = np.array([np.asarray(p)[len(p) // 2] for p in paths])
        return 100.0 - middle.sum(axis=1)


def test_verdicts_follow_the_margin_and_a_wrong_model_says_either():
    found = conformal(Sided(), colour_set(40, 12), 0.1)
    # Half of the scenes contradict the model: nothing may be said with one error in ten.
    assert found.margin["sided"] > 20
    assert found.scenes == {"sided": 40}
    assert found.least_alpha["sided"] == pytest.approx(1 / 41)
    wide = found.margin["sided"]
    said = found.verdicts(np.array([wide + 1, 0.0, -wide - 1]), "sided")
    assert said == ["accept", "unknown", "reject"]


def test_too_few_scenes_name_the_smallest_rate_they_support():
    with pytest.raises(InputError, match=r"0\.143"):
        conformal(Sided(), colour_set(6, 4), 0.1)


def test_refusals():
    data = colour_set(4, 4)
    for alpha in (0.0, 1.0, -1.0):
        with pytest.raises(InputError, match="error rate"):
            conformal(Sided(), data, alpha)
    with pytest.raises(InputError, match="calibrated types"):
        conformal(Sided(), data, 0.5).verdicts(np.zeros(1), "other")
    with pytest.raises(InputError, match="labelled"):
        conformal(NoTypes(), data, 0.5)


class NoTypes(Sided):
    types = ("nobody",)


def test_logits_that_are_all_on_the_right_side_need_no_margin():
    assert pooled_quantile([np.array([-1.0, -2.0])] * 9, 0.1) <= 0


def test_predict_says_valid_invalid_or_either(tmp_path, capsys):
    data, truth = simulate_set(train_scenes=12, test_scenes=2, demonstrations=3, seed=4)
    write_set(data.of_split("train"), tmp_path / "calibration")
    write_set(data.of_split("test"), tmp_path / "new")
    (tmp_path / "truth.json").write_text(json.dumps(truth))
    words = ["predict", tmp_path / "truth.json", tmp_path / "new"]
    asked = [*words, "--calibrate", tmp_path / "calibration", "--conformal"]
    answer = document(capsys, *asked, 0.1)
    for entry in answer["predictions"]:
        # The rule that made the labels is never wrong: no margin, nothing is left open.
        assert entry["verdict"] == ("accept" if entry["p_valid"] > 0.5 else "reject")
    assert answer["conformal"]["least_alpha"]["careful"] == pytest.approx(1 / 13)
    for wrong in ([*asked, 0.01], [*words, "--conformal", 0.1]):
        status, out, err = run(capsys, *wrong)
        assert (status, out) == (2, "")
        assert len(err.strip().splitlines()) == 1
