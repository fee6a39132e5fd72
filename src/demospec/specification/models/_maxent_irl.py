"""The paper's baseline: maximum-entropy inverse reinforcement learning, r_s(p, I).

P(z_θ) ∝ exp(R) over the curves of a scene, R = mean of r_s along the curve, r_s linear in
features of the point p and the picture I around it. Each type's weights maximise the likelihood
of its accepted demonstrations. A trajectory is judged by its own reward: valid where R exceeds a
threshold fitted to the labels (logistic regression on R alone).

Source: Ziebart et al. 2008; Angelov et al. 2020, baseline. Differs: the partition sum runs over
a grid of control points, which is exact for order-2 curves; features are colours at three
scales, edges and place, because the paper does not list its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, Paths, bezier_points, resample
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.geometry import read_map
from demospec.progress import Progress, silent
from demospec.scene import Scene
from demospec.specification.latent._control_plane import PLANE_MARGIN
from demospec.specification.models._folder import ModelFolder, provenance_of
from demospec.specification.models._stored_model import LogisticView, StoredModel, settings_of
from demospec.specification.models.beta_vae._training_data import (
    PICTURE_PX,
    labelled_rows,
    network_image,
    picture_size,
    types_in_use,
)

FEATURES: Final = 19
_POINTS = 40


@dataclass(frozen=True)
class IrlSettings:
    """How the reward is fitted.

    Args:
        l2: Weight of the squared reward weights against the mean log-likelihood.
        grid: Control points along a side of the partition sum.
    """

    l2: float = 1e-3
    grid: int = 21

    def __post_init__(self) -> None:
        if not isinstance(self.l2, (int, float)) or not 0 <= self.l2 < 1e6:
            raise InputError("a number ≥ 0", self.l2, field="l2")
        if not isinstance(self.grid, int) or not 3 <= self.grid <= 200:
            raise InputError("a whole number from 3 to 200", self.grid, field="grid")


class IrlModel(StoredModel[IrlSettings]):
    """A reward per type. Sees pictures only.

    Args:
        types: User types, in the order of the weights.
        settings: How it was fitted.
        weights: ``reward`` (T, F), ``mean`` and ``spread`` of the features (F,), ``slope`` and
            ``threshold`` (T,) of the decision slope·(R − threshold).
        provenance: Versions, seed, data hash.
    """

    kind = "irl"

    @classmethod
    def fit(
        cls,
        data: DemonstrationSet,
        *,
        seed: int = 0,
        progress: Progress = silent,
        settings: IrlSettings | None = None,
    ) -> IrlModel:
        """Fits to the labelled demonstrations of all scenes of `data`; nothing is random.

        Raises:
            InputError: No labelled demonstrations, or a scene without a picture.
        """
        settings = settings or IrlSettings()
        rows = labelled_rows(data)
        d = data.demonstrations.rows(rows)
        types = types_in_use(data, d.type)
        sums = _path_features(data, d, settings, progress)
        mean, spread = sums.pixels_mean, sums.pixels_spread
        weights: dict[str, list[Any]] = {"reward": [], "slope": [], "threshold": []}
        for done, type_ in enumerate(types):
            mine = d.type == type_
            shown = mine & (d.valid == 1)
            reward = np.zeros(FEATURES)
            if shown.any():
                reward = _max_entropy(sums, np.flatnonzero(shown), settings.l2)
            returns = (sums.paths[mine] - mean) / spread @ reward
            slope, threshold = _threshold(returns, d.valid[mine] == 1)
            weights["reward"].append(reward)
            weights["slope"].append(slope)
            weights["threshold"].append(threshold)
            progress("fitting rewards", done + 1, len(types))
        arrays = {k: np.array(v, dtype=np.float32) for k, v in weights.items()}
        arrays["mean"] = mean.astype(np.float32)
        arrays["spread"] = spread.astype(np.float32)
        provenance = provenance_of(data, seed=seed, libraries=("scipy",))
        return cls(types, settings, arrays, provenance)

    def see(self, scene: Scene) -> IrlView:
        """Computes the reward at every pixel once; CannotJudgeError without a picture."""
        size = picture_size(scene)
        features = (image_features(scene) - self.weights["mean"]) / self.weights["spread"]
        return IrlView(self, scene, features @ self.weights["reward"].T, size)

    @classmethod
    def of(cls, stored: ModelFolder) -> IrlModel:
        """The model of a folder that was read."""
        settings = settings_of(IrlSettings, stored)
        n = len(stored.types)
        shapes = {"reward": (n, FEATURES), "slope": (n,), "threshold": (n,),
                  "mean": (FEATURES,), "spread": (FEATURES,)}  # fmt: skip
        weights = {name: stored.weight(name, shape) for name, shape in shapes.items()}
        return cls(stored.types, settings, weights, dict(stored.provenance))


class IrlView(LogisticView):
    """Rewards of one scene as a picture, (100, 100, T); a path's return is their mean along it."""

    def __init__(
        self, model: IrlModel, scene: Scene, rewards: FloatArray, size_px: tuple[int, int]
    ) -> None:
        self.model = model
        self.scene = scene
        self.rewards = rewards
        self._scale = PICTURE_PX / np.array(size_px, dtype=np.float64)

    def logits(self, paths: Paths, type: str) -> FloatArray:
        t = self._index(type)
        returns = means_along(self.rewards[:, :, t, None], paths, self._scale)[:, 0]
        w = self.model.weights
        return np.asarray(float(w["slope"][t]) * (returns - float(w["threshold"][t])))

    def _index(self, type: str) -> int:
        if type not in self.model.types:
            raise InputError(f"one of the types {', '.join(self.model.types)}", type, field="type")
        return self.model.types.index(type)


