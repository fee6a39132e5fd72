"""The one way through the studio, with ticks: what is done, and what is missing for the rest."""

from __future__ import annotations

from dataclasses import dataclass

from demospec.studio.results._export import LEARNING, PLANNED, choices
from demospec.studio.session._replay import UNNAMED
from demospec.studio.session._workspace import Workbench


@dataclass(frozen=True)
class Step:
    """One step of the way.

    Args:
        key: Of the page that it is done on.
        name: For people.
        missing: What is missing, in a sentence; nothing where it is done.
    """

    key: str
    name: str
    missing: str = ""


def steps_of(bench: Workbench, scene_id: str, type: str, doubts: int | None) -> tuple[Step, ...]:
    """The way for one table and one person.

    Args:
        doubts: Contradictions that are open, of everybody; None while rules are being learned.
    """
    planned = LEARNING if doubts is None else _to_plan(bench, scene_id, type)
    return (
        Step("table", "Table", missing_on_table(bench, scene_id)),
        Step("teach", "Teach", _to_teach(bench, type)),
        Step("check", "Check", _to_check(bench, doubts)),
        Step("results", "Plan and report", planned),
    )


def missing_on_table(bench: Workbench, scene_id: str) -> str:
    """What a table lacks before one can teach on it and export from it."""
    scene = bench.scene(scene_id)
    if scene.objects is None:
        return "Nobody has said yet what stands here: mark the objects."
    nameless = sum(o.symbol.startswith(UNNAMED) for o in scene.objects)
    if nameless:
        what = "One found object has" if nameless == 1 else f"{nameless} found objects have"
        return f"{what} no name yet: name {'it' if nameless == 1 else 'them'}."
    if bench.scale_of(scene_id) is None:
        return "How wide is this picture on the table? Robots need metres."
    return ""


def _to_teach(bench: Workbench, type: str) -> str:
    said = {d.valid for d in bench.demonstrations if d.type == type}
    if True not in said:
        return "Accept one path."
    return "" if False in said else "Reject one path that comes too near."


def _to_check(bench: Workbench, doubts: int | None) -> str:
    if doubts is None:
        return LEARNING
    if doubts:
        return "One contradiction is open." if doubts == 1 else f"{doubts} contradictions are open."
    if not any(d.valid is not None for d in bench.demonstrations):
        return "Teach first."
    unsaid = sum(d.valid is None for d in bench.demonstrations)
    if unsaid:
        return (
            f"{unsaid} {'path is' if unsaid == 1 else 'paths are'} neither accepted nor rejected."
        )
    return ""


def _to_plan(bench: Workbench, scene_id: str, type: str) -> str:
    offered = choices(bench)
    for form in PLANNED[:1]:
        if form in offered.missing:
            return offered.missing[form]
    if scene_id in offered.missing_in:
        return offered.missing_in[scene_id]
    first = next(iter(offered.rules), "")
    return offered.missing_for.get(first, {}).get(type, "")
