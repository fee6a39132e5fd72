"""Models of one kind each: fitting a field, paper or irl model, and reading one from its folder."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from demospec.demonstrations import DemonstrationSet, View
from demospec.errors import InputError
from demospec.progress import Progress, silent
from demospec.scene import Scene
from demospec.specification.models._folder import ModelFolder

if TYPE_CHECKING:
    from demospec.specification.models.beta_vae._model import PaperSettings

MODEL_KINDS = ("field", "paper", "irl")


class FittedModel(Protocol):
    """A `ValidityModel` that came from demonstrations, or a rule: it can be saved."""

    @property
    def types(self) -> tuple[str, ...]: ...

    def see(self, scene: Scene) -> View: ...

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Path: ...


def fit_single(
    data: DemonstrationSet,
    model: str,
    *,
    seed: int,
    progress: Progress = silent,
    settings: dict[str, Any],
) -> FittedModel:
    """One model of a kind of `MODEL_KINDS`; arguments as of `fit_model`."""
    if model not in MODEL_KINDS:
        raise InputError(", ".join(MODEL_KINDS), model, field="model")
    if model == "field":
        from demospec.specification.models.perceived_rule._model import FieldModel

        return FieldModel.fit(data, seed=seed, progress=progress, **settings)
    if model == "paper":
        from demospec.specification.models.beta_vae._model import PaperModel

        return PaperModel.fit(data, seed=seed, progress=progress, settings=paper_settings(settings))
    from demospec.specification.models._maxent_irl import IrlModel, IrlSettings

    return IrlModel.fit(
        data, seed=seed, progress=progress, settings=_checked(IrlSettings, settings)
    )


def single_of(stored: ModelFolder) -> FittedModel:
    """The model of a folder that was read; InputError where its kind is none of `MODEL_KINDS`."""
    if stored.kind == "paper":
        from demospec.specification.models.beta_vae._model import PaperModel

        return PaperModel.of(stored)
    if stored.kind == "irl":
        from demospec.specification.models._maxent_irl import IrlModel

        return IrlModel.of(stored)
    if stored.kind == "field":
        from demospec.specification.models.perceived_rule._model import FieldModel

        return FieldModel.of(stored)
    file = None if stored.path is None else stored.path / "config.json"
    raise InputError(", ".join((*MODEL_KINDS, "ensemble")), stored.kind, file=file, field="kind")


def paper_settings(settings: dict[str, Any]) -> PaperSettings:
    """`PaperSettings` by name; InputError lists the names where one is unknown."""
    from demospec.specification.models.beta_vae._model import PaperSettings

    chosen: PaperSettings = _checked(PaperSettings, settings)
    return chosen


def _checked(kind: Callable[..., Any], settings: dict[str, Any]) -> Any:
    known = [f.name for f in fields(kind)]  # type: ignore[arg-type]
    for name in settings:
        if name not in known:
            raise InputError(f"a setting ({', '.join(known)})", name, field="settings")
    return kind(**settings)
