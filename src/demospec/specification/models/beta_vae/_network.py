"""The paper's network: β-VAE of the scene, a classifier on [z_I, z_θ] for every user type.

Source: Angelov et al. 2020, "Specification model". Encoder: 3×3 convolutions with 16, 8, 4
channels, fully connected to z_I ∈ R¹⁵; mirrored decoder; 3-layer classifier.
Differs: the paper does not state strides and activations; we take stride 2 and ELU in the
convolutions, tanh in the classifier (smooth, so that its gradient repairs paths). The types
share encoder and decoder; each has its own classifier. Training is in `_stacked_steps`, the
classifier's verdict in `_paper.PaperView`.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn

from demospec.specification.models.beta_vae._training_data import Float32Array

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
