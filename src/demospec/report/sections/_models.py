"""Report sections: how well models judge and repair, and how everything was computed."""

from __future__ import annotations

import numpy as np

from demospec.frames import describe_length
from demospec.report._view import Block, Figure, Section, Table, Text, bracket, percent, share
from demospec.report.pictures._accuracy import accuracy_picture, curves_picture
from demospec.report.pictures._scene import draw_path, draw_scene, new_figure, to_png
from demospec.report.run._documents import GIVEN, RepairExample, RepairScore, Score
from demospec.report.run._run import Run

_OWN_REPAIRS = (
    "The set's own rejected demonstrations, changed by gradient steps until the model accepts "
    "them; judged by the rules that the command was given, if any. Brackets: 95 % interval."
)
_REPAIRS = (
    "Random paths that the true rule rejects, changed by gradient steps on the model until it "
    "accepts them (one particle, 30 steps, as in the paper). Judged by the true rule; the model's "
    "own opinion stands beside it. A type without invalid paths has nothing to repair. "
    "Brackets: 95 % interval, as if starts of one scene were independent."
)
WHAT = {
    "paper": "“paper” is the network of the paper: picture and path in, verdict out.",
    "field": "“field” is ours: a pretrained body sees where things are, a rule judges the path.",
}


def accuracy(run: Run) -> Section | None:
    """Balanced accuracy on seen and unseen scenes, apart; and with more demonstrations."""
    if not run.accuracy and not run.curves:
        return None
    blocks: list[Block] = [
        Text(
            "Share of held-out demonstrations judged as their demonstrator labelled them. "
            "Seen scenes (new paths over training pictures) and unseen scenes (new "
            "pictures with unseen items) are different questions. Balanced accuracy is the mean "
            "of the shares among accepted and among rejected paths: 50 % is guessing; a type that "
            "accepts everything cannot be scored (undefined: one class)."
        )
    ]
    known = [WHAT[m] for m in run.accuracy if m in WHAT]
    if known:
        blocks.append(Text(f"{' '.join(known)} Both are shown pictures, no lists of objects."))
    told = in_unseen_scenes(run)
    blocks += [Text(words) for words in told]
    if run.accuracy:
        picture = accuracy_picture(run.accuracy)
        if picture is not None:
            blocks.append(picture)
        blocks.append(_scores(run))
    for name, rows in run.curves.items():
        drawn = curves_picture(rows)
        blocks.append(Text(f"With more demonstrations ({name} draws)", emphasis=True))
        blocks.append(drawn or Text("No type has both accepted and rejected paths."))
        blocks.append(_curve_table(run, name))
    lead = " ".join(told) or "Share of held-out demonstrations judged as they were labelled."
    return Section("accuracy", "How well the specification models judge", tuple(blocks), lead)


def _scores(run: Run) -> Table:
    header = (
        "model", "scenes", "type", "n", "accuracy", "balanced accuracy",
        "balanced, > 2 px from the boundary", "always the commoner label",
    )  # fmt: skip
    rows = [
        (
            model,
            which,
            name,
            str(s.n),
            percent(s.accuracy) + ("" if s.balanced_accuracy is not None else _ends(s)),
            _balanced(s),
            "–" if s.far is None else _balanced(s.far),
            percent(s.majority),
        )
        for model, sets in run.accuracy.items()
        for which, types in sets.items()
        for name, s in types.items()
    ]
    note = "Brackets: 95 % interval, allowing for paths of one scene being alike."
    return Table(header, tuple(rows), note=note)


def _curve_table(run: Run, name: str) -> Table:
    header = ("model", "type", "demonstrations a scene", "fits", "balanced, seen scenes",
              "balanced, unseen scenes", "always the commoner label, seen")  # fmt: skip
    rows = tuple(
        (
            r.model, r.type, str(r.n), str(r.fits), percent(r.bacc_seen), percent(r.bacc_unseen),
            percent(r.majority_seen),
        )
        for r in run.curves[name]
    )  # fmt: skip
    return Table(header, rows)


def in_unseen_scenes(run: Run) -> list[str]:
    """One sentence a model, chosen by where its intervals lie."""
    scored = {m: sets["unseen"] for m, sets in run.accuracy.items() if "unseen" in sets}
    said = []
    for model, types in scored.items():
        groups: dict[str, list[str]] = {}
        for name, s in types.items():
            if s.balanced_accuracy is None:
                continue
            low, high = s.interval
            verdict = (
                "is worse than guessing" if high < 0.5
                else "cannot be told from guessing" if low <= 0.5
                else "is better than guessing" if low < 0.8
                else "is right about most paths"
            )  # fmt: skip
            groups.setdefault(verdict, []).append(f"{name} ({percent(s.balanced_accuracy)})")
        each = "; ".join(f"{verdict} for {', '.join(who)}" for verdict, who in groups.items())
        words = each or "cannot be scored: one class only"
        said.append(f"In unseen scenes the {model} model {words}.")
    return said


