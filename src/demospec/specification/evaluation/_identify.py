"""Identification: the type of an unknown demonstrator. Never reads the types.

Source: Angelov et al. 2020: argmax_s Σ log C_s(z_I, z_θ). Differs: that sum always elects the
type that accepts everything. A demonstrator who shows what they accept draws from
p(z_θ | s) = C_s(z_θ) / ∫ C_s, so each C_s is divided by its mean over the z_θ plane of the scene.
Where the demonstrator also rejected paths, the labels say it: the likelihood is then that of the
labels, Π C_s^v (1 − C_s)^(1 − v), in which paths need no normalisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, ValidityModel
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.specification.evaluation._predict import Views
from demospec.specification.latent._control_plane import ControlPlane, plane_bounds

ERROR_RATE = 0.02
"""Share of verdicts taken to be wrong for no reason: one contradiction must not decide alone."""

PLANE_SIDE = 15
"""Control points along a side of the grid over which C_s is averaged."""

SURPRISE = 1e-3
"""A demonstrator is "none of these" where the best type would produce such acceptances in less
than this share of cases, over all types compared."""


@dataclass(frozen=True)
class Identified:
    """What one demonstrator's demonstrations say about their type.

    Args:
        demonstrator: Name, or None for all demonstrations that name nobody.
        n: Demonstrations that could be judged.
        type: The most probable type; None where no type fits (`none_of_these`).
        posterior: Type → probability among the model's types, equal before.
        nearest: The most probable type, fit or not.
        surprise: How improbable the acceptances are under the nearest type, in [0, 1].
        none_of_these: `surprise` is below `SURPRISE`.
        cluster: Number of the group of alike demonstrators without a fitting type, else None.
    """

    demonstrator: str | None
    n: int
    type: str | None
    posterior: dict[str, float]
    nearest: str
    surprise: float
    none_of_these: bool
    cluster: int | None = None

    def to_json(self) -> dict[str, Any]:
        """One item of the document of ``demospec identify``."""
        return {
            "demonstrator": self.demonstrator,
            "n": self.n,
            "type": self.type,
            "posterior": self.posterior,
            "nearest": self.nearest,
            "surprise": self.surprise,
            "none_of_these": self.none_of_these,
            "cluster": self.cluster,
        }


@dataclass(frozen=True)
class Identification:
    """Types of the demonstrators of a set, and the scenes that could not be judged."""

    demonstrators: tuple[Identified, ...]
    unjudged: dict[str, str]

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec identify``."""
        return {"demonstrators": [d.to_json() for d in self.demonstrators]}


@dataclass(frozen=True)
class Acceptances:
    """What every type of a model says to some demonstrations.

    Args:
        types: The model's types, T of them.
        c: (n, T) C_s of each demonstration.
        mean: (n, T) mean of C_s over the z_θ plane of its scene.
        expected: (n, T, T) chance that type r accepts a path drawn from what type s accepts,
            at [s, r], in its scene.
        valid: (n,) 1, 0, or −1 where nobody said.
    """

    types: tuple[str, ...]
    c: FloatArray
    mean: FloatArray
    expected: FloatArray
    valid: NDArray[np.int8]

    def rows(self, chosen: NDArray[np.int64]) -> Acceptances:
        """The acceptances of some of the demonstrations."""
        return Acceptances(
            self.types, self.c[chosen], self.mean[chosen], self.expected[chosen], self.valid[chosen]
        )


def identify(
    model: ValidityModel,
    data: DemonstrationSet,
    *,
    progress: Progress = silent,
) -> Identification:
    """The most probable type of every demonstrator of a set.

    Raises:
        CannotJudgeError: No scene of the set can be judged.
    """
    found, judged, unjudged = acceptances(model, data, progress=progress)
    d = data.demonstrations
    names = list(dict.fromkeys(d.demonstrator[judged]))
    out = []
    profiles = []
    for name in names:
        mine = np.flatnonzero(np.array([d.demonstrator[i] == name for i in judged]))
        part = found.rows(mine)
        posterior = type_posterior(part)
        best = int(np.argmax(posterior))
        surprise = _surprise(part, best)
        strange = surprise < SURPRISE
        profiles.append((part.c > 0.5).mean(axis=0) - part.mean.mean(axis=0))
        out.append(
            Identified(
                demonstrator=name,
                n=len(mine),
                type=None if strange else found.types[best],
                posterior={t: float(p) for t, p in zip(found.types, posterior, strict=True)},
                nearest=found.types[best],
                surprise=surprise,
                none_of_these=strange,
            )
        )
    return Identification(tuple(_with_clusters(out, np.array(profiles))), unjudged)


