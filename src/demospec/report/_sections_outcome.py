"""Report sections: plans, accuracy, repairs, and how all of it was computed."""

from __future__ import annotations

from typing import Any

import numpy as np

from demospec.report._build import Run
from demospec.report._scene_picture import (
    draw_path,
    draw_scene,
    new_figure,
    to_png,
)
from demospec.report._view import Block, Figure, Section, Table, Text, bracket, percent, share
from demospec.scene import Scene

_PLANS = (
    "Paths planned in scenes that no demonstration was shown in, keeping the upper end of every "
    "clearance. Whether they keep the true rule is decided by the rule that made the labels. "
    "Brackets: 95 % interval of the share, one plan a scene."
)
_OWN_PLANS = (
    "Planned paths, keeping the upper end of every clearance. No true rule is known here: they are "
    "judged by the learned one. Brackets: 95 % interval of the share."
)
_OWN_REPAIRS = (
    "The set's own rejected demonstrations, changed by gradient steps until the model accepts "
    "them; judged by the rules that the command was given, if any. Brackets: 95 % interval."
)


def plans(run: Run) -> Section | None:
    """Obedience and length of the plans, judged by the truth; pictures of some."""
    if run.plans is None:
        return None
    rows = []
    every = run.plans["plans"]
    types = list(dict.fromkeys(p["type"] for p in every))
    for type_ in types:
        mine = [p for p in every if p["type"] == type_]
        found = [p for p in mine if p["status"] == "found"]
        ratio = [p["length"] / p["straight"] for p in found if p["straight"] > 0]
        rows.append(
            (
                type_,
                str(len(mine)),
                str(len(found)),
                share(sum(p["obeys"] for p in found), len(found)),
                _true_share(found),
                f"{np.mean(ratio):.3f}" if ratio else "–",
                f"{max(ratio):.3f}" if ratio else "–",
            )
        )
    header = (
        "type", "scenes", "plan found", "keeps the learned rule", "keeps the true rule",
        "mean length / straight line", "longest / straight line",
    )  # fmt: skip
    missing = [p for p in every if p["status"] != "found"]
    reasons = "; ".join(f"scene {p['scene']}, {p['type']}: {p['reason']}" for p in missing[:3])
    known = any("true_obeys" in p for p in every)
    words = _PLANS if known else _OWN_PLANS
    note = f"Without a plan: {reasons}." if reasons else ""
    by_eye = own_opinion(every)
    if by_eye:
        note = f"{by_eye} {note}".strip()
    blocks: list[Block] = [Text(words), Table(header, tuple(rows), note=note)]
    picture = _plan_pictures(run, types)
    if picture is not None:
        blocks.append(picture)
    return Section("plans", "What the planner does with it", tuple(blocks))


def own_opinion(plans: list[dict[str, Any]]) -> str:
    """A sentence where plans were judged by the model that planned them; else nothing."""
    count = sum(p.get("judged_by") == "model" for p in plans if p["status"] == "found")
    if not count:
        return ""
    who = "This plan is" if count == len(plans) == 1 else f"{count} of these plans are"
    return (
        f"{who} judged by the model's own reading of the picture, because the scene does not list "
        "its objects: an opinion, no check by a rule."
    )


def _true_share(found: list[dict[str, Any]]) -> str:
    judged = [p for p in found if "true_obeys" in p]
    return share(sum(p["true_obeys"] for p in judged), len(judged)) if judged else "not known"


def _plan_pictures(run: Run, types: list[str]) -> Figure | None:
    every = (run.plans or {})["plans"]
    found = {(p["scene"], p["type"]): p for p in every if p["status"] == "found"}
    scenes = [s for s in run.data.scenes if all((s.scene_id, t) in found for t in types)][:2]
    if not scenes:
        return None
    figure, axes = new_figure(len(types), len(scenes))
    for i, scene in enumerate(scenes):
        for j, type_ in enumerate(types):
            ax = axes[i * len(types) + j]
            draw_scene(ax, scene, f"{type_}, scene {scene.scene_id}", outlines=True)
            _draw_costs(ax, run, scene, type_)
            draw_path(ax, np.asarray(found[scene.scene_id, type_]["points"]), True, linewidth=2)
    return Figure(
        to_png(figure),
        "Plans (blue line from circle to star) over the cost map (orange about an object: inside a "
        "clearance to keep) for each type.",
        "Top-down scenes with cost maps and planned paths.",
    )


