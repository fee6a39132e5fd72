"""Many of the paper's networks trained as one: members side by side in every tensor.

Weights of the M members lie on a first axis. A convolution of all members is one grouped
convolution, a linear layer one batched product, a step of Adam one step over all (it works
element by element). The loss is the sum of the members' own losses, so that no member's gradient
knows of another. A single fit is a stack of one: there is no second way of training.

Members that saw the same pictures share them: their first convolutions are one ordinary
convolution, and the decoder is only run for the members that have a use for it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from demospec.errors import InputError
from demospec.specification.models.beta_vae._network import LATENT, Network, one_thread
from demospec.specification.models.beta_vae._training_data import Float32Array, TrainingData

_SIDE = 13  # of the encoder's last and the decoder's first feature map
_CLAMP = 12.0  # of the log-variance, as in `Network.encode`


@dataclass(frozen=True)
class Member:
    """One network of a stack.

    Args:
        data: What it learns from.
        alpha, beta, gamma: Its weights of reconstruction, KL and log-likelihood. With α = 0 it
            has no use for the decoder, with β = 0 none for the noise.
        seed: Of its first weights and of its noise.
    """

    data: TrainingData
    alpha: float
    beta: float
    gamma: float
    seed: int


def train_stack(
    members: Sequence[Member],
    *,
    steps: int,
    learning_rate: float,
    device: str = "cpu",
    precision: str = "float32",
    step_done: Callable[[int], None],
) -> list[dict[str, Float32Array]]:
    """Trains all members on their full batches; the weights of each, by name.

    Each minimises α·reconstruction/100 + β·KL + γ·(−log-likelihood), where reconstruction is
    the sum of squared errors of a picture, KL that of a picture's z_I against N(0, 1), both
    averaged over scenes, and the log-likelihood is averaged over demonstrations. (The paper
    writes the same with the signs of a maximisation on two of its terms.)

    Args:
        members: With as many pictures, types and control coordinates each.
        device: Where torch trains. First weights and noise are drawn on the CPU, so that devices
            differ by rounding only.
        precision: ``bfloat16`` computes encoder and decoder so; the rest stays ``float32``.
        step_done: Told the number of steps done.

    Raises:
        InputError: There is no such device here.
    """
    where = find_device(device)
    # The decoder's members come first, those of one set of pictures beside each other.
    sets = _picture_sets(members)
    order = sorted(range(len(members)), key=lambda k: (members[k].alpha == 0, sets[k]))
    placed = [members[k] for k in order]
    with one_thread(), _exact(where):
        weights, noise = _first_weights(placed, steps, where)
        batch = _Batch(placed, [sets[k] for k in order], where)
        optimiser = torch.optim.Adam(list(weights.values()), lr=learning_rate, foreach=True)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, learning_rate, steps)
        for step in range(steps):
            optimiser.zero_grad()
            heard = None if noise is None else noise.at(step)
            loss = batch.loss(weights, heard, where.type, precision)
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            step_done(step + 1)
    found = {name: value.detach().cpu().numpy() for name, value in weights.items()}
    out: list[dict[str, Float32Array]] = [{} for _ in members]
    for place, k in enumerate(order):
        out[k] = {name: np.array(value[place]) for name, value in found.items()}
    return out


def _picture_sets(members: Sequence[Member]) -> list[int]:
    """(M,) which set of pictures each member saw; equal pictures are one set."""
    known: list[Float32Array] = []
    out = []
    for member in members:
        images = member.data.images
        same = (i for i, other in enumerate(known) if other is images)
        equal = (i for i, other in enumerate(known) if np.array_equal(other, images))
        at = next(same, None)
        at = next(equal, len(known)) if at is None else at
        if at == len(known):
            known.append(images)
        out.append(at)
    return out


def _first_weights(
    members: Sequence[Member], steps: int, where: torch.device
) -> tuple[dict[str, Tensor], _Noise | None]:
    """Stacked first weights, and the noise; None where no member needs any.

    Members of one seed start alike and hear the same noise.
    """
    starts: dict[int, tuple[dict[str, Tensor], Tensor]] = {}
    data = members[0].data
    for member in members:
        if member.seed in starts:
            continue
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(member.seed)
            net = Network(len(data.types), data.control.shape[1])
            starts[member.seed] = net.state_dict(), torch.get_rng_state()
    weights = {
        name: torch.stack([starts[m.seed][0][name] for m in members]).to(where).requires_grad_()
        for name in starts[members[0].seed][0]
    }
    if not any(m.beta > 0 for m in members):
        return weights, None
    drawn = []
    for _, state in starts.values():
        source = torch.Generator()
        source.set_state(state)
        shape = (len(data.images), LATENT)
        drawn.append(torch.stack([torch.randn(shape, generator=source) for _ in range(steps)]))
    heard = torch.tensor([list(starts).index(m.seed) for m in members], device=where)
    return weights, _Noise(torch.stack(drawn, dim=1).to(where), heard)


@dataclass(frozen=True)
class _Noise:
    """Normal noise of all steps, kept once a seed: (steps, seeds, S, 15) and the seed of each."""

    by_seed: Tensor
    heard: Tensor

    def at(self, step: int) -> Tensor:
        """(M, S, 15)"""
        return self.by_seed[step][self.heard]


class _Batch:
    """What the members of a stack learn from, on the device; their losses and its sum."""

    def __init__(self, members: Sequence[Member], sets: Sequence[int], where: torch.device) -> None:
        self.n_decoded = sum(m.alpha > 0 for m in members)
        # Channels last is a quarter to a third faster on a CPU; elsewhere torch's own layout.
        layout = torch.channels_last if where.type == "cpu" else torch.contiguous_format
        self.layout = layout
        self.spans: list[tuple[Tensor, slice]] = []
        images: dict[int, Tensor] = {}
        for (_, at), group in groupby(
            range(len(members)), lambda k: (members[k].alpha == 0, sets[k])
        ):
            rows = list(group)
            if at not in images:
                picture = torch.from_numpy(members[rows[0]].data.images)
                images[at] = picture.to(where).contiguous(memory_format=layout)
            self.spans.append((images[at], slice(rows[0], rows[-1] + 1)))

        def column(values: list[float]) -> Tensor:
            return torch.tensor(values, dtype=torch.float32, device=where)

        self.alpha = column([m.alpha for m in members][: self.n_decoded])
        self.beta = column([m.beta for m in members])
        self.gamma = column([m.gamma for m in members])
        self.noisy = (self.beta > 0).float()[:, None, None]
        shown = _shown(members)
        self.scene, self.control, self.valid, self.share = (x.to(where) for x in shown)

    def loss(
        self, weights: dict[str, Tensor], noise: Tensor | None, kind: str, precision: str
    ) -> Tensor:
        """The sum of the members' losses."""
        low = torch.autocast(kind, dtype=torch.bfloat16, enabled=precision == "bfloat16")
        with low:
            code = self._encode(weights)
        mean, log_variance = code.float().chunk(2, dim=2)
        log_variance = log_variance.clamp(-_CLAMP, _CLAMP)
        latent = mean
        if noise is not None:
            latent = mean + self.noisy * torch.exp(0.5 * log_variance) * noise
        logits = self._classify(weights, latent)
        wrong = functional.binary_cross_entropy_with_logits(logits, self.valid, reduction="none")
        loss = (self.gamma * (wrong * self.share).sum(dim=(1, 2))).sum()
        if self.n_decoded:
            with low:
                pictures = self._decode(weights, latent[: self.n_decoded])
            loss = loss + (self.alpha * self._errors(pictures)).sum() / 100
        if noise is not None:
            kl = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance)
            loss = loss + (self.beta * kl.sum(dim=2).mean(dim=1)).sum()
        return loss

    def _encode(self, weights: dict[str, Tensor]) -> Tensor:
        """Mean and log-variance of every member and picture, (M, S, 30)."""
        w, b = weights["encoder.0.weight"], weights["encoder.0.bias"]
        first = [
            functional.conv2d(x, w[at].flatten(0, 1), b[at].flatten(), stride=2, padding=1)
            for x, at in self.spans
        ]
        x = first[0] if len(first) == 1 else torch.cat(first, dim=1)
        x = functional.elu(x, inplace=True)
        members = len(w)
        for name in ("encoder.2", "encoder.4"):
            w, b = weights[f"{name}.weight"], weights[f"{name}.bias"]
            x = functional.conv2d(
                x, w.flatten(0, 1), b.flatten(), stride=2, padding=1, groups=members
            )
            x = functional.elu(x, inplace=True)
        x = x.reshape(len(x), members, -1).transpose(0, 1)
        w, b = weights["encoder.7.weight"], weights["encoder.7.bias"]
        return torch.baddbmm(b[:, None], x, w.transpose(1, 2))

    def _decode(self, weights: dict[str, Tensor], latent: Tensor) -> Tensor:
        """(D, S, 15) of the first D members → pictures before the sigmoid, (S, D·3, 100, 100)."""
        members, scenes, _ = latent.shape
        w, b = (weights[f"decoder.0.{part}"][:members] for part in ("weight", "bias"))
        x = functional.elu(torch.baddbmm(b[:, None], latent, w.transpose(1, 2)), inplace=True)
        x = x.transpose(0, 1).reshape(scenes, -1, _SIDE, _SIDE)
        x = x.contiguous(memory_format=self.layout)
        for name, more in (("decoder.3", 0), ("decoder.5", 1), ("decoder.7", 1)):
            w, b = (weights[f"{name}.{part}"][:members] for part in ("weight", "bias"))
            x = functional.conv_transpose2d(
                x, w.flatten(0, 1), b.flatten(), stride=2, padding=1, output_padding=more,
                groups=members,
            )  # fmt: skip
            if name != "decoder.7":
                x = functional.elu(x, inplace=True)
        return x

    def _errors(self, pictures: Tensor) -> Tensor:
        """Sum of squared errors of a picture, mean over scenes, (D,)."""
        seen = torch.sigmoid(pictures.float())
        parts = []
        for x, at in self.spans:
            if at.start < self.n_decoded:
                mine = seen[:, 3 * at.start : 3 * at.stop]
                mine = mine.reshape(len(x), -1, *x.shape[1:])
                parts.append((mine - x[:, None]).square().sum(dim=(2, 3, 4)).mean(dim=0))
        return torch.cat(parts)

    def _classify(self, weights: dict[str, Tensor], latent: Tensor) -> Tensor:
        """Logits (M, T, N) of the demonstrations by member and type."""
        members, types, n = self.scene.shape
        rows = self.scene.reshape(members, -1, 1).expand(-1, -1, LATENT)
        z = latent.gather(1, rows).reshape(members, types, n, LATENT)
        x = torch.cat([z, self.control], dim=3)
        x = torch.tanh(x @ weights["w1"] + weights["b1"][:, :, None])
        x = torch.tanh(x @ weights["w2"] + weights["b2"][:, :, None])
        return (x @ weights["w3"][..., None]).squeeze(3) + weights["b3"][..., None]


