"""Making and reading specification models of every kind."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.progress import Progress, silent
from demospec.specification.models._ensemble import EnsembleModel
from demospec.specification.models._ensemble_fit import fit_ensemble
from demospec.specification.models._folder import ModelFolder, read_model_folder
from demospec.specification.models._single import MODEL_KINDS, FittedModel, fit_single, single_of


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
    if members == 1:
        return fit_single(data, model, seed=seed, progress=progress, settings=settings)
    if model not in MODEL_KINDS:
        raise InputError(", ".join(MODEL_KINDS), model, field="model")
    return fit_ensemble(data, model, members=members, seed=seed, progress=progress, **settings)


def load_model(
    path: str | os.PathLike[str],
    types: Sequence[str] = (),
    data: DemonstrationSet | None = None,
) -> Any:
    """A model folder, or a rule file (a JSON answer of `rules`, or hand-written), as a model.

    Args:
        path: File or folder.
        types: User types of the set that is to be judged. A rule file with rules for `anyone`
            alone judges each of them (`RuleSet.for_types`); other models know their own types.
        data: The set that is to be judged; rules are brought to its unit and scale.

    Returns:
        A `ValidityModel`.

    Raises:
        InputError: Neither of both, or damaged.
        MissingExtraError: torch is absent and the model needs it.
    """
    place = Path(path)
    if place.is_file():
        from demospec.rules import read_rules, rules_for_set

        rules = read_rules(place).for_types(types)
        if data is None:
            return rules
        try:
            return rules_for_set(rules, data)
        except InputError as error:
            raise error.at(file=place) from error
    if not place.is_dir():
        raise InputError("a model folder or a rule file", "no such file or folder", file=place)
    if not (place / "config.json").is_file():
        raise InputError("a model folder (with config.json)", "another folder", file=place)
    return model_of(read_model_folder(place))


def model_of(stored: ModelFolder) -> Any:
    """The model of a folder that was read; a `ValidityModel`."""
    return EnsembleModel.of(stored) if stored.kind == "ensemble" else single_of(stored)