def _balanced(s: Score) -> str:
    value = s.balanced_accuracy
    return "undefined: one class" if value is None else percent(value) + _ends(s)


def _ends(s: Score) -> str:
    return f" {bracket([100 * v for v in s.interval], 0)}"


def repairs(run: Run) -> Section | None:
    """Repairs judged by the truth, with the steps drawn dark to light."""
    if run.repairs is None:
        return None
    rows = []
    for model, sets in run.repairs.items():
        for which, types in sets.items():
            for name, r in types.items():
                if r.vacuous or not r.n:
                    rows.append((model, which, name, "nothing to repair", "–", "–"))
                    continue
                moved = r.moved_px
                rows.append(
                    (
                        model, which, name, _judged(r), percent(r.accepted_by_model),
                        "–" if moved is None
                        else describe_length(moved, run.data.metres_per_unit, run.data.units),
                    )
                )  # fmt: skip
    header = (
        "model", "scenes", "type", "valid by the true rule",
        "valid in the model's own opinion", "control point moved",
    )  # fmt: skip
    own = GIVEN in run.repairs
    blocks: list[Block] = [Text(_OWN_REPAIRS if own else _REPAIRS), Table(header, tuple(rows))]
    picture = _repair_picture(run)
    if picture is not None:
        blocks.append(picture)
    lead = "Rejected paths, changed as little as the model asks until it accepts them."
    return Section("repairs", "Repairing rejected paths", tuple(blocks), lead)


def _judged(r: RepairScore) -> str:
    value = r.repaired_by_truth
    return "not judged" if value is None else share(round(r.n * value), r.n)


def _repair_picture(run: Run) -> Figure | None:
    picked: list[tuple[str, str, RepairExample]] = []
    for model, sets in (run.repairs or {}).items():
        for name, r in sets.get("unseen", {}).items():
            picked += [(model, name, e) for e in r.examples[:1]]
    picked = picked[:4]
    if not picked:
        return None
    figure, axes = new_figure(len(picked), title_lines=2)
    for ax, (model, name, example) in zip(axes, picked, strict=True):
        scene = run.data.scene(example.scene)
        outcome = "true rule accepts" if example.rule_valid else "true rule rejects"
        draw_scene(ax, scene, f"{model}, {name}:\n{outcome}", outlines=True, faded=True)
        steps = [np.asarray(step) for step in example.steps]
        for k, xy in list(enumerate(steps))[1:-1]:  # the ends are drawn below
            # Dark to light blue through the steps, as in the paper's figure.
            shade = 0.15 + 0.75 * k / max(1, len(steps) - 1)
            ax.plot(*xy.T, color=(0.25 * shade, 0.55 * shade, 0.25 + 0.75 * shade), linewidth=1)
        draw_path(ax, steps[0], None, linewidth=1.4)
        draw_path(ax, steps[-1], example.rule_valid, linewidth=2)
    return Figure(
        to_png(figure),
        "Repairs in unseen scenes: dotted the rejected path, then each step from dark to light, "
        "thick the last (blue where the true rule accepts it, orange where it does not).",
        "Scenes with the sequence of repaired paths.",
    )


def computed(run: Run) -> Section:
    """Command, seed, versions, seconds."""
    title, r = "How this was computed", run.record
    if r is None:
        words = "This page was put together from documents that commands wrote into this folder."
        return Section("computed", title, (Text(words),), "From documents of single commands.")
    seconds = sum(s.seconds for s in r.stages.values())
    rows = [(s.title or name, f"{s.seconds:.1f}") for name, s in r.stages.items()]
    facts = (
        ("command", r.command),
        ("seed", str(r.seed)),
        ("versions", ", ".join(f"{k} {v}" for k, v in r.versions.items())),
        ("Python, machine", f"{r.python}, {r.machine}"),
    )
    times = Table(
        ("stage", "seconds"),
        (*rows, ("together", f"{seconds:.1f}")),
        caption="Time of each stage when it ran",
    )
    lead = f"{r.command}, seed {r.seed}, {seconds:.0f} s."
    return Section("computed", title, (Table(("what", "value"), facts), times), lead)
