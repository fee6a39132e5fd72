"""Shared by all tests: one thread per process, no network, small sets with known truth."""

from __future__ import annotations

import os

# Before any library that starts a thread pool: two workers with two threads each crawl.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
os.environ.setdefault("MPLBACKEND", "Agg")
