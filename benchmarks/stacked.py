"""The paper's model: the same fits one after the other and as one stack, in one process.

    python benchmarks/stacked.py                       # a small part on the CPU, 1 to 3 minutes
    python benchmarks/stacked.py --device cuda --whole # the paper's grid of 270 fits

Rows: ``plain`` is a loop in plain PyTorch (no stack, torch's default layout, every demonstration
through every type's classifier), ``loop`` ours one fit at a time, ``stack`` all at once. On a CPU
seconds are process time on one thread, least of --repeats; elsewhere wall time. The floors are
what the arithmetic and the traffic of the feature maps alone would take at the speed of a large
matrix product and of a large copy on the same device. Writes benchmarks/results/stacked.json.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
import torch  # noqa: E402

from demospec.experiments import GridSettings  # noqa: E402
from demospec.experiments._stacked_grid import jobs_of  # noqa: E402
from demospec.specification import StackedJob, stack_size, train_stacked  # noqa: E402
from demospec.specification.models.beta_vae._network import Network  # noqa: E402
from demospec.specification.models.beta_vae._stacked import bytes_of_member, weights_of_member  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "stacked.json"
MAPS = 16 * 50 * 50 + 8 * 25 * 25 + 4 * 13 * 13
"""Numbers in the feature maps of encoder or decoder, a picture."""
CONVOLUTIONS = 50 * 50 * 16 * 27 + 25 * 25 * 8 * 144 + 13 * 13 * 4 * 72
"""Multiplications in the convolutions of encoder or decoder, a picture."""


def flops(job: StackedJob) -> float:
    """Of one step: forward, and as much again for each of the two gradients."""
    decoded = job.settings.weights[0] > 0
    picture = CONVOLUTIONS + 676 * 30 + decoded * (CONVOLUTIONS + 676 * 15)
    inputs = 15 + job.data.control.shape[1]
    shown = len(job.data.type) * (inputs * 64 + 64 * 64 + 64)
    return 3 * 2 * float(len(job.data.images) * picture + shown)


def traffic(job: StackedJob) -> float:
    """Bytes of one step: every map is written, read, read for its gradient, which is written
    and read; every weight, gradient and moment read and written by Adam."""
    decoded = job.settings.weights[0] > 0
    maps = MAPS + decoded * (MAPS + 2 * 3 * 100 * 100) + 3 * 100 * 100
    return 4.0 * (5 * len(job.data.images) * maps + 7 * weights_of_member(job))


def peaks(device: str, clock: Callable[[], float]) -> tuple[float, float]:
    """(floating-point operations, bytes) a second: a large matrix product, a large copy."""
    n = 1024 if device == "cpu" else 8192
    a = torch.randn(n, n, device=device)
    big = torch.randn(1 << (23 if device == "cpu" else 28), device=device)
    other = torch.empty_like(big)
    product = least(lambda: torch.mm(a, a), clock, 5)
    copy = least(lambda: other.copy_(big), clock, 5)
    return 2.0 * n**3 / product, 8.0 * len(big) / copy


def least(work: Callable[[], Any], clock: Callable[[], float], repeats: int) -> float:
    """Least seconds of some runs."""
    best = np.inf
    for _ in range(repeats):
        began = clock()
        work()
        best = min(best, clock() - began)
    return float(best)


def plain(job: StackedJob) -> None:
    """One fit in plain PyTorch on the CPU; the same numbers up to rounding."""
    data, (alpha, beta, gamma) = job.data, job.settings.weights
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(job.seed)
        net = Network(len(data.types), data.control.shape[1])
        images, scene, control, type_, valid = (
            torch.from_numpy(x)
            for x in (data.images, data.scene, data.control, data.type, data.valid)
        )
        row = torch.arange(len(type_))
        optimiser = torch.optim.Adam(net.parameters(), lr=job.settings.learning_rate, foreach=True)
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimiser, job.settings.learning_rate, job.settings.steps
        )
        for _ in range(job.settings.steps):
            mean, log_variance = net.encode(images)
            latent = mean
            if beta > 0:
                latent = mean + torch.exp(0.5 * log_variance) * torch.randn(mean.shape)
            x = torch.cat([latent[scene], control], dim=1)
            x = torch.tanh(x @ net.w1 + net.b1[:, None])
            x = torch.tanh(x @ net.w2 + net.b2[:, None])
            logits = ((x * net.w3[:, None]).sum(dim=2) + net.b3[:, None])[type_, row]
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--precision", default="float32")
    parser.add_argument("--whole", action="store_true", help="3 models, 9 counts, 10 seeds")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    on_cpu = given.device == "cpu"
    torch.set_num_threads(1)

    def clock() -> float:
        if on_cpu:
            return time.process_time()
        torch.cuda.synchronize()
        return time.perf_counter()

    rows = []
    peak = peaks(given.device, clock)
    every = {"full": ("full",), "classifier": ("classifier",)}
    if given.whole:
        every = {"full, autoencoder, classifier": ("full", "autoencoder", "classifier")}
    for name, models in every.items():
        settings = GridSettings(
            models=models,
            counts=tuple(range(1, 10)) if given.whole else (1, 9),
            seeds=tuple(range(10)) if given.whole else (0, 1),
            steps=300 if given.whole else given.steps,
        )
        jobs = jobs_of(settings, tuple(settings.cells()))
        size = len(jobs) if on_cpu else stack_size(jobs, device=given.device)

        def fit(most: int, jobs: list[StackedJob] = jobs) -> None:
            train_stacked(jobs, device=given.device, precision=given.precision, most=most)

        row: dict[str, Any] = {"models": name, "fits": len(jobs), "steps": settings.steps}
        train_stacked(jobs[:1], device=given.device, precision=given.precision)  # wakes libraries
        if on_cpu:
            row["plain_s"] = least(lambda jobs=jobs: [plain(j) for j in jobs], clock, given.repeats)
        row["loop_s"] = least(lambda fit=fit: fit(1), clock, given.repeats)
        if not on_cpu:
            torch.cuda.reset_peak_memory_stats()
        row["stack_s"] = least(lambda fit=fit, size=size: fit(size), clock, given.repeats)
        if not on_cpu:
            row["peak_bytes"] = torch.cuda.max_memory_allocated()
        row["stack"] = size
        row["loop_over_stack"] = row["loop_s"] / row["stack_s"]
        row["arithmetic_floor_s"] = sum(flops(j) for j in jobs) * settings.steps / peak[0]
        row["traffic_floor_s"] = sum(traffic(j) for j in jobs) * settings.steps / peak[1]
        row["bytes_of_member"] = bytes_of_member(jobs[-1])
        rows.append(row)
        print(json.dumps(row))
    report = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    key = f"{given.device} {given.precision}" + (" whole" if given.whole else "")
    report[key] = {
        "command": "python " + " ".join(sys.argv),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread"
        if on_cpu
        else torch.cuda.get_device_name(given.device),
        "versions": {n: version(n) for n in ("demospec", "numpy", "torch")},
        "matrix_product_flops_per_s": peak[0],
        "copy_bytes_per_s": peak[1],
        "rows": rows,
    }
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
