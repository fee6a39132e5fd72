"""Specification models: β-VAE, maximum-entropy IRL, perceived rule, ensembles, folders."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.specification.models._ensemble import EnsembleModel
    from demospec.specification.models._ensemble_fit import fit_ensemble, resampled
    from demospec.specification.models._maxent_irl import IrlModel
    from demospec.specification.models._registry import fit_model, load_model
    from demospec.specification.models.beta_vae._model import PaperModel
    from demospec.specification.models.perceived_rule._model import FieldModel
    from demospec.specification.models.perceived_rule._rule import is_nested_in

__all__ = [
    "EnsembleModel",
    "FieldModel",
    "IrlModel",
    "PaperModel",
    "fit_ensemble",
    "fit_model",
    "is_nested_in",
    "load_model",
    "resampled",
]

_HOME = {
    "EnsembleModel": "_ensemble",
    "FieldModel": "perceived_rule._model",
    "IrlModel": "_maxent_irl",
    "PaperModel": "beta_vae._model",
    "fit_ensemble": "_ensemble_fit",
    "fit_model": "_registry",
    "is_nested_in": "perceived_rule._rule",
    "load_model": "_registry",
    "resampled": "_ensemble_fit",
}


__getattr__ = names_of(__name__, _HOME)