def _draw_costs(ax: Any, run: Run, scene: Scene, type_: str) -> None:
    """The cost map, where rules are at hand and the scene lists what they speak of."""
    from demospec.planning import cost_map
    from demospec.rules import read_rules

    if run.rules is None or scene.objects is None:
        return
    where = cost_map(read_rules(run.folder / "rules.json"), scene, type_)
    x0, y0, x1, y1 = where.bounds
    price = np.asarray(where.array)
    dear = price > price.min()
    if dear.any():
        shown = np.ma.masked_where(~dear, price)
        ax.imshow(shown, extent=(x0, x1, y1, y0), cmap="Oranges", alpha=0.6, vmin=1.0)


def accuracy(run: Run) -> Section | None:
    """Balanced accuracy on seen and unseen scenes, apart."""
    if run.accuracy is None:
        return None
    from demospec.report._accuracy_picture import accuracy_picture

    rows = [
        (
            model,
            which,
            type_,
            str(s["n"]),
            percent(s["accuracy"]) + ("" if s["balanced_accuracy"] is not None else _ends(s)),
            _balanced(s),
            _balanced(s["far"]) if s.get("far") else "–",
            percent(s["majority"]),
        )
        for model, sets in run.accuracy.items()
        for which, types in sets.items()
        for type_, s in types.items()
    ]
    header = (
        "model", "scenes", "type", "n", "accuracy", "balanced accuracy",
        "balanced, > 2 px from the boundary", "always the commoner label",
    )  # fmt: skip
    blocks: list[Block] = [
        Text(
            "Share of held-out demonstrations judged as their demonstrator labelled them. "
            "Seen scenes (new paths over training pictures) and unseen scenes (new "
            "pictures with unseen items) are different questions. Balanced accuracy is the mean "
            "of the shares among accepted and among rejected paths: 50 % is guessing; a type that "
            "accepts everything cannot be scored (undefined: one class)."
        ),
        *(Text(words) for words in in_unseen_scenes(run)),
    ]
    known = [WHAT[m] for m in run.accuracy if m in WHAT]
    if known:
        blocks.insert(1, Text(f"{' '.join(known)} Both are shown pictures, no lists of objects."))
    picture = accuracy_picture(run.accuracy)
    if picture is not None:
        blocks.append(picture)
    note = "Brackets: 95 % interval, allowing for paths of one scene being alike."
    blocks.append(Table(header, tuple(rows), note=note))
    return Section("accuracy", "How well the specification models judge", tuple(blocks))


WHAT = {
    "paper": "“paper” is the network of the paper: picture and path in, verdict out.",
    "field": "“field” is ours: a pretrained body sees where things are, a rule judges the path.",
}


def in_unseen_scenes(run: Run) -> list[str]:
    """One sentence a model, chosen by where its intervals lie."""
    scored = {m: sets["unseen"] for m, sets in (run.accuracy or {}).items() if "unseen" in sets}
    return [_in_words(model, types) for model, types in scored.items()]


def _in_words(model: str, types: dict[str, Any]) -> str:
    """One sentence on unseen scenes, chosen by where each type's interval lies."""
    groups: dict[str, list[str]] = {}
    for type_, s in types.items():
        value = s.get("balanced_accuracy")
        if value is None:
            continue
        low, high = s["interval"]
        verdict = (
            "is worse than guessing" if high < 0.5
            else "cannot be told from guessing" if low <= 0.5
            else "is better than guessing" if low < 0.8
            else "is right about most paths"
        )  # fmt: skip
        groups.setdefault(verdict, []).append(f"{type_} ({percent(value)})")
    said = "; ".join(f"{verdict} for {', '.join(who)}" for verdict, who in groups.items())
    return f"In unseen scenes the {model} model {said or 'cannot be scored: one class only'}."


def _balanced(s: dict[str, Any]) -> str:
    value = s.get("balanced_accuracy")
    return "undefined: one class" if value is None else percent(value) + _ends(s)


def _ends(s: dict[str, Any]) -> str:
    return f" {bracket([100 * v for v in s['interval']], 0)}"