def acceptances(
    model: ValidityModel, data: DemonstrationSet, *, progress: Progress = silent
) -> tuple[Acceptances, NDArray[np.int64], dict[str, str]]:
    """C_s of every judged demonstration, rows of these in the set, and unjudged scenes."""
    d = data.demonstrations
    types = tuple(model.types)
    rows_, c_, mean_, expected_ = [], [], [], []
    views = Views(model, data, progress)
    for _, rows, view in views:
        x0, y0, x1, y1 = plane_bounds(view.scene)
        grid = np.stack(
            np.meshgrid(np.linspace(x0, x1, PLANE_SIDE), np.linspace(y0, y1, PLANE_SIDE)), axis=-1
        ).reshape(-1, 1, 2)
        plane = ControlPlane(view, points=50)
        on_plane = np.stack([plane.p_valid(grid, t) for t in types])  # (T, G)
        paths = data.motions(rows)
        c_.append(np.stack([view.p_valid(paths, t) for t in types], axis=1))
        weight = on_plane + 1e-9
        expected = (weight @ (on_plane > 0.5).T) / weight.sum(axis=1, keepdims=True)
        mean_.append(np.tile(on_plane.mean(axis=1), (len(rows), 1)))
        expected_.append(np.tile(expected, (len(rows), 1, 1)))
        rows_.append(rows)
    views.refuse_if_none()
    judged = np.concatenate(rows_)
    order = np.argsort(judged)
    judged = judged[order]
    found = Acceptances(
        types=types,
        c=np.concatenate(c_)[order],
        mean=np.concatenate(mean_)[order],
        expected=np.concatenate(expected_)[order],
        valid=d.valid[judged],
    )
    return found, judged, views.unjudged


def type_posterior(found: Acceptances, error_rate: float = ERROR_RATE) -> FloatArray:
    """Posterior (T,) over the types, equal before, of one demonstrator's demonstrations."""
    score = log_likelihood(found, error_rate).sum(axis=0)
    weight = np.exp(score - score.max())
    return np.asarray(weight / weight.sum())


def log_likelihood(found: Acceptances, error_rate: float = ERROR_RATE) -> FloatArray:
    """(n, T) log-likelihood of each demonstration under each type, up to a constant."""
    c = error_rate + (1 - 2 * error_rate) * found.c
    if (found.valid == 0).any():
        said = found.valid[:, None]
        labelled = np.where(said == 1, np.log(c), np.log(1 - c))
        return np.asarray(np.where(said >= 0, labelled, 0.0))
    mean = error_rate + (1 - 2 * error_rate) * found.mean
    return np.asarray(np.log(c) - np.log(mean))


def _surprise(found: Acceptances, best: int) -> float:
    """Two-sided chance of the acceptances under type `best`, corrected for the types compared.

    For each type r: how many of the demonstrations r accepts, against how many it would accept
    of paths that `best` produces (normal approximation of the Poisson binomial, `ERROR_RATE`
    added).
    Only demonstrations that were not rejected by their demonstrator count.
    """
    from scipy.special import erfc

    shown = found.valid != 0
    if not shown.any():
        return 1.0
    accepted = (found.c[shown] > 0.5).sum(axis=0)
    chance = ERROR_RATE + (1 - 2 * ERROR_RATE) * found.expected[shown][:, best]  # (n, T)
    spread = np.sqrt((chance * (1 - chance)).sum(axis=0))
    # Half a count of continuity correction keeps small numbers from looking surprising.
    excess = np.maximum(0.0, np.abs(accepted - chance.sum(axis=0)) - 0.5) / spread
    worst = float(erfc(float(excess.max()) / sqrt(2)))
    return min(1.0, worst * len(found.types))


def _with_clusters(items: Sequence[Identified], profiles: FloatArray) -> list[Identified]:
    """Groups the demonstrators that no type fits by how the types take their paths."""
    from dataclasses import replace

    strange = [i for i, item in enumerate(items) if item.none_of_these]
    group = clusters(profiles[strange]) if strange else []
    out = list(items)
    for i, number in zip(strange, group, strict=True):
        out[i] = replace(out[i], cluster=int(number))
    return out


def clusters(profiles: FloatArray, apart: float = 0.25) -> list[int]:
    """Groups of alike demonstrators: average linkage, cut where groups differ by `apart`.

    Args:
        profiles: (n, T) acceptance rate of each type minus what it accepts of the plane.
        apart: Euclidean distance of group means beyond which groups stay separate.

    Returns:
        n numbers, 0 for the group of the first.
    """
    if len(profiles) == 1:
        return [0]
    from scipy.cluster.hierarchy import fcluster, linkage

    raw = fcluster(linkage(profiles, method="average"), t=apart, criterion="distance")
    first: dict[int, int] = {}
    return [first.setdefault(int(k), len(first)) for k in raw]
