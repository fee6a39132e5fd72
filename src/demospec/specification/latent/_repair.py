"""Repair: the least change of z_θ that makes a rejected path valid.

Source: Angelov et al. 2020, "Trajectory repair": gradient steps on z_θ, 30 of them.
Differs: the gradient is that of the *logit* (that of the probability vanishes far from the
boundary) and is normalised, so that a step has a length in the plane. `particles` > 1 is ours:
several particles look for a nearer valid point, the nearest that holds is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.demonstrations import View
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.specification.latent._control_plane import ControlPlane, plane_bounds

MAX_PARTICLES = 32
STEPS = 30
_GOLDEN = np.pi * (3.0 - 5.0**0.5)
_PLASTIC = np.array([0.7548776662466927, 0.5698402909980532])
_HAIR = 5e-4
"""Share of the scene's size by which a repair exceeds the clearance of a certain rule."""

_BEYOND = 1e-3
"""Aim a hair beyond the goal: landing exactly on it fails by rounding half of the time. (For a
certain rule a fiftieth of `_HAIR`.)"""


_SAME = 1e-6  # of the distance moved: repairs that differ less are equally good


@dataclass(frozen=True)
class RepairSettings:
    """How far and how carefully to look.

    Args:
        particles: 1 is the paper's single gradient ascent; at most 32.
        steps: Gradient steps (paper: 30).
        step: Length of the first step, as a share of the plane's longer side; later ones get
            shorter. (The paper states no length.)
        confidence: A repair holds where p(valid) is at least this; > 0.5 keeps a distance
            from the model's own boundary, which is not exactly the true one. The nearest
            boundary is where a model is likeliest to be wrong: p there promises too much.
    """

    particles: int = 16
    steps: int = STEPS
    step: float = 0.08
    confidence: float = 0.999

    def __post_init__(self) -> None:
        if not 1 <= self.particles <= MAX_PARTICLES:
            raise InputError(f"1 to {MAX_PARTICLES} particles", self.particles, field="particles")
        if self.steps < 1:
            raise InputError("at least 1 step", self.steps, field="steps")
        if not 0 < self.step <= 1:
            raise InputError("a share in (0, 1]", self.step, field="step")
        if not 0.5 <= self.confidence < 1:
            raise InputError("a probability in [0.5, 1)", self.confidence, field="confidence")


@dataclass(frozen=True)
class Repairs:
    """Repaired curves of one scene and type.

    Args:
        control: (n, order − 1, 2), pixels.
        points: (n, 100, 2), pixels.
        moved: (n,) distance from the first to the last z_θ, pixels.
        steps: (n,) steps until the kept point was reached.
        p_valid: (n,) the model's own opinion of it.
        holds: (n,) p_valid reaches the asked confidence.
        trace: n arrays (steps_i + 1, order − 1, 2): z_θ from the rejected to the repaired curve.
    """

    control: FloatArray
    points: FloatArray
    moved: FloatArray
    steps: NDArray[np.int64]
    p_valid: FloatArray
    holds: NDArray[np.bool_]
    trace: list[FloatArray] = field(repr=False)


def repair(
    view: View,
    controls: ArrayLike,
    type: str,
    *,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    known_invalid: ArrayLike | None = None,
    settings: RepairSettings | None = None,
) -> Repairs:
    """Moves rejected curves until the model accepts them, as little as it finds.

    Args:
        view: A model that has seen the scene.
        controls: z_θ of the rejected curves, (n, order − 1, 2) or (n, 2), pixels.
        type: User type who is to accept.
        start, goal: Ends, (2,) or one a curve (n, 2); the scene's by default.
        known_invalid: (n,) curves that somebody rejected. Where the model accepts such a curve
            it is too lenient there, and the repair must exceed its logit by that much.
        settings: Particles, steps, confidence.

    Returns:
        The repairs; judge them by the rule that made the labels, not by `p_valid`.
    """
    settings = settings or RepairSettings()
    z0 = np.array(controls, dtype=np.float64)
    if z0.ndim == 2:
        z0 = z0[:, None, :]
    plane = ControlPlane(view, order=z0.shape[1] + 1, start=start, goal=goal)
    low_x, low_y, high_x, high_y = plane_bounds(view.scene)
    side = max(high_x - low_x, high_y - low_y)
    logits, p = plane.logits_and_p(z0, type)
    certain = bool(np.isin(p, (0.0, 1.0)).all())
    hair = _HAIR * view.scene.length_scale
    odds = settings.confidence / (1 - settings.confidence)
    goal_logit = np.full(len(z0), hair if certain else float(np.log(odds)))
    if known_invalid is not None:
        goal_logit += np.where(np.asarray(known_invalid, dtype=bool), np.maximum(logits, 0.0), 0.0)
    beyond = hair / 50 if certain else _BEYOND
    search = _Search(plane, type, z0, goal_logit, beyond, settings, side)
    if settings.particles == 1:
        search.ascend()
    else:
        search.approach(np.array([low_x, low_y]), np.array([high_x, high_y]))
    control, trace = search.kept()
    final = plane.p_valid(control, type)
    return Repairs(
        control=control,
        points=plane.paths(control),
        moved=np.asarray(np.linalg.norm((control - z0).reshape(len(z0), -1), axis=1)),
        steps=np.array([len(t) - 1 for t in trace], dtype=np.int64),
        p_valid=final,
        holds=search.reached() & (final > 0.5),
        trace=trace,
    )


