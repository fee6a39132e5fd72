"""Prediction, evaluation, conformal verdicts, identification and explanation."""
