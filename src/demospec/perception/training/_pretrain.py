"""The recipe that makes the body: generated pictures in, weights out. Seeded, no labels.

Differs from common practice in one place only: each picture is generated once, kept in a pool
and seen a few times turned, mirrored and recoloured, which costs the answers nothing.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from demospec.errors import InputError
from demospec.perception._observation import CANONICAL_PX
from demospec.perception.heads._objectness import PICTURES, fit_judge
from demospec.perception.heads._uncertainty import PICTURES as DOUBT_PICTURES
from demospec.perception.heads._uncertainty import fit_doubt
from demospec.perception.inference._merging import PICTURES as JOINER_PICTURES
from demospec.perception.inference._merging import fit_joiner
from demospec.perception.network._distance_net import Body, BodySize, empty_folded, folded
from demospec.perception.network._weights import load_body, recipe_of, save_body
from demospec.perception.synthetic._backgrounds import NoiseBank
from demospec.perception.synthetic._pictures import make_picture
from demospec.perception.synthetic._rendered import render_picture
from demospec.perception.synthetic._things import CLEAR_SHARE, kind_shares
from demospec.progress import Progress, silent


@dataclass(frozen=True)
class PretrainSettings:
    """The recipe.

    Args:
        steps: Optimiser steps; 0 with `init`: only joiner and judge are fitted anew.
        batch: Pictures a step.
        seed: Everything random follows from it; the result does not depend on `workers`.
        reuse: How often a generated picture is seen on average.
        pool: Pictures kept.
        size_px: Side of the pictures.
        lr: Peak learning rate of AdamW (one cycle).
        average: Decay of the running average of the weights that is saved.
        clear_share: Share of see-through vessels among the things, in [0, 1).
        rendered: Share of the pictures that show meshes under a lamp; the others are drawn.
        workers: Processes that paint pictures beside the training; 0 paints in between.
        judge_pictures: Pictures beside those, whose slots teach the judge of slots.
        joiner_pictures: Further ones, whose parts teach which fragments are one thing.
        doubt_pictures: Further ones, whose errors teach where distances may be off.
        init: Weights file to go on from (its own recipe is kept inside the new one); None
            starts from random weights.
        bfloat16: Train in bfloat16 (saved weights and inference are float32/float16): several
            times faster where the processor computes in it, several times slower elsewhere.
        body: Channels.
    """

    steps: int = 11_000
    batch: int = 16
    seed: int = 0
    reuse: float = 5.0
    pool: int = 3000
    size_px: int = CANONICAL_PX
    lr: float = 2.5e-3
    average: float = 0.998
    clear_share: float = CLEAR_SHARE
    rendered: float = 0.6
    workers: int = 0
    judge_pictures: int = PICTURES
    joiner_pictures: int = JOINER_PICTURES
    doubt_pictures: int = DOUBT_PICTURES
    init: str | None = None
    bfloat16: bool = False
    body: BodySize = field(default_factory=BodySize)

    def __post_init__(self) -> None:
        if self.steps < (1 if self.init is None else 0):
            raise InputError("at least 1 (0 with init)", self.steps, field="steps")
        for name in (
            "batch",
            "pool",
            "size_px",
            "judge_pictures",
            "joiner_pictures",
            "doubt_pictures",
        ):
            if getattr(self, name) < 1:
                raise InputError("at least 1", getattr(self, name), field=name)
        if self.workers < 0:
            raise InputError("at least 0", self.workers, field="workers")
        if self.size_px < 32:
            raise InputError("at least 32 px", self.size_px, field="size_px")
        if not self.reuse >= 0.1:
            raise InputError("at least 0.1", self.reuse, field="reuse")
        if not 0.0 <= self.clear_share < 1.0:
            raise InputError("a share in [0, 1)", self.clear_share, field="clear_share")
        if not 0.0 <= self.rendered <= 1.0:
            raise InputError("a share in [0, 1]", self.rendered, field="rendered")
        if not 0.0 <= self.average < 1.0:
            raise InputError("a decay in [0, 1)", self.average, field="average")
        if not 0.0 < self.lr < 1.0:
            raise InputError("a learning rate in (0, 1)", self.lr, field="lr")


Chunk = tuple[NDArray[np.uint8], NDArray[np.float16]]


def paint(
    seed: int,
    first: int,
    count: int,
    size_px: int,
    clear_share: float = CLEAR_SHARE,
    rendered: float = 0.6,
    shares: tuple[float, ...] | None = None,
) -> Chunk:
    """Pictures number first … first + count − 1 of a seed: (n, s, s, 3) and (n, 7, s, s).

    Args:
        shares: How often each of the `KINDS` is drawn, instead of `kind_shares(clear_share)`.
    """
    kinds = kind_shares(clear_share) if shares is None else np.array(shares)
    bank = _bank(seed)
    pictures = np.empty((count, size_px, size_px, 3), np.uint8)
    planes = np.empty((count, 7, size_px, size_px), np.float16)
    for i in range(count):
        rng = np.random.default_rng([seed, first + i])
        if rng.random() < rendered:
            pictures[i], planes[i] = render_picture(rng, bank, size_px, kinds)
        else:
            pictures[i], planes[i] = make_picture(rng, bank, size_px, kinds)
    return pictures, planes


_BANKS: dict[int, NoiseBank] = {}


def _bank(seed: int) -> NoiseBank:
    if seed not in _BANKS:
        _BANKS[seed] = NoiseBank.make(np.random.default_rng([seed, 2**31]))
    return _BANKS[seed]


def _let_the_trainer_stop() -> None:
    """Ctrl-C reaches the whole group of processes: only the one that trains answers it."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _chunks(settings: PretrainSettings, size: int) -> Generator[Chunk]:
    """Endless chunks in order, painted ahead by worker processes where there are any."""
    s, number = settings, 0
    look = (s.size_px, s.clear_share, s.rendered)
    if settings.workers == 0:
        while True:
            yield paint(s.seed, number * size, size, *look)
            number += 1
    import multiprocessing

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        settings.workers, mp_context=context, initializer=_let_the_trainer_stop
    ) as workers:
        ahead: list[Future[Chunk]] = []
        while True:
            while len(ahead) < 3 * settings.workers:
                ahead.append(workers.submit(paint, s.seed, number * size, size, *look))
                number += 1
            yield ahead.pop(0).result()


