"""Making and reading specification models of every kind."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from demospec.demonstrations import DemonstrationSet, View
from demospec.errors import InputError
from demospec.progress import Progress, silent
from demospec.scene import Scene
from demospec.specification.models._folder import ModelFolder, read_model_folder

if TYPE_CHECKING:
    from demospec.specification.models.beta_vae._model import PaperSettings

KINDS = ("field", "paper", "irl")


class FittedModel(Protocol):
    """A `ValidityModel` that came from demonstrations, or a rule: it can be saved."""

    @property
    def types(self) -> tuple[str, ...]: ...

    def see(self, scene: Scene) -> View: ...

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Path: ...


def fit_model(
    data: DemonstrationSet,
    model: str = "field",
    *,
    members: int = 1,
    seed: int = 0,
    progress: Progress = silent,
    **settings: Any,
) -> FittedModel:
    """Fits a specification model to the labelled demonstrations of a set.

    Args:
        data: Every scene is used; choose one split with `DemonstrationSet.of_split`.
        model: ``field`` (ours), ``paper`` or ``irl``.
        members: Of an ensemble (`EnsembleModel`); 1: the plain model.
        seed: Same seed, same weights.
        progress: Told the steps.
        settings: Of `FieldSettings`, `PaperSettings` or `IrlSettings`, by name.

    Raises:
        InputError: Unknown model or setting, no labelled demonstrations, no pictures.
        MissingExtraError: torch is absent.
    """
    if model not in KINDS:
        raise InputError(", ".join(KINDS), model, field="model")
    if members != 1:
        from demospec.specification.models._ensemble_fit import fit_ensemble

        return fit_ensemble(data, model, members=members, seed=seed, progress=progress, **settings)
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


def load_model(path: str | os.PathLike[str], types: Sequence[str] = ()) -> Any:
    """A model folder, or a rule file (a JSON answer of `rules`, or hand-written), as a model.

    Args:
        path: File or folder.
        types: User types of the set that is to be judged. A rule file with rules for `anyone`
            alone judges each of them (`RuleSet.for_types`); other models know their own types.

    Returns:
        A `ValidityModel`.

    Raises:
        InputError: Neither of both, or damaged.
        MissingExtraError: torch is absent and the model needs it.
    """
    place = Path(path)
    if place.is_file():
        from demospec.rules import read_rules

        return read_rules(place).for_types(types)
    if not place.is_dir():
        raise InputError("a model folder or a rule file", "no such file or folder", file=place)
    if not (place / "config.json").is_file():
        raise InputError("a model folder (with config.json)", "another folder", file=place)
    return model_of(read_model_folder(place))


def model_of(stored: ModelFolder) -> Any:
    """The model of a folder that was read; a `ValidityModel`."""
    if stored.kind == "paper":
        from demospec.specification.models.beta_vae._model import PaperModel

        return PaperModel.of(stored)
    if stored.kind == "irl":
        from demospec.specification.models._maxent_irl import IrlModel

        return IrlModel.of(stored)
    if stored.kind == "field":
        from demospec.specification.models.perceived_rule._model import FieldModel

        return FieldModel.of(stored)
    if stored.kind == "ensemble":
        from demospec.specification.models._ensemble import EnsembleModel

        return EnsembleModel.of(stored)
    file = None if stored.path is None else stored.path / "config.json"
    raise InputError(", ".join((*KINDS, "ensemble")), stored.kind, file=file, field="kind")
