"""CP-SAT encodings (extra ``cpsat``): one reified channel per point, and step functions."""
