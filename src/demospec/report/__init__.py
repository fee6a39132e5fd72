"""The report room."""

from demospec.report._plan_picture import draw_plan

__all__ = ["draw_plan"]
