"""Report section: what a planner does with the rules."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from demospec.report._view import Block, Figure, Section, Table, Text, share
from demospec.report.pictures._plan import plan_panels
from demospec.report.run._documents import PlanEntry
from demospec.report.run._run import Run
from demospec.rules import ANYONE

_PLANS = (
    "Paths planned in scenes that no demonstration was shown in, keeping the upper end of every "
    "clearance. Whether they keep the true rule is decided by the rule that made the labels. "
    "Brackets: 95 % interval of the share, one plan a scene."
)
_OWN_PLANS = (
    "Planned paths, keeping the upper end of every clearance. No true rule is known here: they are "
    "judged by the learned one. Brackets: 95 % interval of the share."
)
SHOWN = 4


def plans(run: Run) -> Section | None:
    """Obedience and length of the plans, judged by the truth; pictures of some."""
    if not run.plans:
        return None
    every = run.plans
    rows = []
    for name in dict.fromkeys(p.type for p in every):
        mine = [p for p in every if p.type == name]
        found = [p for p in mine if p.found]
        known = [p for p in found if p.obeys is not None]
        ratio = [detour(run, p) for p in found]
        rows.append(
            (
                name or ANYONE,
                str(len(mine)),
                str(len(found)),
                share(sum(bool(p.obeys) for p in known), len(known)),
                _true_share(found),
                f"{np.mean(ratio):.3f}" if ratio else "–",
                f"{max(ratio):.3f}" if ratio else "–",
            )
        )
    header = (
        "type", "scenes", "plan found", "keeps the learned rule", "keeps the true rule",
        "mean length / straight line", "longest / straight line",
    )  # fmt: skip
    missing = [p for p in every if not p.found]
    reasons = "; ".join(f"scene {p.scene}, {p.type}: {p.reason}" for p in missing[:3])
    judged = any(p.true_obeys is not None for p in every)
    note = f"Without a plan: {reasons}." if reasons else ""
    by_eye = own_opinion(every)
    if by_eye:
        note = f"{by_eye} {note}".strip()
    words = _PLANS if judged else _OWN_PLANS
    blocks: list[Block] = [Text(words), Table(header, tuple(rows), note=note)]
    picture = _pictures(run)
    if picture is not None:
        blocks.append(picture)
    lead = planned_words(every)
    return Section("plans", "What the planner does with it", tuple(blocks), lead)


def detour(run: Run, plan: PlanEntry) -> float:
    """Length of a found plan over the straight line; 1 where it goes straight."""
    scene = run.data.scene(plan.scene)
    straight = float(np.hypot(*np.subtract(scene.goal[:2], scene.start[:2])))
    return plan.length / straight if plan.length is not None and straight > 0 else 1.0


def planned_words(plans: Sequence[PlanEntry]) -> str:
    """One sentence: how many were found, and how many of these keep which rule."""
    found = [p for p in plans if p.found]
    judged = [p for p in found if p.true_obeys is not None]
    if judged:
        kept = sum(bool(p.true_obeys) for p in judged)
        return (
            f"Of {len(plans)} plans asked for in unseen scenes, {len(found)} were found; "
            f"{kept} of these keep the demonstrator's true rule."
        )
    known = [p for p in found if p.obeys is not None]
    kept = sum(bool(p.obeys) for p in known)
    if len(plans) == 1:
        verdict = "nothing known decides whether it keeps the rule"
        if known:
            verdict = f"it {'keeps' if kept else 'breaks'} the learned rule"
        return f"1 plan: {f'found; {verdict}' if found else 'none found'}."
    return f"{len(plans)} plans: {len(found)} found, {kept} of these keep the learned rule."


def own_opinion(plans: Sequence[PlanEntry]) -> str:
    """A sentence where plans were judged by the model that planned them; else nothing."""
    count = sum(p.judged_by == "model" for p in plans if p.found)
    if not count:
        return ""
    who = "This plan is" if count == len(plans) == 1 else f"{count} of these plans are"
    return (
        f"{who} judged by the model's own reading of the picture, because the scene does not list "
        "its objects: an opinion, no check by a rule."
    )


def _true_share(found: list[PlanEntry]) -> str:
    judged = [p for p in found if p.true_obeys is not None]
    kept = sum(bool(p.true_obeys) for p in judged)
    return share(kept, len(judged)) if judged else "not known"


def _pictures(run: Run) -> Figure | None:
    """The plan of each type that goes the longest way round."""
    picked = []
    for name in dict.fromkeys(p.type for p in run.plans or ()):
        mine = [p for p in run.plans or () if p.type == name and p.found]
        picked += sorted(mine, key=lambda p: -detour(run, p))[:1]
    picked = picked[:SHOWN]
    if not picked:
        return None
    return Figure(
        plan_panels(run, picked),
        "For each type the plan that goes the longest way round (blue, from circle to star); "
        "shaded what it keeps clear of.",
        "Top-down scenes with the regions to keep clear of and the planned paths.",
    )