class _Search:
    """Particles (n, K) that look for the nearest point with a logit of at least `goal`."""

    def __init__(
        self,
        plane: ControlPlane,
        type: str,
        z0: FloatArray,
        goal: FloatArray,
        beyond: float,
        settings: RepairSettings,
        side: float,
    ) -> None:
        self.type = type
        self.z0 = z0
        self.goal = goal
        self.beyond = beyond
        self.settings = settings
        self.side = side
        n = len(z0)
        self.plane = plane.rows(np.repeat(np.arange(n), settings.particles))
        self.history: list[FloatArray] = []  # (n, K, order − 1, 2) after every step
        self.values: list[FloatArray] = []  # (n, K) logits there

    def _look(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        n, particles = z.shape[:2]
        flat = z.reshape(n * particles, *z.shape[2:])
        logits, slopes = self.plane.logits_and_gradients(flat, self.type)
        self.history.append(z)
        self.values.append(logits.reshape(n, particles))
        return self.values[-1], slopes.reshape(z.shape)

    def ascend(self) -> None:
        """The paper's: one particle climbs the logit until it reaches the goal."""
        z = self.z0[:, None]
        moving = np.arange(len(z))
        logits = np.zeros((len(z), 1))
        for step in range(self.settings.steps + 1):
            # Who has arrived stays there and need not be judged again.
            found, slope = self.plane.rows(moving).logits_and_gradients(z[moving, 0], self.type)
            logits = logits.copy()
            logits[moving, 0] = found
            self.history.append(z)
            self.values.append(logits)
            climbs = found < self.goal[moving]
            moving, slope = moving[climbs], slope[climbs]
            if len(moving) == 0 or step == self.settings.steps:
                return
            z = z.copy()
            z[moving] += self._length(step) * _unit(slope[:, None])

    def approach(self, low: FloatArray, high: FloatArray) -> None:
        """Every particle first climbs to where the logit holds, then closes in on z_θ.

        A particle that does not hold steps to the nearest point where its linearised logit does;
        one that holds, to the point nearest to z_θ where the linearised logit still does. For a
        straight boundary that is the exact answer; steps are limited and get shorter, so that a
        curved one is followed. The nearest point that held at any step is kept.
        """
        z = self._spread(low, high)
        centre = self.z0[:, None]
        for step in range(self.settings.steps):
            logits, slope = self._look(z)
            climbs = (logits < self.goal[:, None])[..., None, None]
            base = np.where(climbs, z, centre)
            norm2 = (slope**2).sum(axis=(2, 3))
            ahead = logits + (slope * (base - z)).sum(axis=(2, 3))
            lack = np.maximum(0.0, self.goal[:, None] + self.beyond - ahead)
            gain = lack / np.where(norm2 > 1e-18, norm2, np.inf)
            wanted = base + gain[..., None, None] * slope - z
            distance = np.sqrt((wanted**2).sum(axis=(2, 3), keepdims=True))
            z = z + wanted * np.minimum(1.0, self._length(step) / np.maximum(distance, 1e-12))
        self._look(z)

    def _length(self, step: int) -> float:
        share = 1.0 - 0.9 * step / self.settings.steps
        return self.settings.step * self.side * share

    def _spread(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """(n, K, order − 1, 2): z_θ, a quarter of the particles around it, the rest all over."""
        total = self.settings.particles
        near = min(total, max(2, total // 4))
        k = np.arange(near)
        radius = 0.25 * (high - low).max() * k / near
        around = radius[:, None] * np.stack([np.cos(k * _GOLDEN), np.sin(k * _GOLDEN)], axis=1)
        # Additive recurrence with the plastic number: even cover of the plane for any count.
        share = (np.arange(total - near)[:, None] + 0.5) * _PLASTIC % 1.0
        mean = self.z0.mean(axis=1)
        shift = np.concatenate(
            [
                np.broadcast_to(around, (len(mean), near, 2)),
                low + (high - low) * share - mean[:, None],
            ],
            axis=1,
        )
        # A curve of higher order moves as a whole: its control points keep their arrangement.
        return np.asarray(self.z0[:, None] + shift[:, :, None])

    def _best(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(step, particle) of the nearest point that holds, else of the highest logit."""
        values = np.stack(self.values)  # (S, n, K)
        moved = np.stack(
            [np.sqrt(((z - self.z0[:, None]) ** 2).sum(axis=(2, 3))) for z in self.history]
        )
        holds = values >= self.goal[None, :, None]
        # Nearest where some hold; else highest logit. The first of those that are as good but for
        # rounding: particles meet, and their last steps go nowhere.
        some = np.asarray(holds.any(axis=(0, 2)))[:, None]
        cost = np.where(some, np.where(holds, moved, np.inf), -values)
        cost = cost.transpose(1, 0, 2).reshape(values.shape[1], -1)
        least = cost.min(axis=1, keepdims=True)
        flat = (cost <= least + _SAME * np.abs(least)).argmax(axis=1)
        return np.asarray(flat // values.shape[2]), np.asarray(flat % values.shape[2])

    def reached(self) -> NDArray[np.bool_]:
        """(n,) the kept point's logit reaches the goal."""
        step, particle = self._best()
        rows = np.arange(len(self.z0))
        return np.asarray(np.stack(self.values)[step, rows, particle] >= self.goal)

    def kept(self) -> tuple[FloatArray, list[FloatArray]]:
        """The kept points, and the way of their particles to them, first point z_θ."""
        step, particle = self._best()
        every = np.stack(self.history)
        control = np.stack(
            [every[s, i, k] for i, (s, k) in enumerate(zip(step, particle, strict=True))]
        )
        trace = []
        for i, (s, k) in enumerate(zip(step, particle, strict=True)):
            way = every[: s + 1, i, k]
            trace.append(way if k == 0 else np.concatenate([self.z0[i][None], way]))
        return control, trace


def _unit(slope: FloatArray) -> FloatArray:
    norm = np.sqrt((slope**2).sum(axis=(2, 3), keepdims=True))
    return np.asarray(slope / np.where(norm > 1e-12, norm, 1.0))
