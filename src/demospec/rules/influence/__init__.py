"""The influence family (the paper's): T_min, T_object and F_max; problems, rules and answers.

Names load their module on first use. Those that users need stand in `demospec.rules`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.rules.influence._check import WrongAnswerError, check_answer, contradicted
    from demospec.rules.influence._effort import ENUMERATED, Effort
    from demospec.rules.influence._label_noise import LABEL_NOISE, slack_of
    from demospec.rules.influence._of_set import influence_answer
    from demospec.rules.influence._quantum import Quantum
    from demospec.rules.influence._rule import scaled_answer
    from demospec.rules.influence._sentences import influence_words
    from demospec.rules.influence._solve import CpSatEngine, ExactEngine, InfluenceEngine
    from demospec.rules.influence.engines._min_violations import solve_tolerant

__all__ = [
    "CpSatEngine",
    "ENUMERATED",
    "Effort",
    "ExactEngine",
    "InfluenceEngine",
    "LABEL_NOISE",
    "Quantum",
    "WrongAnswerError",
    "check_answer",
    "contradicted",
    "influence_answer",
    "influence_words",
    "scaled_answer",
    "slack_of",
    "solve_tolerant",
]

_HOME = {
    "CpSatEngine": "_solve",
    "ENUMERATED": "_effort",
    "Effort": "_effort",
    "ExactEngine": "_solve",
    "InfluenceEngine": "_solve",
    "LABEL_NOISE": "_label_noise",
    "Quantum": "_quantum",
    "WrongAnswerError": "_check",
    "check_answer": "_check",
    "contradicted": "_check",
    "influence_answer": "_of_set",
    "influence_words": "_sentences",
    "scaled_answer": "_rule",
    "slack_of": "_label_noise",
    "solve_tolerant": "engines._min_violations",
}

__getattr__ = names_of(__name__, _HOME)
