"""Training many of the paper's models at once: ablations, demonstrations, seeds in one stack.

On a CPU a stack takes as long as its members one after the other, or longer, so that a stack
there holds one; elsewhere as many as fit into memory. Whatever the stack, a member's weights are
those of its own single fit up to rounding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from demospec.errors import InputError, MissingExtraError
from demospec.progress import Progress, silent
from demospec.specification.models._folder import ModelWeights
from demospec.specification.models.beta_vae._training_data import TrainingData

if TYPE_CHECKING:
    from demospec.specification.models.beta_vae._model import PaperSettings

PRECISIONS = ("float32", "bfloat16")

PARAMETERS = 34_925
"""Numbers of encoder and decoder; a type's classifier has 5,377 more at order 2."""


@dataclass(frozen=True)
class StackedJob:
    """One fit of the paper's model.

    Args:
        data: What it learns from.
        settings: Its ablation and weights of the loss. Jobs that differ in ``steps`` or
            ``learning_rate`` are trained in stacks of their own.
        seed: Of its first weights and of its noise.
    """

    data: TrainingData
    settings: PaperSettings
    seed: int


def train_stacked(
    jobs: Sequence[StackedJob],
    *,
    device: str = "cpu",
    precision: str = "float32",
    memory_bytes: int | None = None,
    most: int | None = None,
    progress: Progress = silent,
) -> list[ModelWeights]:
    """The weights of every job, in order; each those of its own fit up to rounding.

    Args:
        jobs: Any; those of one shape of data are stacked.
        device: ``cpu``, ``cuda``, …; the jobs' own ``device`` and ``precision`` do not count.
        precision: ``float32``; or ``bfloat16`` in encoder and decoder, ``float32`` elsewhere.
        memory_bytes: What a stack may take (`bytes_of_member`); by default 60 % of what is free
            on a CUDA device, 1 GiB on others.
        most: Members of a stack; by default one on a CPU, else as many as the memory holds.
        progress: Told the steps.

    Raises:
        InputError: No such device here, or no such precision.
        MissingExtraError: torch is absent.
    """
    check_device(device, precision)
    from demospec.specification.models.beta_vae._stacked_steps import Member, train_stack

    out: list[ModelWeights | None] = [None] * len(jobs)
    stacks = list(_stacks(jobs, device, memory_bytes, most))
    total = sum(jobs[rows[0]].settings.steps for rows in stacks)
    done = 0
    for rows in stacks:
        members = [Member(jobs[k].data, *jobs[k].settings.weights, jobs[k].seed) for k in rows]
        settings = jobs[rows[0]].settings
        before = done
        found = train_stack(
            members,
            steps=settings.steps,
            learning_rate=settings.learning_rate,
            device=device,
            precision=precision,
            step_done=lambda step, before=before: progress("fitting", before + step, total),  # type: ignore[misc]
        )
        done += settings.steps
        for k, weights in zip(rows, found, strict=True):
            out[k] = weights
    return [weights for weights in out if weights is not None]


def _stacks(
    jobs: Sequence[StackedJob], device: str, memory_bytes: int | None, most: int | None
) -> Iterator[list[int]]:
    """Rows of the jobs of each stack."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, job in enumerate(jobs):
        data, s = job.data, job.settings
        shape = (len(data.types), data.images.shape, data.control.shape[1])
        alike.setdefault((*shape, s.steps, s.learning_rate), []).append(k)
    for rows in alike.values():
        at_once = stack_size(
            [jobs[k] for k in rows], device=device, memory_bytes=memory_bytes, most=most
        )
        for first in range(0, len(rows), at_once):
            yield rows[first : first + at_once]


def stack_size(
    jobs: Sequence[StackedJob],
    *,
    device: str = "cpu",
    memory_bytes: int | None = None,
    most: int | None = None,
) -> int:
    """How many of these jobs go into one stack, ≥ 1; arguments as of `train_stacked`."""
    if most is None and device == "cpu":
        return 1
    budget = _memory(device) if memory_bytes is None else memory_bytes
    fit = budget // max(bytes_of_member(job) for job in jobs)
    return max(1, min(fit, len(jobs) if most is None else most))


def bytes_of_member(job: StackedJob) -> int:
    """Memory that a member of a stack takes while it is trained, in float32; an upper estimate.

    ModelWeights, their gradients, Adam's two moments and two temporaries; feature maps with their
    gradients (of the encoder a third time, for what a convolution lays out anew), pictures and
    their errors; the classifier's inputs and layers with their gradients.
    """
    scenes, types = len(job.data.images), len(job.data.types)
    inputs = 15 + int(job.data.control.shape[1])
    maps = 16 * 50 * 50 + 8 * 25 * 25 + 4 * 13 * 13
    pictures = 3 * maps
    if job.settings.weights[0] > 0:
        pictures += 2 * maps + 4 * 3 * 100 * 100
    most = max(int((job.data.type == t).sum()) for t in range(types))
    weights = weights_of_member(job)
    return 4 * (6 * weights + scenes * pictures + 2 * types * most * (inputs + 2 * 64))


def weights_of_member(job: StackedJob) -> int:
    """Numbers in its network."""
    inputs = 15 + int(job.data.control.shape[1])
    return PARAMETERS + len(job.data.types) * (inputs * 64 + 64 * 64 + 3 * 64 + 1)


def _memory(device: str) -> int:
    if device.startswith("cuda"):
        import torch

        if torch.cuda.is_available():
            free, _ = torch.cuda.mem_get_info(device)
            return int(0.6 * float(free))
    return 1 << 30


def check_device(device: str, precision: str = "float32") -> None:
    """InputError where this build of PyTorch cannot use the device, or the precision is unknown."""
    require_torch()
    from demospec.specification.models.beta_vae._stacked_steps import find_device

    find_device(device)
    if precision not in PRECISIONS:
        raise InputError(", ".join(PRECISIONS), precision, field="precision")


def require_torch() -> None:
    """MissingExtraError where torch is absent."""
    try:
        import torch  # noqa: F401
    except ModuleNotFoundError as error:
        raise MissingExtraError("torch", "vision", "the paper's model") from error