def recolour(pictures: Tensor, generator: torch.Generator) -> Tensor:
    """Random exposure, colour cast, tone curve, channel order and noise; (n, 3, h, w)."""
    n = len(pictures)

    def uniform(low: float, high: float, *shape: int) -> Tensor:
        return low + (high - low) * torch.rand(n, *shape, generator=generator)

    out = pictures
    order = torch.stack([torch.randperm(3, generator=generator) for _ in range(n)])
    keep = torch.rand(n, generator=generator) < 0.6
    order[keep] = torch.arange(3)
    out = out[torch.arange(n)[:, None], order]
    out = out * uniform(0.7, 1.25, 1, 1, 1) * uniform(0.9, 1.1, 3, 1, 1)
    out = out + uniform(-0.06, 0.06, 3, 1, 1)
    out = out.clamp(0, 1) ** uniform(0.7, 1.4, 1, 1, 1)
    grey = out.mean(1, keepdim=True)
    out = grey + (out - grey) * uniform(0.3, 1.2, 1, 1, 1)
    noise = uniform(-0.03, 0.02, 1, 1, 1).clamp(min=0)
    return (out + noise * torch.randn(out.shape, generator=generator)).clamp(0, 1)


def turned(planes: Tensor, turn: int) -> Tensor:
    """One of the eight symmetries of the square on (…, s, s)."""
    out = torch.rot90(planes, turn % 4, (-2, -1))
    return out.flip(-1) if turn >= 4 else out