def repairs(run: Run) -> Section | None:
    """Repairs judged by the truth, with the steps drawn dark to light."""
    if run.repairs is None:
        return None
    rows = []
    for model, sets in run.repairs.items():
        for which, types in sets.items():
            for type_, r in types.items():
                if r["vacuous"]:
                    rows.append((model, which, type_, "vacuous, n\u00a0=\u00a00", "–", "–"))
                    continue
                rows.append(
                    (
                        model,
                        which,
                        type_,
                        _judged(r),
                        percent(r["accepted_by_model"]),
                        f"{r['moved_px']:.1f}",
                    )
                )
    header = (
        "model", "scenes", "type", "valid by the true rule",
        "valid in the model's own opinion", f"moved ({run.data.units})",
    )  # fmt: skip
    blocks: list[Block] = [
        Text(_OWN_REPAIRS)
        if "given" in run.repairs
        else Text(
            "Random paths that the true rule rejects, changed by gradient steps on the model "
            "until it accepts them (one particle, 30 steps, as in the paper). Judged by the true "
            "rule; the model's own opinion stands beside it. A type without invalid paths has "
            "nothing to repair: vacuous. Brackets: 95 % interval, as if starts of one scene were "
            "independent."
        ),
        Table(header, tuple(rows)),
    ]
    picture = _repair_picture(run)
    if picture is not None:
        blocks.append(picture)
    return Section("repairs", "Repairing rejected paths", tuple(blocks))


def _judged(r: dict[str, Any]) -> str:
    value = r["repaired_by_truth"]
    return "not judged" if value is None else share(round(r["n"] * value), r["n"])


def _repair_picture(run: Run) -> Figure | None:
    picked = []
    for model, sets in (run.repairs or {}).items():
        for type_, r in sets.get("unseen", {}).items():
            picked += [(model, type_, e) for e in r["examples"][:1]]
    picked = picked[:4]
    if not picked:
        return None
    figure, axes = new_figure(len(picked), title_lines=2)
    for ax, (model, type_, example) in zip(axes, picked, strict=True):
        scene = run.data.scene(example["scene"])
        outcome = "true rule accepts" if example["rule_valid"] else "true rule rejects"
        draw_scene(ax, scene, f"{model}, {type_}:\n{outcome}", outlines=True, faded=True)
        steps = example["steps"]
        for k, path in list(enumerate(steps))[1:-1]:  # the ends are drawn below
            # Dark to light blue through the steps, as in the paper's figure.
            shade = 0.15 + 0.75 * k / max(1, len(steps) - 1)
            xy = np.asarray(path)
            ax.plot(*xy.T, color=(0.25 * shade, 0.55 * shade, 0.25 + 0.75 * shade), linewidth=1)
        draw_path(ax, np.asarray(steps[0]), None, linewidth=1.4)
        draw_path(ax, np.asarray(steps[-1]), bool(example["rule_valid"]), linewidth=2)
    return Figure(
        to_png(figure),
        "Repairs in unseen scenes: dotted the rejected path, then each step from dark to light, "
        "thick the last (blue where the true rule accepts it, orange where it does not).",
        "Scenes with the sequence of repaired paths.",
    )


def computed(run: Run) -> Section:
    """Command, seed, versions, seconds."""
    r = run.record
    if not r:
        words = "This page was put together from documents that commands wrote into this folder."
        return Section("computed", "How this was computed", (Text(words),))
    stages = r.get("stages", {})
    rows = [(s.get("title", name), f"{s['seconds']:.1f}") for name, s in stages.items()]
    rows.append(("together", f"{sum(s['seconds'] for s in stages.values()):.1f}"))
    versions = ", ".join(f"{k} {v}" for k, v in r.get("versions", {}).items())
    return Section(
        "computed",
        "How this was computed",
        (
            Table(
                ("what", "value"),
                (
                    ("command", str(r.get("command", "–"))),
                    ("seed", str(r.get("seed", "–"))),
                    ("versions", versions),
                    ("Python, machine", f"{r.get('python', '–')}, {r.get('machine', '–')}"),
                ),
            ),
            Table(("stage", "seconds"), tuple(rows), caption="Time of each stage when it ran"),
        ),
    )
