"""Audit of labels: demonstrations that contradict the rule that the others follow."""