def _shown(members: Sequence[Member]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Demonstrations by member and type, (M, T, N): scene, control (…, c), label, share.

    Members and types with fewer are filled up with demonstrations that have no share in the mean.
    """
    types = len(members[0].data.types)
    rows = [[np.flatnonzero(m.data.type == t) for t in range(types)] for m in members]
    most = max(len(r) for mine in rows for r in mine)
    shape = (len(members), types, most)
    scene = np.zeros(shape, np.int64)
    control = np.zeros((*shape, members[0].data.control.shape[1]), np.float32)
    valid, share = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for k, (member, mine) in enumerate(zip(members, rows, strict=True)):
        data = member.data
        for t, r in enumerate(mine):
            scene[k, t, : len(r)] = data.scene[r]
            control[k, t, : len(r)] = data.control[r]
            valid[k, t, : len(r)] = data.valid[r]
            share[k, t, : len(r)] = 1.0 / len(data.type)
    a, b, c, d = (torch.from_numpy(x) for x in (scene, control, valid, share))
    return a, b, c, d


def find_device(name: str) -> torch.device:
    """The device of that name; InputError where this build of PyTorch cannot use it."""
    try:
        found = torch.device(name)
        torch.zeros(1, device=found).cpu()  # a device that has a name need not be there
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        expected = "a device that this build of PyTorch can use, such as cpu or cuda"
        raise InputError(expected, name, field="device") from error
    return found


def _exact(where: torch.device) -> contextlib.AbstractContextManager[object]:
    """Within it float32 means float32: by default cuDNN rounds factors of convolutions to TF32."""
    if where.type != "cuda":
        return contextlib.nullcontext()
    return torch.backends.cudnn.flags(
        enabled=True, benchmark=True, deterministic=False, allow_tf32=False
    )
