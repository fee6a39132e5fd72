"""Specification models C_s(z_I, z_θ) → v̂: fitting, judging, sampling, repairing, identifying.

Nothing here loads torch until a network is fitted or sees a scene.
"""

from demospec.specification.audit._audit import Audit, AuditEntry, audit_set
from demospec.specification.evaluation._conformal import Conformal, conformal, predict_verdicts
from demospec.specification.evaluation._evaluate import Evaluation, Score, evaluate, wilson_interval
from demospec.specification.evaluation._explain import Explanation, explain
from demospec.specification.evaluation._identify import (
    Acceptances,
    Identification,
    Identified,
    acceptances,
    identify,
    type_posterior,
)
from demospec.specification.evaluation._predict import (
    Prediction,
    Predictions,
    predict,
    predict_batches,
)
from demospec.specification.evaluation._predict_parts import predict_parts
from demospec.specification.latent._control_plane import ControlPlane, plane_bounds
from demospec.specification.latent._repair import Repairs, RepairSettings, repair
from demospec.specification.latent._repair_set import Repaired, RepairedSet, repair_set
from demospec.specification.latent._sample import Samples, sample_valid
from demospec.specification.latent._scenes import (
    Reconstruction,
    reconstruct_scenes,
    set_of_sampled_scenes,
)
from demospec.specification.latent._scenes import set_of_sampled_scenes as sample_set
from demospec.specification.latent._validity_map import (
    Overlap,
    ValidityMap,
    overlap_of_types,
    validity_map,
)
from demospec.specification.models._ensemble import EnsembleModel, EnsembleView, UncertainView
from demospec.specification.models._ensemble_fit import fit_ensemble
from demospec.specification.models._maxent_irl import IrlModel, IrlSettings
from demospec.specification.models._registry import fit_model, load_model
from demospec.specification.models._single import FittedModel
from demospec.specification.models.beta_vae._model import PaperModel, PaperSettings
from demospec.specification.models.beta_vae._stacked import (
    StackedJob,
    check_device,
    stack_size,
    train_stacked,
)
from demospec.specification.models.beta_vae._training_data import training_data
from demospec.specification.models.perceived_rule._view import PerceivedObject

__all__ = [
    "Acceptances",
    "Audit",
    "AuditEntry",
    "Conformal",
    "ControlPlane",
    "EnsembleModel",
    "EnsembleView",
    "Evaluation",
    "Explanation",
    "FittedModel",
    "Identification",
    "Identified",
    "IrlModel",
    "IrlSettings",
    "Overlap",
    "PaperModel",
    "PaperSettings",
    "PerceivedObject",
    "Prediction",
    "Predictions",
    "Reconstruction",
    "RepairSettings",
    "Repaired",
    "RepairedSet",
    "Repairs",
    "Samples",
    "Score",
    "StackedJob",
    "UncertainView",
    "ValidityMap",
    "acceptances",
    "audit_set",
    "check_device",
    "conformal",
    "evaluate",
    "explain",
    "fit_ensemble",
    "fit_model",
    "identify",
    "load_model",
    "overlap_of_types",
    "plane_bounds",
    "predict",
    "predict_batches",
    "predict_parts",
    "predict_verdicts",
    "reconstruct_scenes",
    "repair",
    "repair_set",
    "sample_set",
    "sample_valid",
    "set_of_sampled_scenes",
    "stack_size",
    "train_stacked",
    "training_data",
    "type_posterior",
    "validity_map",
    "wilson_interval",
]
