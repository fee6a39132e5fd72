"""The report room: results → view data → one self-contained page. Computes no result."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from demospec.report._render import render_html, write_html, write_markdown
from demospec.report._view import Block, Figure, Lines, Report, Section, Table, Text, share, wilson

if TYPE_CHECKING:
    from demospec.report._audit_picture import audit_picture
    from demospec.report._build import build_report
    from demospec.report._causal_picture import draw_causal_picture, save_causal_picture
    from demospec.report._effect_picture import (
        draw_boundary_shift,
        draw_counterfactual,
        draw_counterfactual_strip,
        draw_effect_map,
        save_figure,
    )
    from demospec.report._envelope_picture import draw_envelopes
    from demospec.report._plan_picture import draw_plan
    from demospec.report._transition_picture import draw_transition

__all__ = [
    "Block",
    "Figure",
    "Lines",
    "Report",
    "Section",
    "Table",
    "Text",
    "audit_picture",
    "build_report",
    "draw_boundary_shift",
    "draw_causal_picture",
    "draw_envelopes",
    "draw_counterfactual",
    "draw_counterfactual_strip",
    "draw_effect_map",
    "draw_plan",
    "draw_transition",
    "render_html",
    "save_causal_picture",
    "save_figure",
    "share",
    "wilson",
    "write_html",
    "write_markdown",
]


def __getattr__(name: str) -> Any:
    if name == "audit_picture":
        return importlib.import_module("demospec.report._audit_picture").audit_picture
    if name == "build_report":
        return importlib.import_module("demospec.report._build").build_report
    if name == "draw_envelopes":
        return importlib.import_module("demospec.report._envelope_picture").draw_envelopes
    if name == "draw_plan":
        return importlib.import_module("demospec.report._plan_picture").draw_plan
    if name == "draw_transition":
        return importlib.import_module("demospec.report._transition_picture").draw_transition
    if name in ("draw_causal_picture", "save_causal_picture"):
        return getattr(importlib.import_module("demospec.report._causal_picture"), name)
    if name in (
        "draw_boundary_shift",
        "draw_counterfactual",
        "draw_counterfactual_strip",
        "draw_effect_map",
        "save_figure",
    ):
        return getattr(importlib.import_module("demospec.report._effect_picture"), name)
    raise AttributeError(f"module 'demospec.report' has no attribute {name!r}")