_THIN_PX = 2.0
_THIN_WEIGHT = 1.5


def beside_thin(distance: Tensor) -> Tensor:
    """(n, h, w) signed distances, px → 1 within 5 px of parts that are nowhere deep, else 0.

    A handle is a few pixels among thousands: without more weight it is seen with gaps.
    """
    deepest = functional.max_pool2d(-distance[:, None], 7, 1, 3)
    thin = ((distance[:, None] < 0) & (deepest < _THIN_PX)).float()
    return functional.max_pool2d(thin, 11, 1, 5)[:, 0]


def answers_loss(answers: Tensor, planes: Tensor) -> tuple[Tensor, dict[str, float]]:
    """Weighted sum of what each answer misses; planes as in `CHANNELS`."""
    distance = planes[:, 0]
    weight = (1.0 + _THIN_WEIGHT * beside_thin(distance)) / (1.0 + distance.abs() / 3.0)
    miss = (answers[:, 0] - distance).abs()
    far = (weight * miss).mean() / weight.mean()
    kind = planes[:, 5].long()
    inside = kind >= 0
    count = inside.sum().clamp(min=1)
    mask = inside.float()
    thickness = (mask * (answers[:, 1] - planes[:, 1]).abs()).sum() / count
    height = (mask * (answers[:, 4] - planes[:, 4]).abs()).sum() / count
    clear = functional.binary_cross_entropy_with_logits(
        answers[:, 2], planes[:, 2], reduction="none"
    )
    filled = functional.binary_cross_entropy_with_logits(
        answers[:, 3], planes[:, 3], reduction="none"
    )
    clear, filled = (mask * clear).sum() / count, (mask * filled).sum() / count
    which = functional.cross_entropy(answers[:, 5:], kind, ignore_index=-1, reduction="sum") / count
    loss = far + 0.15 * thickness + 0.1 * clear + 0.1 * filled + 0.2 * height + 0.2 * which
    near = (distance.abs() < 6).float()
    shown = {
        "near": float((near * miss).sum().detach() / near.sum().clamp(min=1)),
        "kind": float(which.detach()),
        "clear": float(clear.detach()),
    }
    return loss, shown


