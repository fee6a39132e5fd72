"""The report room: results → view data → one self-contained page. Computes no result."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of
from demospec.report._render import render_html, render_parts, write_html, write_markdown
from demospec.report._view import (
    Block,
    Drawing,
    Figure,
    Light,
    Lines,
    Person,
    Report,
    Section,
    Table,
    Text,
    share,
    wilson,
)

if TYPE_CHECKING:
    from demospec.report._build import build_report
    from demospec.report._looks import look_of
    from demospec.report._render import STYLES
    from demospec.report.drawing._contours import contour_at, ring_words_svg, rings_svg
    from demospec.report.drawing._markup import joined
    from demospec.report.drawing._scene_svg import (
        VERDICTS,
        data_url,
        ends_svg,
        line_svg,
        objects_svg,
        over_svg,
        paths_svg,
        points_of,
        scene_svg,
        short_name,
    )
    from demospec.report.drawing._window import line_width, view_box
    from demospec.report.pictures._audit import audit_picture
    from demospec.report.pictures._causal import draw_causal_picture, save_causal_picture
    from demospec.report.pictures._dose import draw_dose_response
    from demospec.report.pictures._effect import (
        draw_boundary_shift,
        draw_counterfactual,
        draw_counterfactual_strip,
        draw_effect_map,
        save_figure,
    )
    from demospec.report.pictures._envelopes import draw_envelopes
    from demospec.report.pictures._plan import draw_plan
    from demospec.report.pictures._run import draw_run
    from demospec.report.pictures._scene import draw_question
    from demospec.report.pictures._transition import draw_transition
    from demospec.report.run._documents import (
        AuditEntry,
        LabelChange,
        PlanEntry,
        QueryEntry,
        RunRecord,
    )
    from demospec.report.run._run import Run, read_run
    from demospec.report.sections._people import more_answers, people_of

__all__ = [
    "AuditEntry",
    "Block",
    "Drawing",
    "Figure",
    "LabelChange",
    "Light",
    "Lines",
    "Person",
    "PlanEntry",
    "QueryEntry",
    "Report",
    "Run",
    "RunRecord",
    "STYLES",
    "Section",
    "Table",
    "Text",
    "VERDICTS",
    "audit_picture",
    "build_report",
    "contour_at",
    "data_url",
    "draw_boundary_shift",
    "draw_causal_picture",
    "draw_counterfactual",
    "draw_counterfactual_strip",
    "draw_dose_response",
    "draw_effect_map",
    "draw_envelopes",
    "draw_plan",
    "draw_run",
    "draw_question",
    "draw_transition",
    "ends_svg",
    "joined",
    "line_svg",
    "line_width",
    "look_of",
    "more_answers",
    "objects_svg",
    "over_svg",
    "people_of",
    "paths_svg",
    "points_of",
    "read_run",
    "render_html",
    "render_parts",
    "ring_words_svg",
    "rings_svg",
    "save_causal_picture",
    "save_figure",
    "scene_svg",
    "share",
    "short_name",
    "view_box",
    "wilson",
    "write_html",
    "write_markdown",
]

_HOME = {
    **dict.fromkeys(
        ("AuditEntry", "LabelChange", "PlanEntry", "QueryEntry", "RunRecord"), "run._documents"
    ),
    **dict.fromkeys(("Run", "read_run"), "run._run"),
    **dict.fromkeys(("contour_at", "ring_words_svg", "rings_svg"), "drawing._contours"),
    **dict.fromkeys(("line_width", "view_box"), "drawing._window"),
    **dict.fromkeys(
        (
            "VERDICTS", "data_url", "ends_svg", "line_svg", "objects_svg", "over_svg", "paths_svg",
            "points_of", "scene_svg", "short_name",
        ),
        "drawing._scene_svg",
    ),
    **dict.fromkeys(("draw_causal_picture", "save_causal_picture"), "pictures._causal"),
    **dict.fromkeys(
        (
            "draw_boundary_shift", "draw_counterfactual", "draw_counterfactual_strip",
            "draw_effect_map", "save_figure",
        ),
        "pictures._effect",
    ),
    "draw_dose_response": "pictures._dose",
    "STYLES": "_render",
    "audit_picture": "pictures._audit",
    "build_report": "_build",
    "draw_envelopes": "pictures._envelopes",
    "draw_plan": "pictures._plan",
    "draw_run": "pictures._run",
    "draw_question": "pictures._scene",
    "draw_transition": "pictures._transition",
    "joined": "drawing._markup",
    "look_of": "_looks",
    "more_answers": "sections._people",
    "people_of": "sections._people",
}  # fmt: skip


__getattr__ = names_of(__name__, _HOME)
