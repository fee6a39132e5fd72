"""Exact engines of the influence family, and the CP-SAT encodings."""
