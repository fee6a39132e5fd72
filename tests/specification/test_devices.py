"""The field model's device: named where it is not there, and unknown to earlier models."""

from __future__ import annotations

import json

import numpy as np
import pytest

from demospec.demonstrations import simulate_set
from demospec.errors import InputError
from demospec.specification import fit_model, load_model

torch = pytest.importorskip("torch", reason="torch comes with demospec[vision]")


@pytest.fixture(scope="module")
def train():
    data, _ = simulate_set(train_scenes=3, test_scenes=1, demonstrations=4, seed=2)
    return data.of_split("train")


def test_a_device_that_is_not_there_is_named(train):
    for device in ("toaster", "cuda:97"):
        with pytest.raises(InputError, match=f"device: expected a device .*found {device}"):
            fit_model(train, "field", device=device)
    with pytest.raises(InputError, match="device: expected the name of a device"):
        fit_model(train, "field", device=7)


def test_a_model_that_names_no_device_is_read(train, tmp_path):
    folder = fit_model(train, "field").save(tmp_path / "m")
    config = json.loads((folder / "config.json").read_text())
    assert config["settings"].pop("device") == "cpu"
    (folder / "config.json").write_text(json.dumps(config))
    assert load_model(folder).settings.device == "cpu"


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
def test_a_gpu_tunes_the_body_as_the_cpu_does(train):
    from demospec.perception import load_network
    from demospec.perception.training import TuneSettings, tuned_network

    few = TuneSettings(steps=5, batch=2, generated=20)
    here, there = (
        tuned_network(load_network(), list(train.scenes), 1.0, seed=0, device=d, settings=few)
        for d in ("cpu", "cuda")
    )
    for name, value in here.state_dict().items():
        np.testing.assert_allclose(there.state_dict()[name], value, atol=1e-2, err_msg=name)
