"""The one protocol that models, rules and truth share: scenes and paths in, validity out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from demospec.frames import FloatArray
from demospec.scene import Scene

Paths = Sequence[FloatArray] | FloatArray
"""Paths to judge: a stacked array (n, m, 2), or n arrays (m_i, 2); pixels."""


@runtime_checkable
class View(Protocol):
    """A model that has looked at one scene once and judges any number of paths in it."""

    @property
    def scene(self) -> Scene: ...

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) scores; > 0 where the model says valid. Unbounded, does not saturate."""
        ...

    def p_valid(self, paths: Paths, type: str) -> FloatArray:
        """(n,) probabilities of validity in [0, 1]; > 0.5 exactly where the logit is > 0.

        The paper's p(v | z_I, z_θ, s).
        """
        ...


@runtime_checkable
class DifferentiableView(View, Protocol):
    """A view whose logit has gradients along the path: what repair and sampling need."""

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        """(n, m, 2) paths → logits (n,) and ∂logit/∂paths (n, m, 2).

        With `bezier_basis` a gradient along the path becomes one in z_θ.
        """
        ...


Verdict = Literal["accept", "reject", "unknown"]
"""What is said of a path; ``unknown`` where nothing that was shown decides."""


@runtime_checkable
class JudgingView(View, Protocol):
    """A view that knows where nothing decides."""

    def verdicts(self, paths: Paths, type: str) -> list[Verdict]:
        """One verdict a path."""
        ...


@runtime_checkable
class ValidityModel(Protocol):
    """C_s(z_I, z_θ) → v̂, whoever computes it: a network, a learned rule, the truth."""

    @property
    def types(self) -> tuple[str, ...]:
        """The user types it knows."""
        ...

    def see(self, scene: Scene) -> View:
        """Look at a scene once.

        Raises:
            CannotJudgeError: The scene lacks what this model needs.
        """
        ...


def p_valid_mean(view: View, paths: Paths, type: str) -> float:
    """Mean probability of validity over paths: the paper's E[p(v)] for one scene."""
    return float(np.mean(view.p_valid(paths, type)))
