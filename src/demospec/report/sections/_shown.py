"""Report section: what was demonstrated, and which labels were changed."""

from __future__ import annotations

from demospec.report._view import Block, Figure, Section, Table, Text, counted, percent, share
from demospec.report.pictures._scene import demonstrations_picture
from demospec.report.run._run import Run
from demospec.report.sections._people import change_words
from demospec.rules import clearance_words, constraint_words, listed
from demospec.scene import Scene


def shown(run: Run) -> Section:
    """Counts, and pictures of some scenes with their demonstrations."""
    d = run.data.demonstrations
    split_of = {s.scene_id: s.split for s in run.data.scenes}
    rows = []
    for type_ in [*run.data.types, None]:
        mine = [i for i in range(len(d)) if d.type[i] == type_]
        if not mine:
            continue
        train = sum(split_of[d.scene_id[i]] == "train" for i in mine)
        valid = [int(d.valid[i]) for i in mine if d.valid[i] >= 0]
        rows.append(
            (
                type_ or "(type not said)",
                str(len(mine)),
                str(train),
                str(len(mine) - train),
                share(sum(valid), len(valid)) if valid else "not labelled",
            )
        )
    header = ("type of user", "demonstrations", "in training scenes", "in other scenes", "accepted")
    words = (
        "Paths from the circle to the star over pictures of a table, each accepted or rejected. "
        "Accepted paths are drawn solid and blue, rejected ones dashed and orange."
    )
    blocks: list[Block] = [Text(words)]
    if run.truth is not None:
        blocks.append(Text(_simulated(run)))
    note = "Brackets: 95 % interval of the share, n demonstrations."
    blocks.append(Table(header, tuple(rows), note=note))
    if run.changes:
        blocks.append(_changes(run))
    blocks.append(_pictures(run))
    judged = [int(v) for v in d.valid if v >= 0]
    told = f"{percent(sum(judged) / len(judged), 0)} accepted" if judged else "none labelled"
    lead = (
        f"{counted(len(d), 'path')} in {counted(len(run.data.scenes), 'scene')}, {told}"
        + (f"; {counted(len(run.changes), 'label')} changed afterwards" if run.changes else "")
        + "."
    )
    return Section("shown", "What was demonstrated", tuple(blocks), lead)


def _changes(run: Run) -> Table:
    rows = tuple(
        (c.demo_id, change_words(c.before, c.after).strip(" ()"), c.by or "–")
        for c in run.changes[:30]
    )
    more = len(run.changes) - 30
    return Table(
        ("demonstration", "label now", "changed by"),
        rows,
        caption="Labels that were changed after they were given",
        note=f"and {more} more" if more > 0 else "",
    )


def _pictures(run: Run) -> Figure:
    d = run.data.demonstrations
    by_scene = run.data.rows_by_scene()
    types: list[str | None] = [*run.data.types[:3]] or [None]
    scenes, paths, titles = [], [], []
    chosen = [s for s in run.data.scenes if s.split == "train" and s.scene_id in by_scene][:1]
    chosen += [s for s in run.data.scenes if s.split != "train" and s.scene_id in by_scene][:1]
    for scene in chosen:
        for type_ in types:
            rows = [int(i) for i in by_scene[scene.scene_id] if d.type[i] == type_]
            scenes.append(scene)
            paths.append([(d.points(i), _said(int(d.valid[i]))) for i in rows])
            titles.append(f"{type_ or 'anyone'}, scene {scene.scene_id} ({scene.split})")
    above, *below = [_kind(scene) for scene in chosen]
    where = f"{above} (above) and {below[0]} (below)" if below else above
    return Figure(
        demonstrations_picture(scenes, paths, titles, columns=len(types)),
        f"Demonstrations in {where}.",
        "Top-down pictures of tables with the demonstrated paths drawn over them.",
    )


def _kind(scene: Scene) -> str:
    return "a training scene" if scene.split == "train" else "a scene that no model was fitted on"


def _simulated(run: Run) -> str:
    """That the demonstrators are simulated, and by which rule."""
    assert run.truth is not None
    told = []
    for type_, rule in run.truth.rules.items():
        value = {} if rule.clearance is None else rule.clearance.value
        kept = clearance_words(
            value, list(value), [], metres_per_unit=run.data.metres_per_unit, units=run.data.units
        )
        scale, units = run.truth.metres_per_unit, run.truth.units
        asked = [constraint_words(c, units, scale) for c in rule.constraints]
        told.append(f"{type_} {listed([*([kept] if value or not asked else []), *asked])}")
    return (
        "The demonstrators are simulated, so the rule that made their labels is known: "
        f"{'; '.join(told)}. Nothing was learned from it; outcomes below are judged by it."
    )


def _said(valid: int) -> bool | None:
    return None if valid < 0 else bool(valid)
