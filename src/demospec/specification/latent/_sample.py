"""Varied valid solutions for one type or for several at once: on every side of an object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import View
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.specification.latent._control_plane import ControlPlane, Types
from demospec.specification.latent._validity_map import ValidityMap, validity_map

LANGEVIN_STEPS = 40
_ROUNDS = 50


@dataclass(frozen=True)
class Samples:
    """Valid solutions of one scene and type.

    Args:
        control: (n, 1, 2), set units.
        points: (n, 100, 2), set units.
        p_valid: (n,) the model's own opinion.
        mode: (n,) which valid region of the z_θ plane each is from, 0 the largest.
        modes: How many such regions there are.
        diversity: Mean over pairs of the largest distance between their curves at equal
            parameter, set units; 0 for fewer than two.
        valid_share: Share of the z_θ plane that the model accepts.
    """

    control: FloatArray
    points: FloatArray
    p_valid: FloatArray
    mode: NDArray[np.int64]
    modes: int
    diversity: float
    valid_share: float

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec sample``."""
        return {
            "trajectories": [
                {
                    "control": self.control[i, 0].tolist(),
                    "points": self.points[i].tolist(),
                    "p_valid": float(self.p_valid[i]),
                    "mode": int(self.mode[i]),
                }
                for i in range(len(self.control))
            ],
            "modes": self.modes,
            "diversity": self.diversity,
            "valid_share": self.valid_share,
        }


def sample_valid(
    view: View,
    type: Types,
    n: int,
    *,
    seed: int = 0,
    confidence: float = 0.5,
    method: str = "map",
    size: int = 51,
) -> Samples:
    """Order-2 curves that the model accepts, from every valid region of the z_θ plane.

    The regions are the connected parts of the validity map: passing an object on its left and
    on its right are different parts, because no curve in between is valid. A region gets a share
    that grows with the square root of its area, and at least one curve where `n` allows.

    Args:
        view: A model that has seen the scene.
        type: One of its types; several for curves that all of them accept.
        n: How many; fewer come back where the model accepts next to nothing.
        confidence: Each sample's p(valid) exceeds this.
        method: ``map`` draws from the map's cells and keeps what the model accepts;
            ``langevin`` then walks on log p(valid), inside the same plane.
        size: Grid points of the map along a side.

    Raises:
        InputError: n < 1, or an unknown method.
    """
    if n < 1:
        raise InputError("at least 1 trajectory", n, field="n")
    if method not in ("map", "langevin"):
        raise InputError("map or langevin", method, field="method")
    rng = np.random.default_rng(seed)
    plane = ControlPlane(view)
    found = validity_map(view, type, size=size)
    labels, modes = regions(found.p_valid > confidence)
    wanted = _shares(labels, modes, n)
    controls, of_mode = [], []
    for mode in range(modes):
        z = _draw(plane, found, labels == mode, type, int(wanted[mode]), confidence, rng)
        controls.append(z)
        of_mode += [mode] * len(z)
    control = np.concatenate(controls) if controls else np.empty((0, 1, 2))
    if method == "langevin" and len(control):
        control = _langevin(plane, found, control, type, confidence, rng)
    points = plane.paths(control)
    return Samples(
        control=control,
        points=points,
        p_valid=plane.p_valid(control, type) if len(control) else np.empty(0),
        mode=np.array(of_mode, dtype=np.int64),
        modes=modes,
        diversity=diversity(points),
        valid_share=found.valid_share,
    )


def regions(accepted: NDArray[np.bool_]) -> tuple[NDArray[np.int64], int]:
    """Connected parts of a map: labels (ny, nx), 0 for the largest, −1 outside; and how many."""
    from scipy import ndimage

    # Cells that touch at a corner belong together: a thin slanted region is one region.
    raw, count = ndimage.label(accepted, structure=np.ones((3, 3)))
    areas = np.bincount(raw.ravel(), minlength=count + 1)[1:]
    order = np.argsort(-areas, kind="stable")
    rank = np.empty(count + 1, dtype=np.int64)
    rank[0] = -1
    rank[1 + order] = np.arange(count)
    return np.asarray(rank[np.asarray(raw)], dtype=np.int64), int(count)