def image_features(scene: Scene) -> FloatArray:
    """Features of every pixel of the 100×100 picture: (100, 100, FEATURES).

    Colour minus the picture's median colour, at the pixel and blurred by 2 and 6 px; the size of
    these; edges at two scales; place: x, y, their squares and product, distance to the rim.
    """
    from scipy.ndimage import gaussian_filter, gaussian_gradient_magnitude

    image = network_image(scene).astype(np.float64)
    away = image - np.median(image, axis=(1, 2), keepdims=True)
    layers = list(away)
    blurred = [np.stack([gaussian_filter(c, s) for c in away]) for s in (2.0, 6.0)]
    for stack in blurred:
        layers += list(stack)
    layers += [np.abs(stack).sum(axis=0) for stack in (away, *blurred)]
    grey = image.mean(axis=0)
    layers += [gaussian_gradient_magnitude(grey, s) for s in (1.0, 3.0)]
    axis = (np.arange(PICTURE_PX) + 0.5) / PICTURE_PX * 2 - 1
    x, y = np.meshgrid(axis, axis)
    layers += [x, y, x * x + y * y, x * y, np.maximum(np.abs(x), np.abs(y))]
    return np.stack(layers, axis=-1)


def means_along(layers: FloatArray, paths: Paths, scale: FloatArray) -> FloatArray:
    """Mean over arc length of layers (h, w, F) along paths, (n, F); `scale` takes them there.

    Stacked paths of at least `_POINTS` points are read at these points, others resampled.
    """
    if isinstance(paths, np.ndarray) and paths.ndim == 3 and paths.shape[1] >= _POINTS:
        points = paths[..., :2] * scale
    else:
        points = np.stack([resample(np.asarray(p)[:, :2], 2 * _POINTS) for p in paths]) * scale
    steps = np.linalg.norm(np.diff(points, axis=1), axis=2)
    weight = np.zeros(points.shape[:2])
    weight[:, 1:] += steps
    weight[:, :-1] += steps
    weight += 1e-9  # a path without length is its point
    values = read_map(layers, points, (layers.shape[1], layers.shape[0]))
    return np.asarray(np.einsum("nm,nmf->nf", weight / weight.sum(axis=1, keepdims=True), values))


