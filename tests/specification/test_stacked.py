"""Stacked fits: a member is what its own fit would be; a plain loop is the oracle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.specification import PaperModel, PaperSettings, fit_model, predict
from demospec.specification.models.beta_vae import (
    StackedJob,
    TrainingData,
    bytes_of_member,
    stack_size,
    train_stacked,
    training_data,
)
from demospec.testing import colour_set

torch = pytest.importorskip("torch", reason="torch comes with demospec[vision]")

TOLERANCE = 1e-5
"""Of every weight after 20 steps; 2e-7 was seen."""


def plain_fit(data: TrainingData, settings: PaperSettings, seed: int) -> dict[str, np.ndarray]:
    """The same training written down once more, one network, no stack, nothing shared."""
    from demospec.specification.models.beta_vae import Network

    alpha, beta, gamma = settings.weights
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        net = Network(len(data.types), data.control.shape[1])
        images, scene, control, valid = (
            torch.from_numpy(x) for x in (data.images, data.scene, data.control, data.valid)
        )
        optimiser = torch.optim.Adam(net.parameters(), lr=settings.learning_rate)
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimiser, settings.learning_rate, settings.steps
        )
        for _ in range(settings.steps):
            mean, log_variance = net.encode(images)
            latent = mean
            if beta > 0:
                latent = mean + torch.exp(0.5 * log_variance) * torch.randn(mean.shape)
            x = torch.cat([latent[scene], control], dim=1)
            logits = torch.empty(len(x))
            for t in range(len(data.types)):
                mine = torch.from_numpy(data.type == t)
                h = torch.tanh(x[mine] @ net.w1[t] + net.b1[t])
                h = torch.tanh(h @ net.w2[t] + net.b2[t])
                logits[mine] = h @ net.w3[t] + net.b3[t]
            loss = gamma * torch.nn.functional.binary_cross_entropy_with_logits(logits, valid)
            if alpha > 0:
                error = (net.decode(latent) - images).square().sum(dim=(1, 2, 3)).mean()
                loss = loss + alpha * error / 100
            if beta > 0:
                kl = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance)
                loss = loss + beta * kl.sum(dim=1).mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
    return {name: value.detach().numpy() for name, value in net.state_dict().items()}


def some_jobs(steps: int) -> list[StackedJob]:
    """Every ablation, two sets of pictures, several counts, seeds and weights, in no order."""
    jobs = []
    for picture_seed, seed in ((0, 0), (1, 5)):
        for each, ablation in ((3, "classifier"), (9, "full"), (1, "autoencoder"), (6, "full")):
            data = training_data(colour_set(4, each, seed=picture_seed))
            settings = PaperSettings(ablation=ablation, steps=steps)
            jobs.append(StackedJob(data, settings, seed))
    other = PaperSettings(alpha=0.02, beta=1e-2, gamma=0.5, steps=steps)
    jobs.append(StackedJob(training_data(colour_set(4, 5, seed=0)), other, 7))
    return jobs


@pytest.fixture(scope="module")
def jobs_and_plain_fits():
    jobs = some_jobs(20)
    return jobs, [plain_fit(job.data, job.settings, job.seed) for job in jobs]


@pytest.mark.parametrize("most", [None, 4, 100])
def test_every_member_is_what_a_plain_loop_trains(most, jobs_and_plain_fits):
    jobs, plain = jobs_and_plain_fits
    for weights, expected in zip(train_stacked(jobs, most=most), plain, strict=True):
        assert set(weights) == set(expected)
        for name, value in expected.items():
            assert weights[name].dtype == np.float32
            np.testing.assert_allclose(weights[name], value, atol=TOLERANCE, err_msg=name)


def test_after_a_whole_fit_a_member_says_what_the_single_fit_says():
    data = colour_set(8)
    fits = [fit_model(data, "paper", seed=s, steps=100) for s in (0, 1)]
    jobs = [StackedJob(training_data(data), PaperSettings(steps=100), s) for s in (0, 1)]
    for fit, weights in zip(fits, train_stacked(jobs, most=2), strict=True):
        member = PaperModel(fit.types, fit.settings, weights, {})
        for judged in (data, colour_set(20, seed=9)):
            one, two = (p_of(m, judged) for m in (fit, member))
            # A hundred steps carry rounding much further than twenty.
            assert np.abs(one - two).max() < 0.06
            assert np.mean((one > 0.5) == (two > 0.5)) > 0.95


@pytest.mark.parametrize("ablation", ["full", "classifier"])
def test_bfloat16_says_nearly_what_float32_says(ablation):
    data = colour_set(8)
    exact, low = (
        fit_model(data, "paper", steps=100, ablation=ablation, precision=p)
        for p in ("float32", "bfloat16")
    )
    assert all(value.dtype == np.float32 for value in low.weights.values())
    assert any(not np.array_equal(low.weights[k], v) for k, v in exact.weights.items())
    for judged in (data, colour_set(20, seed=9)):
        one, two = (p_of(m, judged) for m in (exact, low))
        assert np.mean((one > 0.5) == (two > 0.5)) > 0.95


def p_of(model, data) -> np.ndarray:
    return np.array([item.p_valid for item in predict(model, data).items])


def test_a_decoder_without_use_keeps_its_first_weights_beside_one_that_learns():
    jobs = some_jobs(2)[:4]
    found = train_stacked(jobs, most=100)
    first = {}
    for job, weights in zip(jobs, found, strict=True):
        if job.settings.ablation == "classifier":
            torch.manual_seed(job.seed)
            from demospec.specification.models.beta_vae import Network

            first = Network(len(job.data.types), 2).state_dict()
            for name in first:
                if name.startswith("decoder"):
                    np.testing.assert_array_equal(weights[name], first[name].numpy())
    assert first


def test_jobs_of_other_shapes_get_stacks_of_their_own():
    two = training_data(colour_set(2, 3))
    jobs = [
        StackedJob(training_data(colour_set(4, 3)), PaperSettings(steps=4), 0),
        StackedJob(two, PaperSettings(steps=6), 0),
        StackedJob(training_data(colour_set(2, 3), order=3), PaperSettings(steps=4, order=3), 0),
        StackedJob(two, PaperSettings(steps=4), 1),
    ]
    done = []
    found = train_stacked(
        jobs, most=10, progress=lambda _what, at, total: done.append((int(at), int(total)))
    )
    assert done[-1] == (18, 18)
    assert [at for at, _ in done] == list(range(1, 19))
    for job, weights in zip(jobs, found, strict=True):
        single = train_stacked([job])[0]
        for name, value in single.items():
            np.testing.assert_allclose(weights[name], value, atol=TOLERANCE)


def test_a_stack_is_no_larger_than_its_memory():
    jobs = some_jobs(2)
    each = max(bytes_of_member(job) for job in jobs)
    assert stack_size(jobs) == 1  # a CPU has nothing to gain
    assert stack_size(jobs, memory_bytes=3 * each + 1, device="cuda") == 3
    assert stack_size(jobs, memory_bytes=1, device="cuda") == 1
    assert stack_size(jobs, memory_bytes=1 << 50, device="cuda") == len(jobs)
    assert stack_size(jobs, memory_bytes=1 << 50, device="cuda", most=2) == 2


def test_the_weights_counted_are_the_networks():
    from demospec.specification.models.beta_vae import Network, weights_of_member

    for order in (2, 4):
        data = training_data(colour_set(2, 2), order=order)
        net = Network(len(data.types), 2 * (order - 1))
        job = StackedJob(data, PaperSettings(order=order), 0)
        assert sum(p.numel() for p in net.parameters()) == weights_of_member(job)


def test_faults_are_named():
    job = some_jobs(2)[0]
    with pytest.raises(InputError, match=r"device: .*found toaster"):
        train_stacked([job], device="toaster")
    with pytest.raises(InputError, match=r"precision: .*found float8"):
        replace(job.settings, precision="float8")


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
def test_nothing_of_a_step_stays_behind_on_the_cpu(precision):
    # The meta device computes shapes only, and refuses to meet a tensor of another device: what
    # a GPU would refuse too.
    from demospec.specification.models.beta_vae import _stacked_steps as steps

    where = torch.device("meta")
    members = [steps.Member(j.data, *j.settings.weights, j.seed) for j in some_jobs(3)]
    members.sort(key=lambda m: m.alpha == 0)
    weights, noise = steps._first_weights(members, 3, where)
    batch = steps._Batch(members, steps._picture_sets(members), where)
    optimiser = torch.optim.Adam(list(weights.values()), foreach=True)
    for step in range(2):
        optimiser.zero_grad()
        batch.loss(weights, noise.at(step), "cpu", precision).backward()
        optimiser.step()
    assert all(value.grad.device == where for value in weights.values())
    assert batch.layout == torch.contiguous_format


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
def test_a_stack_on_a_gpu_learns_what_a_plain_loop_on_the_cpu_learns(jobs_and_plain_fits):
    jobs, plain = jobs_and_plain_fits
    for weights, expected in zip(train_stacked(jobs, device="cuda"), plain, strict=True):
        for name, value in expected.items():
            np.testing.assert_allclose(weights[name], value, atol=1e-3, err_msg=name)
