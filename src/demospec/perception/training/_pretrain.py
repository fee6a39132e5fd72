"""Pretraining of the distance network: synthetic pictures in, weights out. Seeded, no labels.

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

from demospec.errors import InputError
from demospec.perception._canonical import CANONICAL_PX
from demospec.perception.network._backbone import NetworkSize
from demospec.perception.network._distance_net import DistanceNet, empty_folded, folded
from demospec.perception.network._weights import load_network, recipe_of, save_network
from demospec.perception.synthetic._things import CLEAR_SHARE
from demospec.perception.training._familiarity import (
    FAMILIARITY_PICTURES,
    fit_familiarity_head,
)
from demospec.perception.training._heads import (
    MERGING_PICTURES,
    OBJECTNESS_PICTURES,
    UNCERTAINTY_PICTURES,
    HeadPictures,
    fit_merging_head,
    fit_objectness_head,
    fit_uncertainty_head,
)
from demospec.perception.training._loss import answers_loss, recolour, turned
from demospec.perception.training._synthetic_set import Chunk, paint
from demospec.progress import Progress, silent


@dataclass(frozen=True)
class PretrainSettings:
    """The recipe.

    Args:
        steps: Optimiser steps; 0 with `init`: only the heads are fitted anew.
        batch: Pictures a step.
        seed: Everything random follows from it; the result does not depend on `workers`.
        reuse: How often a generated picture is seen on average.
        pool: Pictures kept.
        size_px: Side of the pictures.
        lr: Peak learning rate of AdamW (one cycle).
        average: Decay of the running average of the weights that is saved.
        clear_share: Share of see-through vessels among the objects, in [0, 1).
        rendered: Share of the pictures that show meshes under a lamp; the others are drawn.
        workers: Processes that paint pictures beside the training; 0 paints in between.
        judge_pictures: Further pictures, for the objectness head.
        joiner_pictures: Further pictures, for the merging head.
        doubt_pictures: Further pictures, for the uncertainty head.
        familiarity_pictures: Further pictures, for the familiarity head; fewer than 20: none.
        init: Weights file to go on from (its own recipe is kept inside the new one); None
            starts from random weights.
        bfloat16: Train in bfloat16 (saved weights and inference are float32/float16): several
            times faster where the processor computes in it, several times slower elsewhere.
        body: Channels of the network.
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
    judge_pictures: int = OBJECTNESS_PICTURES
    joiner_pictures: int = MERGING_PICTURES
    doubt_pictures: int = UNCERTAINTY_PICTURES
    familiarity_pictures: int = FAMILIARITY_PICTURES
    init: str | None = None
    bfloat16: bool = False
    body: NetworkSize = field(default_factory=NetworkSize)

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
            "familiarity_pictures",
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


def _let_the_trainer_stop() -> None:
    """Ctrl-C reaches the whole group of processes: only the one that trains answers it."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _chunks(settings: PretrainSettings, size: int) -> Generator[Chunk]:
    """Endless chunks in order, painted ahead by worker processes where there are any."""
    s, number = settings, 0
    how = (s.size_px, s.clear_share, s.rendered)
    if settings.workers == 0:
        while True:
            yield paint(s.seed, number * size, size, *how)
            number += 1
    import multiprocessing

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        settings.workers, mp_context=context, initializer=_let_the_trainer_stop
    ) as workers:
        ahead: list[Future[Chunk]] = []
        while True:
            while len(ahead) < 3 * settings.workers:
                ahead.append(workers.submit(paint, s.seed, number * size, size, *how))
                number += 1
            yield ahead.pop(0).result()


def pretrain(
    out: Path,
    settings: PretrainSettings,
    *,
    command: str = "",
    progress: Progress = silent,
    checkpoint_s: float = 180.0,
) -> dict[str, Any]:
    """Trains a network and writes it; returns the recipe that is saved beside the weights.

    Args:
        out: ``….safetensors``; the recipe goes into its metadata and into ``….json``.
        settings: The recipe.
        command: The command that ran it, for the record.
        progress: Told after every step.
        checkpoint_s: Seconds between intermediate weights (same file, whole at any time).

    Raises:
        InputError: `settings.init` holds no weights of such a network.
        KeyboardInterrupt: Passed on after the weights so far have been written.
    """
    torch.manual_seed(settings.seed)
    generator = torch.Generator().manual_seed(settings.seed)
    began_from = None
    if settings.init is None:
        network = DistanceNet(settings.body)
    else:
        # Weights are saved with their norms folded in: it goes on without norms.
        network = empty_folded(settings.body)
        shipped = load_network(settings.init)
        if shipped.size != settings.body:
            raise InputError(f"a network of {settings.body}", shipped.size, field="init")
        network.load_state_dict(shipped.state_dict())
        dict(network.named_buffers())["table_px"].fill_(CANONICAL_PX)
        began_from = recipe_of(settings.init)
    network = network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = {k: v.clone() for k, v in network.state_dict().items()}
    decay = [p for p in network.parameters() if p.ndim > 1]
    plain = [p for p in network.parameters() if p.ndim <= 1]
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

    def keep(steps_done: int, *, with_heads: bool = False) -> dict[str, Any]:
        recipe = {
            "settings": asdict(settings),
            "command": command,
            "began_from": began_from,
            "steps_done": steps_done,
            "seconds": round(time.monotonic() - began),
            "training_error": {k: round(v, 4) for k, v in shown.items()},
            "torch": torch.__version__,
        }
        smooth = DistanceNet(settings.body) if began_from is None else empty_folded(settings.body)
        smooth.load_state_dict(average)
        if with_heads:
            smooth = folded(smooth)
            for fit_head, pictures in (
                (fit_merging_head, settings.joiner_pictures),
                (fit_objectness_head, settings.judge_pictures),
                (fit_uncertainty_head, settings.doubt_pictures),
                (fit_familiarity_head, settings.familiarity_pictures),
            ):
                given = HeadPictures(
                    settings.seed, pictures, settings.rendered, settings.size_px, progress
                )
                fit_head(smooth, given)
        save_network(out, smooth, recipe)
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
        network.train()
        x = x.contiguous(memory_format=torch.channels_last)
        with torch.autocast("cpu", torch.bfloat16, enabled=settings.bfloat16):
            answers, _, _ = network(x)
        loss, parts = answers_loss(answers.float(), y)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(network.parameters(), 2.0)
        optimizer.step()
        schedule.step()
        share = min(settings.average, (1 + step) / (10 + step))
        for key, value in network.state_dict().items():
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
    return keep(settings.steps, with_heads=True)
