"""Ensemble: several models of one kind, fitted alike but for chance; their spread.

The ensemble's logit is the mean of its members' logits, so that it does not saturate, has the
mean of their gradients, and p > ½ exactly where it is > 0; p(valid) is the logistic function of
it (the members' odds, averaged geometrically). Beside it stands how far the members' own
probabilities spread. The spread tells what chance left open in *fitting*; it does not know what
all members get wrong together, and is no error rate: `conformal` gives one.

Not in the paper. Source: Lakshminarayanan et al. 2017, deep ensembles (members from other first
weights); Breiman 1996, bagging (members from resampled data).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np

from demospec.demonstrations import DifferentiableView, Paths, View
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Scene
from demospec.specification.latent._control_plane import ControlView
from demospec.specification.models._ensemble_folder import read_members, write_members
from demospec.specification.models._folder import ModelFolder, read_model_folder
from demospec.specification.models._single import FittedModel, single_of
from demospec.specification.models._stored_model import LogisticView, logistic


@runtime_checkable
class UncertainView(Protocol):
    """A view that says how unsure it is of its own fit."""

    def p_valid_sd(self, paths: Paths, type: str) -> FloatArray: ...


class EnsembleModel:
    """At least two fitted models with the same types; a `ValidityModel`.

    Args:
        members: Of one kind.
        provenance: Of the set that all were fitted to; members keep their own.
    """

    kind: Final = "ensemble"

    def __init__(self, members: Sequence[FittedModel], provenance: dict[str, Any]) -> None:
        if len(members) < 2 or any(m.types != members[0].types for m in members):
            raise InputError(
                "two or more members of the same types",
                [list(m.types) for m in members], field="members",
            )  # fmt: skip
        self.members = tuple(members)
        self.provenance = provenance

    @property
    def types(self) -> tuple[str, ...]:
        """The user types it knows."""
        return self.members[0].types

    def see(self, scene: Scene) -> EnsembleView:
        """Every member looks at the scene once; CannotJudgeError where it lacks what they need."""
        views = [member.see(scene) for member in self.members]
        orders = {view.order for view in views if isinstance(view, ControlView)}
        if len(orders) == 1 and all(isinstance(view, ControlView) for view in views):
            return ControlEnsembleView(views)
        if all(isinstance(view, DifferentiableView) for view in views):
            return SlopedEnsembleView(views)
        return EnsembleView(views)

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Path:
        """Writes all members into one model folder."""
        return write_members(
            folder, self.members, kind=self.kind, types=self.types,
            provenance=self.provenance, replace=replace,
        )  # fmt: skip

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> EnsembleModel:
        """Reads what `save` wrote; InputError names what is wrong with it."""
        return cls.of(read_model_folder(folder))

    @classmethod
    def of(cls, stored: ModelFolder) -> EnsembleModel:
        """The ensemble of a folder that was read."""
        members = [single_of(one) for one in read_members(stored)]
        provenance = {k: v for k, v in stored.provenance.items() if k != "members"}
        return cls(members, provenance)


class EnsembleView(LogisticView):
    """What the members of an ensemble see of one scene.

    Args:
        views: One a member.
    """

    def __init__(self, views: Sequence[Any]) -> None:
        self.views = tuple(views)

    @property
    def scene(self) -> Scene:
        """The scene that they observed."""
        found: View = self.views[0]
        return found.scene

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) mean of the members' logits."""
        return np.asarray(self.member_logits(paths, type).mean(axis=0))

    def p_valid_sd(self, paths: Paths, type: str) -> FloatArray:
        """(n,) standard deviation of the members' p(valid), 0 to 0.71 (two members: 0 and 1)."""
        return np.asarray(logistic(self.member_logits(paths, type)).std(axis=0, ddof=1))

    def member_logits(self, paths: Paths, type: str) -> FloatArray:
        """(K, n) logits of each member."""
        return np.stack([view.logits(paths, type) for view in self.views])


class SlopedEnsembleView(EnsembleView):
    """The same where every member has a gradient along the path; a `DifferentiableView`."""

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        """(n, m, 2) paths → logits (n,) and ∂logit/∂paths (n, m, 2)."""
        return _means([view.logits_and_gradients(paths, type) for view in self.views])


class ControlEnsembleView(SlopedEnsembleView):
    """The same where every member judges z_θ of one order itself; a `ControlView`."""

    @property
    def order(self) -> int:
        """Order of the Bézier curves they think in."""
        return int(self.views[0].order)

    def control_logits(self, controls: FloatArray, type: str) -> FloatArray:
        """Logits (n,) of control points (n, order − 1, 2), pixels."""
        every = [view.control_logits(controls, type) for view in self.views]
        return np.asarray(np.mean(every, axis=0))

    def control_logits_and_gradients(
        self, controls: FloatArray, type: str
    ) -> tuple[FloatArray, FloatArray]:
        """Logits (n,) and ∂logit/∂control (n, order − 1, 2), 1/pixels."""
        return _means([view.control_logits_and_gradients(controls, type) for view in self.views])


def _means(answers: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    logits, slopes = zip(*answers, strict=True)
    return np.asarray(np.mean(logits, axis=0)), np.asarray(np.mean(slopes, axis=0))
