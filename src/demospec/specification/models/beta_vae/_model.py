"""The paper's specification model C_s(z_I, z_θ) → v̂ as a `ValidityModel`.

Source: Angelov et al. 2020, "Specification model" and its ablations. Loss
−α·reconstruction + β·KL − γ·log-likelihood of v; see `_stacked_steps.train_stack` for
the signs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, Paths
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.scene import Image, Scene
from demospec.specification.models._folder import ModelFolder, ModelWeights, provenance_of
from demospec.specification.models._stored_model import LogisticView, StoredModel, settings_of
from demospec.specification.models.beta_vae._stacked import (
    PRECISIONS,
    StackedJob,
    require_torch,
    train_stacked,
)
from demospec.specification.models.beta_vae._training_data import (
    TrainingData,
    bezier_controls,
    bezier_inverse,
    network_image,
    normalised,
    picture_size,
    training_data,
)

if TYPE_CHECKING:
    from demospec.specification.models.beta_vae._network import Network

LATENT: Final = 15
ABLATIONS: Final = ("full", "autoencoder", "classifier")

Float32Array = NDArray[np.float32]


@dataclass(frozen=True)
class PaperSettings:
    """How the paper's model is trained.

    Args:
        ablation: ``full``; ``autoencoder`` (β = 0: no noise, no KL); ``classifier``
            (α = β = 0: no decoder either).
        alpha: Weight of the picture's sum of squared errors / 100.
        beta: Weight of KL(z_I ‖ N(0, 1)).
        gamma: Weight of the log-likelihood.
        steps: Full-batch steps of Adam with a one-cycle schedule.
        learning_rate: Its peak.
        order: Order of the Bézier re-parameterization (paper: 2).
        device: Where torch trains: ``cpu``, ``cuda``, ``cuda:1``, … Models judge on the CPU.
        precision: ``float32``; or ``bfloat16`` for encoder and decoder while training: loss, KL,
            classifier and optimiser stay in ``float32``, and so does the fitted model.
    """

    ablation: Literal["full", "autoencoder", "classifier"] = "full"
    alpha: float = 0.1
    beta: float = 1e-4
    gamma: float = 1.0
    steps: int = 300
    learning_rate: float = 3e-3
    order: int = 2
    device: str = "cpu"
    precision: Literal["float32", "bfloat16"] = "float32"

    def __post_init__(self) -> None:
        if self.ablation not in ABLATIONS:
            raise InputError(", ".join(ABLATIONS), self.ablation, field="ablation")
        if self.precision not in PRECISIONS:
            raise InputError(", ".join(PRECISIONS), self.precision, field="precision")
        if not isinstance(self.device, str):
            raise InputError("the name of a device", self.device, field="device")
        for name in ("alpha", "beta", "gamma", "learning_rate"):
            value = getattr(self, name)
            if not isinstance(value, (int, float)) or not 0 <= value < 1e6:
                raise InputError("a number ≥ 0", value, field=name)
        for name, low in (("steps", 2), ("order", 2)):
            value = getattr(self, name)
            if not isinstance(value, int) or not low <= value <= 1_000_000:
                raise InputError(f"a whole number ≥ {low}", value, field=name)

    @property
    def weights(self) -> tuple[float, float, float]:
        """(α, β, γ) after the ablation."""
        alpha = 0.0 if self.ablation == "classifier" else self.alpha
        beta = self.beta if self.ablation == "full" else 0.0
        return alpha, beta, self.gamma


class PaperModel(StoredModel[PaperSettings]):
    """The paper's model, fitted. Sees pictures only; knows nothing of object lists.

    Args:
        types: User types, in the order of the classifier heads.
        settings: How it was trained.
        weights: Arrays by name, as `_vae.Network` names them.
        provenance: Versions, seed, data hash.
    """

    kind = "paper"

    @classmethod
    def fit(
        cls,
        data: DemonstrationSet,
        *,
        seed: int = 0,
        progress: Progress = silent,
        settings: PaperSettings | None = None,
    ) -> PaperModel:
        """Fits to the labelled demonstrations of all scenes of `data`.

        Raises:
            InputError: No labelled demonstrations, or a scene without a picture.
            MissingExtraError: torch is absent.
        """
        settings = settings or PaperSettings()
        arrays = training_data(data, order=settings.order)
        weights = train_weights(arrays, settings, seed=seed, progress=progress)
        provenance = provenance_of(data, seed=seed, libraries=("torch",))
        return cls(arrays.types, settings, weights, provenance)

    def see(self, scene: Scene) -> PaperView:
        """Encodes the picture once; CannotJudgeError where there is none."""
        size = picture_size(scene)
        return PaperView(self, scene, self.encode(scene), size)

    def encode(self, scene: Scene) -> Float32Array:
        """z_I, the mean of q(z_I | I), (15,)."""
        import torch

        with torch.no_grad():
            mean, _ = self._network.encode(torch.from_numpy(network_image(scene))[None])
        return np.asarray(mean[0].numpy())

    def reconstruct(self, scene: Scene) -> Image:
        """The picture after encoder and decoder, (100, 100, 3)."""
        return np.asarray(self.decode(self.encode(scene)[None])[0], dtype=np.uint8)

    def decode(self, latent: NDArray[Any]) -> Image:
        """Pictures (n, 100, 100, 3) of latent points (n, 15).

        Raises:
            InputError: The ablation ``classifier`` trains no decoder.
        """
        import torch

        if self.settings.ablation == "classifier":
            raise InputError(
                "a model with a decoder (ablation full or autoencoder)",
                "classifier",
                field="ablation",
            )
        with torch.no_grad():
            pictures = self._network.decode(torch.from_numpy(np.float32(latent)))
        bytes_ = (pictures.numpy().transpose(0, 2, 3, 1) * 255 + 0.5).astype(np.uint8)
        return np.asarray(bytes_)

    def sample_scenes(self, n: int, rng: np.random.Generator) -> Image:
        """Pictures (n, 100, 100, 3) of latent points drawn from the prior N(0, 1)."""
        return self.decode(rng.standard_normal((n, LATENT)))

    @classmethod
    def of(cls, stored: ModelFolder) -> PaperModel:
        """The model of a folder that was read."""
        settings = settings_of(PaperSettings, stored)
        n_in = LATENT + 2 * (settings.order - 1)
        first = stored.weight("w1", (len(stored.types), n_in, None))
        hidden = first.shape[2]
        for name, shape in (
            ("b1", (hidden,)), ("w2", (hidden, hidden)), ("b2", (hidden,)), ("w3", (hidden,)),
            ("b3", ()),
        ):  # fmt: skip
            stored.weight(name, (len(stored.types), *shape))
        model = cls(stored.types, settings, stored.weights, dict(stored.provenance))
        try:
            _ = model._network
        except RuntimeError as error:
            place = None if stored.path is None else stored.path / "weights.safetensors"
            raise InputError("the weights of this network", str(error), file=place) from error
        return model

    @cached_property
    def _network(self) -> Network:
        require_torch()
        from demospec.specification.models.beta_vae._network import network

        return network(self.weights)


def train_weights(
    arrays: TrainingData, settings: PaperSettings, *, seed: int, progress: Progress = silent
) -> ModelWeights:
    """The weights that training on these arrays gives; same seed, same weights."""
    job = StackedJob(arrays, settings, seed)
    found = train_stacked(
        [job], device=settings.device, precision=settings.precision, progress=progress
    )
    return found[0]


class PaperView(LogisticView):
    """The paper's model after it has seen one scene: a small network on z_θ alone."""

    def __init__(
        self, model: PaperModel, scene: Scene, latent: Float32Array, size_px: tuple[int, int]
    ) -> None:
        self.model = model
        self.scene = scene
        self.latent = latent
        self._half = np.array(size_px, dtype=np.float64) / 2
        self._heads: dict[str, tuple[Float32Array, ...]] = {}

    @property
    def order(self) -> int:
        """Order of the Bézier curves it thinks in."""
        return self.model.settings.order

    def logits(self, paths: Paths, type: str) -> FloatArray:
        return self.control_logits(bezier_controls(paths, self.order), type)

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        """Exact where the paths are Bézier curves of the model's order at uniform parameter.

        Elsewhere the logit is that of the refined Bz and the gradient that of the linear one.
        """
        controls = bezier_controls(paths, self.order)
        logits, slope = self.control_logits_and_gradients(controls, type)
        ends, _, inverse = bezier_inverse(self.order, paths.shape[1])
        gradient = inverse.T @ slope
        gradient[:, [0, -1]] -= (inverse @ ends).T @ slope
        return logits, gradient

    def control_logits(self, controls: FloatArray, type: str) -> FloatArray:
        """Logits (n,) of control points (n, order − 1, 2), pixels."""
        w1, b1, w2, b2, w3, b3 = self._head(type)
        x = np.tanh(self._inputs(controls) @ w1 + b1)
        x = np.tanh(x @ w2 + b2)
        return np.asarray((x @ w3 + b3).astype(np.float64))

    def control_logits_and_gradients(
        self, controls: FloatArray, type: str
    ) -> tuple[FloatArray, FloatArray]:
        """Logits (n,) and ∂logit/∂control (n, order − 1, 2), 1/pixels."""
        w1, b1, w2, b2, w3, b3 = self._head(type)
        x1 = np.tanh(self._inputs(controls) @ w1 + b1)
        x2 = np.tanh(x1 @ w2 + b2)
        slope = ((1 - x2 * x2) * w3) @ w2.T
        slope = ((1 - x1 * x1) * slope) @ w1.T
        gradient = slope.astype(np.float64).reshape(controls.shape) / self._half
        return np.asarray((x2 @ w3 + b3).astype(np.float64)), gradient

    def _inputs(self, controls: FloatArray) -> Float32Array:
        flat = normalised(controls, 2 * self._half).reshape(len(controls), -1)
        return flat.astype(np.float32)

    def _head(self, type: str) -> tuple[Float32Array, ...]:
        if type not in self._heads:
            if type not in self.model.types:
                raise InputError(
                    f"one of the types {', '.join(self.model.types)}", type, field="type"
                )
            t = self.model.types.index(type)
            w1, b1, w2, b2, w3, b3 = (
                self.model.weights[k][t] for k in ("w1", "b1", "w2", "b2", "w3", "b3")
            )
            # z_I is fixed in this view: its share of the first layer becomes part of the bias.
            bias = self.latent @ w1[:LATENT] + b1
            self._heads[type] = (np.ascontiguousarray(w1[LATENT:]), bias, w2, b2, w3, b3)
        return self._heads[type]
