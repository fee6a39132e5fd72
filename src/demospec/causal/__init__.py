"""Causal analysis on any `ValidityModel`: which objects matter to whom, with intervals.

Paired interventions on scenes (add, remove, move, swap, placebo) and on the type, sign-flip
tests with Holm's correction, a minimum effect, and words. No network classes in here.
"""

from demospec.causal._agreement import Agreement, Disagreement, agreement, rules_of_causes
from demospec.causal._boundary import (
    Boundary,
    BoundaryEffect,
    BoundaryShift,
    boundary_between,
    boundary_effects,
    boundary_shift,
)
from demospec.causal._causation import Causation, causation
from demospec.causal._checks import checked
from demospec.causal._counterfactual import (
    Counterfactual,
    RejectedPath,
    Without,
    but_for,
    but_for_rejected,
)
from demospec.causal._counterfactual import but_for as had_it_not_been_there
from demospec.causal._document import findings_from_document
from demospec.causal._dose import dose_responses
from demospec.causal._effect_map import EffectMap, effect_map
from demospec.causal._estimate import estimate
from demospec.causal._find import editor_for, find_causes, run_trials
from demospec.causal._find_in_set import trials_of_set, trials_of_stored
from demospec.causal._results import (
    CausalFindings,
    DosePoint,
    DoseResponse,
    Estimate,
    Placebo,
    Settings,
    SymbolEffect,
    TypeEffect,
)
from demospec.causal._statistics import EXACT_SCENES, holm, mean_interval, sign_flip_p, smallest_p
from demospec.causal._trials import Trial, TrialTable, to_arrow, write_trials

__all__ = [
    "EXACT_SCENES",
    "checked",
    "Agreement",
    "Boundary",
    "BoundaryEffect",
    "BoundaryShift",
    "Causation",
    "Counterfactual",
    "Disagreement",
    "DosePoint",
    "DoseResponse",
    "EffectMap",
    "RejectedPath",
    "Without",
    "agreement",
    "boundary_between",
    "boundary_effects",
    "boundary_shift",
    "but_for",
    "but_for_rejected",
    "causation",
    "dose_responses",
    "effect_map",
    "had_it_not_been_there",
    "CausalFindings",
    "Estimate",
    "Placebo",
    "Settings",
    "SymbolEffect",
    "Trial",
    "TrialTable",
    "TypeEffect",
    "editor_for",
    "estimate",
    "find_causes",
    "findings_from_document",
    "holm",
    "mean_interval",
    "rules_of_causes",
    "run_trials",
    "sign_flip_p",
    "smallest_p",
    "to_arrow",
    "trials_of_set",
    "trials_of_stored",
    "write_trials",
]