def pretrain(
    out: Path,
    settings: PretrainSettings,
    *,
    command: str = "",
    progress: Progress = silent,
    checkpoint_s: float = 180.0,
) -> dict[str, Any]:
    """Trains a body and writes it; returns the recipe that is saved beside the weights.

    Args:
        out: ``….safetensors``; the recipe goes into its metadata and into ``….json``.
        settings: The recipe.
        command: The command that ran it, for the record.
        progress: Told after every step.
        checkpoint_s: Seconds between intermediate weights (same file, whole at any time).

    Raises:
        InputError: `settings.init` holds no weights of such a body.
        KeyboardInterrupt: Passed on after the weights so far have been written.
    """
    torch.manual_seed(settings.seed)
    generator = torch.Generator().manual_seed(settings.seed)
    began_from = None
    if settings.init is None:
        body = Body(settings.body)
    else:
        # Weights are saved with their norms folded in: it goes on without norms.
        body = empty_folded(settings.body)
        shipped = load_body(settings.init)
        if shipped.size != settings.body:
            raise InputError(f"a body of {settings.body}", shipped.size, field="init")
        body.load_state_dict(shipped.state_dict())
        dict(body.named_buffers())["table_px"].fill_(CANONICAL_PX)
        began_from = recipe_of(settings.init)
    body = body.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = {k: v.clone() for k, v in body.state_dict().items()}
    decay = [p for p in body.parameters() if p.ndim > 1]
    plain = [p for p in body.parameters() if p.ndim <= 1]
    groups: list[dict[str, Any]] = [{"params": decay, "weight_decay": 1e-3},
                                    {"params": plain, "weight_decay": 0.0}]  # fmt: skip
    optimizer = torch.optim.AdamW(groups, lr=settings.lr)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer,
        settings.lr,
        total_steps=max(settings.steps, 1),
        pct_start=0.08,
        final_div_factor=200,
    )
    size = 32
    chunks = _chunks(settings, size)
    first_fill = min(settings.pool, max(settings.batch * 8, 256))
    pool_x = torch.empty((settings.pool, 3, settings.size_px, settings.size_px), dtype=torch.uint8)
    pool_y = torch.empty(
        (settings.pool, 7, settings.size_px, settings.size_px), dtype=torch.float16
    )
    filled, at, owed = 0, 0, float(first_fill)
    shown: dict[str, float] = {}
    began = saved = time.monotonic()

    def keep(steps_done: int, *, judged: bool = False) -> dict[str, Any]:
        recipe = {
            "settings": asdict(settings),
            "command": command,
            "began_from": began_from,
            "steps_done": steps_done,
            "seconds": round(time.monotonic() - began),
            "training_error": {k: round(v, 4) for k, v in shown.items()},
            "torch": torch.__version__,
        }
        smooth = Body(settings.body) if began_from is None else empty_folded(settings.body)
        smooth.load_state_dict(average)
        if judged:
            smooth = folded(smooth)
            fit_joiner(smooth, settings.seed, rendered=settings.rendered, progress=progress,
                       pictures=settings.joiner_pictures, size_px=settings.size_px)  # fmt: skip
            fit_judge(smooth, settings.seed, rendered=settings.rendered, progress=progress,
                      pictures=settings.judge_pictures, size_px=settings.size_px)  # fmt: skip
            fit_doubt(smooth, settings.seed, rendered=settings.rendered, progress=progress,
                      pictures=settings.doubt_pictures, size_px=settings.size_px)  # fmt: skip
        save_body(out, smooth, recipe)
        return recipe

    def train_step(step: int) -> None:
        nonlocal filled, at, owed
        while owed > 0:
            pictures, planes = next(chunks)
            where = torch.from_numpy((at + np.arange(len(pictures))) % settings.pool)
            pool_x[where] = torch.from_numpy(pictures).permute(0, 3, 1, 2)
            pool_y[where] = torch.from_numpy(planes)
            at = (at + len(pictures)) % settings.pool
            filled = min(settings.pool, filled + len(pictures))
            owed -= len(pictures)
        owed += settings.batch / settings.reuse
        chosen = torch.randint(filled, (settings.batch,), generator=generator)
        turn = int(torch.randint(8, (1,), generator=generator))
        x = recolour(turned(pool_x[chosen], turn).float() / 255.0, generator)
        y = turned(pool_y[chosen], turn).float()
        body.train()
        x = x.contiguous(memory_format=torch.channels_last)
        with torch.autocast("cpu", torch.bfloat16, enabled=settings.bfloat16):
            answers, _, _ = body(x)
        loss, parts = answers_loss(answers.float(), y)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(body.parameters(), 2.0)
        optimizer.step()
        schedule.step()
        share = min(settings.average, (1 + step) / (10 + step))
        for key, value in body.state_dict().items():
            if value.dtype.is_floating_point:
                average[key].lerp_(value, 1 - share)
            else:
                average[key].copy_(value)
        for key, number in parts.items():
            shown[key] = 0.98 * shown.get(key, number) + 0.02 * number
        progress("pretraining", step + 1, settings.steps)

    step = 0
    try:
        for step in range(settings.steps):
            train_step(step)
            if time.monotonic() - saved > checkpoint_s and step + 1 < settings.steps:
                saved = time.monotonic()
                keep(step + 1)
    except KeyboardInterrupt:
        if step > 0:
            keep(step)
        raise
    finally:
        chunks.close()
    return keep(settings.steps, judged=True)
