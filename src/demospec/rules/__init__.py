"""Rules: types, exact engines, envelopes, conflicts, queries."""

from demospec.rules._results import ClearanceRule, RuleSet, RuleView, TypeRules

__all__ = ["ClearanceRule", "RuleSet", "RuleView", "TypeRules"]
