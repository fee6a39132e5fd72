"""Experiments: the paper's protocols and our sweeps; many fits, one table."""

from demospec.experiments._stages import RunRecord, Stage, run_stages

__all__ = ["RunRecord", "Stage", "run_stages"]
