"""`demospec plan`: a path that keeps the rule in one scene, checked exactly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import (
    Json,
    Out,
    Seed,
    SetFolder,
    print_json,
    print_table,
    save_json,
    say,
    show,
)

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet

RulesPath = Annotated[
    Path, typer.Argument(metavar="RULES", help="A rule file (JSON of `rules`), or a model folder.")
]
SceneId = Annotated[str, typer.Option("--scene", help="Scene id.")]
Type = Annotated[
    str | None, typer.Option("--type", help="User type (not needed where the rules know one).")
]
Envelope = Annotated[
    str,
    typer.Option(
        help="Which consistent rule: upper (safest), value (point answer), lower, max, min."
    ),
]
Planner = Annotated[str, typer.Option(help="grid, latent, or an OMPL planner (extra planners).")]
Resolution = Annotated[
    float | None,
    typer.Option(
        min=0,
        max=1e9,
        help="Cells per unit of the set (1/px, 1/m); by default a hundred along the longer side.",
    ),
]

UnknownClearance = Annotated[
    float | None,
    typer.Option(
        min=0,
        max=1e9,
        help="Kept from things that nothing is known about, units of the set; by default the "
        "largest clearance that is known.",
    ),
]
Anyway = Annotated[
    bool, typer.Option("--anyway", help="Use a rule that does not explain the answers, too.")
]


def plan(
    rules: RulesPath,
    set_folder: SetFolder,
    scene: SceneId,
    type: Type = None,
    envelope: Envelope = "upper",
    planner: Planner = "grid",
    resolution: Resolution = None,
    unknown_clearance: UnknownClearance = None,
    anyway: Anyway = False,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the scene, its zones and the plan (PNG).")
    ] = None,
    out: Out = None,
    json: Json = False,
    seed: Seed = 0,
) -> None:
    """Plan a path in one scene that keeps the rule, and check it exactly.

    The default envelope is the upper corner of what the demonstrations allow: such a plan
    obeys every rule that agrees with them. A scene without a way says which object blocks.
    """
    from demospec.demonstrations import read_set
    from demospec.planning import cost_map, plan_path, read_plannable

    data = read_set(set_folder)
    known = read_plannable(rules, data)
    say_misspelt(known, data)
    result = plan_path(
        known,
        data.scene(scene),
        type,
        envelope,  # type: ignore[arg-type]  # checked by plan_path, which lists the names
        planner=planner,
        resolution=resolution,
        seed=seed,
        unknown_clearance=unknown_clearance,
        anyway=anyway,
    )
    document = result.to_json()
    save_json(document, out)
    if picture is not None:
        from demospec.report import draw_plan

        shown = cost_map(known, data.scene(scene), type, envelope)  # type: ignore[arg-type]
        draw_plan(shown, data.scene(scene), result, picture)
        say(f"wrote {picture}")
    if json:
        print_json(document)
    else:
        _show(document, document["metres_per_unit"], data.units)


def say_misspelt(known: object, data: DemonstrationSet) -> None:
    """Says which class of a rule no scene lists, where one that nothing is said of is like it."""
    from difflib import get_close_matches

    from demospec.rules import RuleSet

    if not isinstance(known, RuleSet):
        return
    there = {thing.symbol for scene in data.scenes for thing in scene.objects or ()}
    clear = [rule.clearance for rule in known.rules.values() if rule.clearance is not None]
    spoken = {symbol for rule in clear for symbol in (*rule.value, *rule.uninformed)}
    for symbol in sorted(spoken - there):
        for like in get_close_matches(symbol, sorted(there - spoken), 1, 0.75):
            say(f"note: no scene lists {symbol}, of which the rule speaks; is {like} meant?")


def _show(document: dict[str, Any], metres_per_unit: float | None, units: str = "px") -> None:
    from demospec.frames import describe_length

    def words(length: float) -> str:
        return describe_length(length, metres_per_unit, units)

    title = f"scene {document['scene_id']}, {document['type']}, {document['planner']} planner, "
    title += f"envelope {document['envelope']}"
    if document["status"] != "found":
        show(f"{title}\n{document['status']}: {document['reason']}")
        return
    verdict = {True: "yes", False: "no", None: "not known: nothing that was shown decides here"}[
        document["obeys"]
    ]
    by_eye = ", as the model sees the scene" if document["judged_by"] == "model" else ""
    rows = [
        [f"keeps the rule{by_eye}", verdict],
        ["length", words(document["length"])],
        ["cost", f"{document['cost']:.1f}"],
        ["way points", str(len(document["points"]))],
        ["time", f"{document['seconds'] * 1000:.0f} ms"],
    ]
    rows += [[f"clearance to {name}", words(c)] for name, c in document["clearance"].items()]
    if document["t"]:
        rows.append(["duration", f"{document['t'][-1]:.3g} s"])
    rows += [[c["sentence"], _kept(c, units, metres_per_unit)] for c in document["constraints"]]
    rows += [
        [f"too near to {v['object']}", f"by {words(v['by'])} at {v['at']}"]
        for v in document["violations"]
    ]
    print_table(title, ["what", "value"], rows, "\n".join(_notes(document, words)))


def _kept(constraint: dict[str, Any], units: str, metres_per_unit: float | None) -> str:
    """Whether a constraint is kept, and by how much."""
    from demospec.rules import quantity_words

    if constraint["kept"] is None:
        return "not known: the path does not hold what it speaks of"
    verdict = "yes" if constraint["kept"] else "no"
    if constraint["margin"] is None:
        return f"{verdict}: the path comes to nothing that it speaks of"
    left = quantity_words(abs(constraint["margin"]), constraint["unit"], units, metres_per_unit)
    if constraint["kept"]:
        upright = " when carried upright" if constraint["how"] == "execution" else ""
        return f"{verdict}, with {left} to spare{upright}"
    return f"{verdict}, by {left}"


def _notes(document: dict[str, Any], words: Callable[[float], str]) -> list[str]:
    """What the plan could not rest on evidence."""
    notes = []
    if document["unbounded"]:
        names = ", ".join(document["unbounded"])
        notes.append(f"no accepted demonstration bounds the clearance to {names}: point answer")
    for symbol, kept in document["capped"].items():
        notes.append(f"start or goal is nearer to a {symbol} than the envelope: {words(kept)} kept")
    if document["uninformed"]:
        names = ", ".join(document["uninformed"])
        kept = document["unknown_clearance"]
        what = "the plan may pass through" if kept is None else f"the plan keeps {words(kept)}"
        notes.append(f"nothing is known about {names}: {what} (--unknown-clearance)")
    return notes


def refuse_unexplained_type(model: Any, type: str, anyway: bool) -> None:
    """InputError where a model's rules of a type do not explain the answers they come from."""
    from demospec.rules import RuleSet, refuse_unexplained

    rules = model if isinstance(model, RuleSet) else getattr(model, "rules", None)
    if isinstance(rules, RuleSet) and type in rules.rules:
        refuse_unexplained(rules.of_type(type).fit, type, anyway=anyway)