@dataclass(frozen=True)
class _Sums:
    """Mean features of the demonstrations' paths, and of the grid of curves in each scene."""

    paths: FloatArray  # (n, F)
    scene: NDArray[np.int64]  # (n,) row in `grids`
    grids: FloatArray  # (S, G, F)
    pixels_mean: FloatArray  # (F,)
    pixels_spread: FloatArray  # (F,)


def _path_features(data: DemonstrationSet, d: Any, s: IrlSettings, progress: Progress) -> _Sums:
    index = np.array([data.scene_index[name] for name in d.scene_id])
    used, scene = np.unique(index, return_inverse=True)
    paths = np.empty((len(d), FEATURES))
    grids, means, squares = [], [], []
    for row, i in enumerate(used):
        place = data.scenes[int(i)]
        size = np.array(picture_size(place), dtype=np.float64)
        layers = image_features(place)
        mine = np.flatnonzero(scene == row)
        paths[mine] = means_along(layers, d.paths_xy(mine), PICTURE_PX / size)
        axes = [np.linspace(-PLANE_MARGIN * v, (1 + PLANE_MARGIN) * v, s.grid) for v in size]
        control = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 1, 2)
        curves = bezier_points(
            np.broadcast_to(place.start[:2], (len(control), 2)),
            np.asarray(place.goal[:2]), control, 60,
        )  # fmt: skip
        grids.append(means_along(layers, curves, PICTURE_PX / size))
        means.append(layers.mean(axis=(0, 1)))
        squares.append((layers**2).mean(axis=(0, 1)))
        progress("features", row + 1, len(used))
    mean = np.mean(means, axis=0)
    spread = np.sqrt(np.maximum(np.mean(squares, axis=0) - mean**2, 1e-8))
    return _Sums(paths, scene.astype(np.int64), np.stack(grids), mean, spread)


def _max_entropy(sums: _Sums, shown: NDArray[np.int64], l2: float) -> FloatArray:
    """ModelWeights (F,) that maximise mean log P(z_θ) − l2·|w|²: a convex problem."""
    from scipy.optimize import minimize
    from scipy.special import logsumexp

    demo = (sums.paths[shown] - sums.pixels_mean) / sums.pixels_spread
    grids = (sums.grids - sums.pixels_mean) / sums.pixels_spread
    scene = sums.scene[shown]
    share = np.bincount(scene, minlength=len(grids)) / len(shown)
    target = demo.mean(axis=0)

    def loss(w: FloatArray) -> tuple[float, FloatArray]:
        returns = grids @ w
        total = logsumexp(returns, axis=1)
        p = np.exp(returns - total[:, None])
        expected = share @ np.einsum("sg,sgf->sf", p, grids)
        value = float(share @ total - target @ w + l2 * (w @ w))
        return value, np.asarray(expected - target + 2 * l2 * w)

    found = minimize(loss, np.zeros(FEATURES), jac=True, method="L-BFGS-B")
    return np.asarray(found.x)


def _threshold(returns: FloatArray, valid: NDArray[np.bool_]) -> tuple[float, float]:
    """(slope, threshold) of the decision slope·(R − threshold), both classes weighing the same.

    Where only one label occurs the threshold lies beyond every return seen, on its side.
    """
    if valid.all() or not valid.any():
        spread = float(returns.std()) + 1e-3
        edge = returns.min() - spread if valid.any() else returns.max() + spread
        return 1.0 / spread, float(edge)
    order = np.argsort(returns, kind="stable")
    ordered, label = returns[order], valid[order]
    # Balanced accuracy of "valid above the cut" for every cut between two returns.
    missed = np.concatenate([[0], np.cumsum(label)]) / label.sum()
    caught = np.concatenate([[0], np.cumsum(~label)]) / (~label).sum()
    best = int(np.argmax(caught - missed))
    edges = np.concatenate([[ordered[0] - 1e-6], (ordered[1:] + ordered[:-1]) / 2,
                            [ordered[-1] + 1e-6]])  # fmt: skip
    spread = float(returns.std()) + 1e-9
    return 1.0 / spread, float(edges[best])
