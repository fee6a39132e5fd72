"""Specification models C_s(z_I, z_θ) → v̂: fitting, judging, sampling, repairing, identifying.

Nothing here loads torch until a network is fitted or sees a scene.
"""

from demospec.specification._audit import Audit, AuditEntry, audit_set
from demospec.specification._evaluate import Evaluation, Score, evaluate
from demospec.specification._models import FittedModel, fit_model, load_model
from demospec.specification._paper import PaperModel, PaperSettings
from demospec.specification._predict import Prediction, Predictions, predict
from demospec.specification._repair import Repairs, RepairSettings, repair

__all__ = [
    "Audit",
    "AuditEntry",
    "Evaluation",
    "FittedModel",
    "PaperModel",
    "PaperSettings",
    "Prediction",
    "Predictions",
    "RepairSettings",
    "Repairs",
    "Score",
    "audit_set",
    "evaluate",
    "fit_model",
    "load_model",
    "predict",
    "repair",
]
