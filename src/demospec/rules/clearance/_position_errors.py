"""Acceptance that rises over a width: a soft person, or distances measured with error.

Errors of distance are first taken for independent, and so look like a soft person. Where they are
then likely enough to matter, they are taken for what they are: an object's position is wrong,
for all demonstrations past it alike (`_offsets`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from demospec.frames import FloatArray
from demospec.rules.clearance._answers import Answers
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._likelihood import (
    POSITION,
    ClearancePrior,
    Noise,
    Particles,
    log_sum,
)
from demospec.rules.clearance._model_selection import nearest_of
from demospec.rules.clearance._offsets import DRAWS, offset_labels
from demospec.rules.clearance._version_space import BoolArray

NOTICED = 0.05
"""Posterior probability of errors from which their kind is looked into."""

_RIVALS = 9.0
"""Sets of classes less likely than the best by more than this (log odds) are left as they are."""

_REACH = 10.0  # hundredths of the table about the likeliest clearance
_CELLS = 80
_PIECES = 4
_COARSE = 4  # cells taken together at first
_FEW = 20
"""Fewer demonstrations leave the clearance open: a rough look would be made for nothing."""

_FAINT_SIZE = 0.002
_FAINT_CELL = 1e-3
"""Shares of the weight below which a size of error, or a cell (of the largest), is not looked at
more closely."""


@dataclass(frozen=True)
class Model:
    """Part of the posterior: a set of classes, with one clearance or one each.

    Args:
        member: (K,) classes that matter.
        particles: Weighed by their likelihood and the prior of what differs between them.
        log_prior: Of the model.
        shared: Whether the classes share one clearance.
    """

    member: BoolArray
    particles: Particles
    log_prior: float
    shared: bool = True

    @property
    def weighed(self) -> Particles:
        return self.particles.scaled(self.log_prior)


@dataclass(frozen=True)
class Errors:
    """What the models with distance errors have in common.

    Args:
        prior: Of a clearance.
        noises: Sizes of error to weigh.
        start: The likeliest clearance without error.
        unit: A hundredth of the table.
    """

    prior: ClearancePrior
    noises: tuple[Noise, ...]
    start: float
    unit: float

    def independent(self, member: BoolArray, near: FloatArray, answers: Answers) -> Particles:
        """One clearance for some classes; every answer has an error of its own.

        Args:
            near: (N,) nearest approach to any of the classes.
        """

        def labels(clearance: FloatArray, noise: Noise) -> list[FloatArray]:
            gap = near[None, :] - clearance[:, None]
            return answers.log_likelihood(gap, noise.sigma, noise.rates)

        return self._grid(member, labels, self.noises)

    def of_objects(
        self,
        models: Sequence[Model],
        nearest: FloatArray,
        answers: Answers,
        passes: Callable[[], Passes],
    ) -> list[Model]:
        """The same models, with independent errors of position replaced by those of the objects.

        Models with one clearance each are weighed by what the replacement does to those of the
        same classes with one for all: the sum over errors is only made for the latter.
        """
        valid = answers.valid
        if valid.all():  # nothing is known to matter, wherever the objects stand
            return list(models)
        everything = Particles.joined([model.weighed for model in models])
        most = log_sum(everything.log_weight)
        off = everything.kind == POSITION
        if log_sum(everything.log_weight[off]) - most < np.log(NOTICED):
            return list(models)
        out = []
        seen = passes()
        grids: dict[bytes, tuple[Particles, Particles]] = {}
        for model in models:
            part, member = model.particles, model.member
            likely = log_sum(part.log_weight) + model.log_prior > most - _RIVALS
            mine = part.kind == POSITION
            if not likely or not mine.any():
                out.append(model)
                continue
            if member.tobytes() not in grids:
                near = nearest_of(member[None], nearest)[0]
                before = self.independent(member, near, answers)
                grids[member.tobytes()] = before, self._by_objects(member, valid, seen)
            before, after = grids[member.tobytes()]
            if model.shared:
                after = Particles.joined([part.rows(~mine), after])
            else:
                weight = part.log_weight.copy()
                for size in (noise.sigma for noise in self._of_position):
                    change = _mass(after, size) - _mass(before, size)
                    weight[mine & (part.sigma == size)] += change
                after = part.weighed(weight)
            out.append(replace(model, particles=after))
        return out

    def _by_objects(self, member: BoolArray, valid: BoolArray, passes: Passes) -> Particles:
        """One clearance for some classes; every object's position has an error.

        First roughly; then, for the sizes of error that are likely, cell by cell where the
        clearance may lie: the fewer cells, the more errors are drawn for each.
        """

        def labels(clearance: FloatArray, noise: Noise, count: int = DRAWS) -> list[FloatArray]:
            return offset_labels(passes, valid, member, clearance, noise.sigma, noise.rates, count)

        noises = self._of_position
        if not member.any() or len(valid) < _FEW:
            return self._grid(member, labels, noises)
        edges = self._edges()
        parts = [self._on(member, edges[::_COARSE], labels, noise) for noise in noises]
        most = log_sum(np.concatenate([part.log_weight for part in parts]))
        for i, noise in enumerate(noises):
            rough = parts[i].log_weight
            if log_sum(rough) < most + np.log(_FAINT_SIZE):
                continue
            likely = np.flatnonzero(rough > rough.max() + np.log(_FAINT_CELL)) // _PIECES
            low = _COARSE * max(int(likely[0]) - 1, 0)
            fine = edges[low : _COARSE * (int(likely[-1]) + 2) + 1]
            draws = DRAWS * max(_CELLS // (len(fine) - 1), 1)
            parts[i] = self._on(member, fine, partial(labels, count=draws), noise)
        return Particles.joined(parts)

    @property
    def _of_position(self) -> tuple[Noise, ...]:
        """The sizes of error that lists of objects may have."""
        return tuple(
            replace(noise, priors={POSITION: noise.priors[POSITION]})
            for noise in self.noises
            if POSITION in noise.priors
        )

    def _grid(self, member: BoolArray, labels: Labels, noises: Sequence[Noise]) -> Particles:
        """One shared clearance: a grid about the likeliest."""
        edges = self._edges()
        return Particles.joined([self._on(member, edges, labels, noise) for noise in noises])

    def _edges(self) -> FloatArray:
        """Of the grid's cells."""
        low = max(self.prior.floor, self.start - _REACH * self.unit)
        high = min(self.prior.reach, self.start + _REACH * self.unit)
        return np.linspace(low, max(high, low + 1e-9 * self.unit), _CELLS + 1)

    def _on(self, member: BoolArray, edges: FloatArray, labels: Labels, noise: Noise) -> Particles:
        """Cells of the shared clearance, with one size of error."""
        if member.any():
            middle = (edges[1:] + edges[:-1]) / 2
            log_width = np.log(np.diff(self.prior.share(edges)) + 1e-300)
        else:
            middle, log_width = np.array([self.prior.floor]), np.zeros(1)
        cases = zip(labels(middle, noise), noise.log_rates, strict=True)
        log_p = np.logaddexp.reduce([weight + case for weight, case in cases])
        if len(middle) > 1:  # every cell in pieces: a clearance lies anywhere in its cell
            pieces = edges[0] + (np.arange(_PIECES * len(middle)) + 0.5) * (
                (edges[-1] - edges[0]) / (_PIECES * len(middle))
            )
            log_p = np.interp(pieces, middle, log_p) - np.log(_PIECES)
            middle, log_width = pieces, np.repeat(log_width, _PIECES)
        clearance = np.where(member, middle[:, None], -np.inf)
        return Particles.joined(
            [
                Particles.of(log_p + log_width + prior, clearance, noise.sigma, kind)
                for kind, prior in noise.priors.items()
            ]
        )


Labels = Callable[[FloatArray, Noise], list[FloatArray]]
"""(m,) ascending clearances shared by the classes that matter → for each rate of wrong labels
(m,) log P(labels)."""


def _mass(particles: Particles, sigma: float) -> float:
    """Log of the weight with one size of position error."""
    mine = (particles.sigma == sigma) & (particles.kind == POSITION)
    return log_sum(particles.log_weight[mine])