def diversity(points: FloatArray) -> float:
    """Mean over pairs of paths (n, m, 2) of their largest distance at equal parameter."""
    n = len(points)
    if n < 2:
        return 0.0
    kept = points[:200]  # pairs grow with the square; two hundred paths say enough
    total = sum(
        float(np.linalg.norm(kept[i + 1 :] - kept[i], axis=2).max(axis=1).sum())
        for i in range(len(kept) - 1)
    )
    return total / (len(kept) * (len(kept) - 1) / 2)


def _shares(labels: NDArray[np.int64], modes: int, n: int) -> NDArray[np.int64]:
    """How many samples each region gives; their sum is n where there is a region."""
    wanted = np.zeros(modes, dtype=np.int64)
    if modes == 0:
        return wanted
    weight = np.sqrt(np.bincount(labels[labels >= 0], minlength=modes))
    wanted += np.floor(n * weight / weight.sum()).astype(np.int64)
    wanted[:n] = np.maximum(wanted[:n], 1)
    while wanted.sum() > n:
        wanted[int(wanted.argmax())] -= 1
    wanted[0] += n - wanted.sum()
    return wanted


def _draw(
    plane: ControlPlane,
    found: ValidityMap,
    cells: NDArray[np.bool_],
    type: Types,
    n: int,
    confidence: float,
    rng: np.random.Generator,
) -> FloatArray:
    """n accepted control points (n, 1, 2) spread over the cells of one region."""
    centres = found.controls[cells]
    spacing = np.array([found.x[1] - found.x[0], found.y[1] - found.y[0]])
    kept = centres[:0]
    for _ in range(_ROUNDS):
        if len(kept) >= n:
            break
        chosen = centres[rng.integers(len(centres), size=4 * n)]
        trial = chosen + rng.uniform(-0.5, 0.5, chosen.shape) * spacing
        accepted = plane.p_valid(trial[:, None], type) > confidence
        kept = np.concatenate([kept, trial[accepted]])
    if len(kept) < n:  # a region thinner than a cell: its grid points themselves are accepted
        kept = np.concatenate([kept, centres[rng.integers(len(centres), size=n - len(kept))]])
    return kept[:n, None]


def _langevin(
    plane: ControlPlane,
    seen: ValidityMap,
    control: FloatArray,
    type: Types,
    confidence: float,
    rng: np.random.Generator,
) -> FloatArray:
    """Unadjusted Langevin steps on log p = log σ(logit); a rejected step is not taken.

    The mode of a walker stays what it was: a step of a hundredth of the plane does not jump
    over an object.
    """
    low = np.array([seen.x[0], seen.y[0]])
    high = np.array([seen.x[-1], seen.y[-1]])
    step2 = float((0.01 * (high - low).max()) ** 2)
    z = control
    # The logit of a certain rule is a length: it counts in hundredths of the scene.
    certain = bool(np.isin(plane.p_valid(z, type), (0.0, 1.0)).all())
    unit = plane.view.scene.length_scale / 100 if certain else 1.0
    for _ in range(LANGEVIN_STEPS):
        logits, slope = (found / unit for found in plane.logits_and_gradients(z, type))
        p_invalid = 0.5 * (1 - np.tanh(0.5 * logits))
        drift = 0.5 * step2 * p_invalid[:, None, None] * slope
        norm = np.linalg.norm(drift, axis=2, keepdims=True)
        drift = drift * np.minimum(1.0, np.sqrt(step2) / np.maximum(norm, 1e-12))
        trial = z + drift + np.sqrt(step2) * rng.standard_normal(z.shape)
        inside = ((trial >= low) & (trial <= high)).all(axis=(1, 2))
        taken = inside & (plane.p_valid(trial, type) > confidence)
        z = np.where(taken[:, None, None], trial, z)
    return z
