"""Experiments: the paper's protocols and our sweeps; many fits, one table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.experiments._stages import RunRecord, Stage, code_key, run_stages

if TYPE_CHECKING:
    from demospec.experiments._ablation import run_grid
    from demospec.experiments._cells import GridSettings, grid_set, rank_in_scene
    from demospec.experiments._grid_table import grid_table
    from demospec.experiments._split import PicturesOnly, hold_out, without_objects
    from demospec.experiments._studies import accuracy_study, plan_study, repair_study

__all__ = [
    "GridSettings",
    "PicturesOnly",
    "RunRecord",
    "Stage",
    "accuracy_study",
    "code_key",
    "grid_set",
    "grid_table",
    "hold_out",
    "plan_study",
    "rank_in_scene",
    "repair_study",
    "run_grid",
    "run_stages",
    "without_objects",
]

_HOME = {
    "GridSettings": "_cells",
    "PicturesOnly": "_split",
    "accuracy_study": "_studies",
    "grid_set": "_cells",
    "grid_table": "_grid_table",
    "hold_out": "_split",
    "plan_study": "_studies",
    "rank_in_scene": "_cells",
    "repair_study": "_studies",
    "run_grid": "_ablation",
    "without_objects": "_split",
}


__getattr__ = names_of(__name__, _HOME)
