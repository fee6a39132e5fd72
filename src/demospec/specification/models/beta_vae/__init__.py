"""The paper's β-VAE specification model, single and stacked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.specification.models.beta_vae._model import PaperModel, PaperSettings
    from demospec.specification.models.beta_vae._network import Network
    from demospec.specification.models.beta_vae._stacked import (
        StackedJob,
        bytes_of_member,
        stack_size,
        train_stacked,
        weights_of_member,
    )
    from demospec.specification.models.beta_vae._training_data import TrainingData, training_data

__all__ = [
    "Network",
    "PaperModel",
    "PaperSettings",
    "StackedJob",
    "TrainingData",
    "bytes_of_member",
    "stack_size",
    "train_stacked",
    "training_data",
    "weights_of_member",
]

_HOME = {
    "Network": "_network",
    "PaperModel": "_model",
    "PaperSettings": "_model",
    "StackedJob": "_stacked",
    "TrainingData": "_training_data",
    "bytes_of_member": "_stacked",
    "stack_size": "_stacked",
    "train_stacked": "_stacked",
    "training_data": "_training_data",
    "weights_of_member": "_stacked",
}


__getattr__ = names_of(__name__, _HOME)
