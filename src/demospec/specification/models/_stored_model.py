"""Fitted networks: arrays in a folder, and views whose odds are logistic."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from demospec.demonstrations import Paths
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.specification.models._folder import (
    ModelFolder,
    ModelWeights,
    read_model_folder,
    write_model_folder,
)

S = TypeVar("S")
M = TypeVar("M", bound="StoredModel[Any]")


class StoredModel(ABC, Generic[S]):
    """A model that is its settings and its arrays.

    Args:
        types: User types, in the order of the weights.
        settings: How it was fitted; a dataclass of numbers and words.
        weights: Arrays by name.
        provenance: Versions, seed, data hash.
    """

    kind: ClassVar[str]

    def __init__(
        self,
        types: tuple[str, ...],
        settings: S,
        weights: ModelWeights,
        provenance: dict[str, Any],
    ) -> None:
        self.types = types
        self.settings = settings
        self.weights = weights
        self.provenance = provenance

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Path:
        """Writes the model as a folder."""
        return write_model_folder(
            folder,
            kind=self.kind,
            types=self.types,
            settings=asdict(self.settings),  # type: ignore[call-overload]  # a dataclass
            weights=self.weights,
            provenance=self.provenance,
            replace=replace,
        )

    @classmethod
    def load(cls: type[M], folder: str | os.PathLike[str]) -> M:
        """Reads what `save` wrote; InputError names what is wrong with it."""
        return cls.of(read_model_folder(folder))

    @classmethod
    @abstractmethod
    def of(cls: type[M], stored: ModelFolder) -> M:
        """The model of a folder that was read."""


def settings_of(kind: type[S], stored: ModelFolder) -> S:
    """The settings in a folder; keys that they do not know are left out.

    Raises:
        InputError: A value that the settings refuse.
    """
    known = {f.name for f in fields(kind)}  # type: ignore[arg-type]  # a dataclass
    try:
        return kind(**{k: v for k, v in stored.settings.items() if k in known})
    except InputError as error:
        file = None if stored.path is None else stored.path / "config.json"
        raise error.at(file=file) from error


class LogisticView(ABC):
    """A view whose p(valid) is the logistic function of its logit."""

    @abstractmethod
    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) log-odds of validity; unbounded."""

    def p_valid(self, paths: Paths, type: str) -> FloatArray:
        """(n,) in [0, 1]; > 0.5 exactly where the logit is > 0."""
        return logistic(self.logits(paths, type))

    def p_of_logits(self, logits: FloatArray) -> FloatArray:
        """The logistic function: who has the logits need not judge again."""
        return logistic(logits)


def logistic(logits: FloatArray) -> FloatArray:
    """The logistic function, without overflow."""
    return np.asarray(0.5 * (1.0 + np.tanh(0.5 * logits)))
