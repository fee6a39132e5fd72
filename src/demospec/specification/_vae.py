"""The paper's network: β-VAE of the scene, a classifier on [z_I, z_θ] for every user type.

Source: Angelov et al. 2020, "Specification model". Encoder: 3×3 convolutions with 16, 8, 4
channels, fully connected to z_I ∈ R¹⁵; mirrored decoder; 3-layer classifier.
Differs: the paper does not state strides and activations; we take stride 2 and ELU in the
convolutions, tanh in the classifier (smooth, so that its gradient repairs paths). The types
share encoder and decoder; each has its own classifier.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor, nn

from demospec.errors import InputError
from demospec.specification._training_data import Float32Array, TrainingData

LATENT = 15
HIDDEN = 64
_MAP = 13  # side of the last feature map of a 100×100 picture
_CHANNELS = 4


class Network(nn.Module):
    """Encoder, decoder and one classifier head per type, heads stacked on the first axis."""

    def __init__(self, n_types: int, n_control: int) -> None:
        super().__init__()
        self.encoder = nn.Sequential(
            nn.Conv2d(3, 16, 3, stride=2, padding=1),
            nn.ELU(),
            nn.Conv2d(16, 8, 3, stride=2, padding=1),
            nn.ELU(),
            nn.Conv2d(8, _CHANNELS, 3, stride=2, padding=1),
            nn.ELU(),
            nn.Flatten(),
            nn.Linear(_CHANNELS * _MAP * _MAP, 2 * LATENT),
        )
        self.decoder = nn.Sequential(
            nn.Linear(LATENT, _CHANNELS * _MAP * _MAP),
            nn.ELU(),
            nn.Unflatten(1, (_CHANNELS, _MAP, _MAP)),
            nn.ConvTranspose2d(_CHANNELS, 8, 3, stride=2, padding=1),
            nn.ELU(),
            nn.ConvTranspose2d(8, 16, 3, stride=2, padding=1, output_padding=1),
            nn.ELU(),
            nn.ConvTranspose2d(16, 3, 3, stride=2, padding=1, output_padding=1),
            nn.Sigmoid(),
        )
        n_in = LATENT + n_control
        # Twice the usual spread: the boundary turns within a few pixels of z_θ, and from a
        # gentler start 300 steps do not fit nine demonstrations a scene.
        self.w1 = nn.Parameter(torch.randn(n_types, n_in, HIDDEN) * 2 / n_in**0.5)
        self.b1 = nn.Parameter(torch.zeros(n_types, HIDDEN))
        self.w2 = nn.Parameter(torch.randn(n_types, HIDDEN, HIDDEN) / HIDDEN**0.5)
        self.b2 = nn.Parameter(torch.zeros(n_types, HIDDEN))
        self.w3 = nn.Parameter(torch.randn(n_types, HIDDEN) / HIDDEN**0.5)
        self.b3 = nn.Parameter(torch.zeros(n_types))

    def encode(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """(S, 3, 100, 100) → mean and log-variance of z_I, (S, 15) each."""
        mean, log_variance = self.encoder(images).chunk(2, dim=1)
        return mean, log_variance.clamp(-12.0, 12.0)

    def decode(self, latent: Tensor) -> Tensor:
        """(S, 15) → pictures (S, 3, 100, 100) in [0, 1]."""
        return torch.as_tensor(self.decoder(latent))

    def classify(self, latent: Tensor, control: Tensor) -> Tensor:
        """(N, 15), (N, c) → logits (T, N), one row per type."""
        x = torch.cat([latent, control], dim=1)
        x = torch.tanh(x @ self.w1 + self.b1[:, None])
        x = torch.tanh(x @ self.w2 + self.b2[:, None])
        return (x * self.w3[:, None]).sum(dim=2) + self.b3[:, None]


def train(
    data: TrainingData,
    *,
    alpha: float,
    beta: float,
    gamma: float,
    steps: int,
    learning_rate: float,
    seed: int,
    device: str = "cpu",
    step_done: Callable[[int, float], None],
) -> dict[str, Float32Array]:
    """Trains a network on the full batch; the weights, by name.

    Minimises α·reconstruction/100 + β·KL + γ·(−log-likelihood), where reconstruction is the
    sum of squared errors of a picture, KL that of a picture's z_I against N(0, 1), both averaged
    over scenes, and the log-likelihood is averaged over demonstrations. (The paper writes the
    same with the signs of a maximisation on two of its terms.)

    Args:
        device: Where torch trains. First weights and noise are drawn on the CPU, so that devices
            differ by rounding only.

    Raises:
        InputError: There is no such device here.
    """
    where = _device(device)
    with torch.random.fork_rng(devices=[]), one_thread():
        torch.manual_seed(seed)
        net = Network(len(data.types), data.control.shape[1]).to(where)
        images = torch.from_numpy(data.images).to(where)
        scene = torch.from_numpy(data.scene).to(where)
        control = torch.from_numpy(data.control).to(where)
        valid = torch.from_numpy(data.valid).to(where)
        row = torch.arange(len(data.type), device=where)
        type_ = torch.from_numpy(data.type).to(where)
        # Without reconstruction and KL the decoder and the noise have no part in the loss.
        stochastic = beta > 0
        optimiser = torch.optim.Adam(net.parameters(), lr=learning_rate, foreach=True)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, learning_rate, steps)
        for step in range(steps):
            mean, log_variance = net.encode(images)
            latent = mean
            if stochastic:
                noise = torch.randn(mean.shape).to(where)
                latent = mean + torch.exp(0.5 * log_variance) * noise
            logits = net.classify(latent[scene], control)[type_, row]
            loss = gamma * nn.functional.binary_cross_entropy_with_logits(logits, valid)
            if alpha > 0:
                error = (net.decode(latent) - images).square().sum(dim=(1, 2, 3)).mean()
                loss = loss + alpha * error / 100
            if beta > 0:
                kl = 0.5 * (mean.square() + log_variance.exp() - 1 - log_variance)
                loss = loss + beta * kl.sum(dim=1).mean()
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            step_done(step + 1, float(loss.detach()))
    return {name: np.array(value.cpu().numpy()) for name, value in net.state_dict().items()}


def _device(name: str) -> torch.device:
    try:
        found = torch.device(name)
        torch.zeros(1, device=found).cpu()  # a device that has a name need not be there
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        expected = "a device that this build of PyTorch can use, such as cpu or cuda"
        raise InputError(expected, name, field="device") from error
    return found


def network(weights: dict[str, Float32Array]) -> Network:
    """A network with the given weights, ready to see pictures."""
    n_types, n_in, _ = weights["w1"].shape
    with torch.random.fork_rng(devices=[]):
        net = Network(n_types, n_in - LATENT)
    net.load_state_dict({k: torch.from_numpy(np.array(v)) for k, v in weights.items()})
    return net.requires_grad_(False).eval()


class one_thread:
    """Within it torch uses one thread: two processes with two threads each crawl."""

    def __enter__(self) -> None:
        self.before = torch.get_num_threads()
        if self.before != 1:
            torch.set_num_threads(1)

    def __exit__(self, *exception: object) -> None:
        if self.before != 1:
            torch.set_num_threads(self.before)
