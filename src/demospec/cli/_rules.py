"""`demospec rules`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict

import typer

from demospec.cli._common import (
    Cluster,
    Json,
    Out,
    Workers,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
    show,
)
from demospec.errors import InputError

if TYPE_CHECKING:
    from demospec.rules import RuleSet

LARGE = 100_000
"""Of sets with more demonstrations a random part is learned from: `SAMPLE` of each type."""
SAMPLE = 10_000


class Spread(TypedDict):
    """Over what the work is spread: arguments of `run_tasks`."""

    workers: int
    cluster: str | None


def rules(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="SET | PROBLEM.json …",
            help="A demonstration set (a folder, or a URL), or problem files.",
        ),
    ],
    json: Json = False,
    out: Out = None,
    sharing: Annotated[
        str,
        typer.Option(help="Clearances of the classes: average, shared (one for all) or separate."),
    ] = "average",
    distance: Annotated[
        str, typer.Option(help="Clearance to the footprint, or to the center.")
    ] = "footprint",
    split: Annotated[
        str, typer.Option(help="Learn from the scenes of this split; all takes every scene (SET).")
    ] = "train",
    influence: Annotated[
        bool | None,
        typer.Option(
            help="Learn the influence rule of the paper too (SET); with --influence it is printed.",
            show_default="learned",
        ),
    ] = None,
    f_max: Annotated[
        float | None,
        typer.Option("--f-max", help="Influence: F_max; for problems, in place of theirs."),
    ] = None,
    reading: Annotated[
        str | None,
        typer.Option(help="Influence: sum, nearest, nearest_active, max_active or first."),
    ] = None,
    preset: Annotated[
        str | None, typer.Option(help="Influence: physical (deeper costs more, by arc length).")
    ] = None,
    engine: Annotated[
        str, typer.Option(help="Influence problems: auto, exact, step or direct (extra cpsat).")
    ] = "auto",
    tolerant: Annotated[
        bool, typer.Option("--tolerant", help="Influence: fit with the fewest contradicted labels.")
    ] = False,
    label_noise: Annotated[
        float,
        typer.Option(help="With --tolerant: expected share of wrong labels; 0 for the best fit."),
    ] = 0.05,
    time_limit: Annotated[
        float | None,
        typer.Option(min=0.01, help="Influence problems: time limit of each, seconds."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(help="Draw the envelopes over a scene (SET; PNG, SVG, PDF)."),
    ] = None,
    scene: Annotated[
        str | None, typer.Option(help="Scene of --picture (default: the first).")
    ] = None,
    enough: Annotated[
        bool,
        typer.Option(
            "--enough", help="Learning curve: the interval against the number of demonstrations."
        ),
    ] = False,
    workers: Workers = 1,
    cluster: Cluster = None,
) -> None:
    """Learn from a set what each type of user keeps away from, and how far.

    A problem file states one problem of the clearance or the influence family. A set with more
    than 100,000 demonstrations is represented by a random 10,000 of each type.
    """
    spread: Spread = {"workers": workers, "cluster": cluster}
    paths = [Path(name) for name in names]
    _one_of("--sharing", sharing, ("average", "shared", "separate"))
    _one_of("--distance", distance, ("footprint", "center"))
    _one_of("--engine", engine, ("auto", "exact", "step", "direct"))
    _one_of("--preset", preset, (None, "physical"))
    readings = ("sum", "nearest", "nearest_active", "max_active", "first")
    _one_of("--reading", reading, (None, *readings))
    if f_max is not None and not f_max > 0:
        raise InputError("a number > 0", f_max, field="--f-max")
    settings: dict[str, Any] = {"preset": preset, "reading": reading, "F_max": f_max}
    settings = {key: value for key, value in settings.items() if value is not None}
    if enough and (workers > 1 or cluster is not None):
        raise InputError("one process", "--workers or --cluster", field="--enough")
    if enough:
        within = None if split == "all" else split
        chosen: dict[str, Any] = {"sharing": sharing, "distance": distance, "split": within}
        _enough(paths, settings, chosen, json=json, out=out, picture=picture)
        return
    if len(paths) == 1 and not _is_problem(paths[0]):
        _set(
            names[0],
            spread,
            {
                "sharing": sharing,
                "distance": distance,
                "split": None if split == "all" else split,
                "influence": influence is not False,
                "settings": settings,
            },
            paper=influence is True or bool(settings),
            json=json,
            out=out,
            picture=picture,
            scene=scene,
        )
        return
    if picture is not None:
        raise InputError("a demonstration set for a picture", str(paths[0]), field="--picture")
    for path in paths:
        if path.is_dir():
            raise InputError("problem files, or one set", "a folder", file=path)
    options = {
        "engine": engine,
        "tolerant": tolerant,
        "label_noise": label_noise,
        "time_limit_s": time_limit,
    }
    _problems(paths, settings, options, spread, json=json, out=out)


def _one_of(name: str, value: str | None, known: tuple[str | None, ...]) -> None:
    if value not in known:
        words = ", ".join(w for w in known if w is not None)
        raise InputError(f"one of {words}", value, field=name)


def _is_problem(path: Path) -> bool:
    return path.is_file()


def _set(
    store: str,
    spread: Spread,
    options: dict[str, Any],
    *,
    paper: bool,
    json: bool,
    out: Path | None,
    picture: Path | None,
    scene: str | None,
) -> None:
    from demospec.demonstrations import count_rows, read_set, sample_set
    from demospec.rules import learn_rules, rules_document

    with progress_bar() as progress:
        count = count_rows(store)
        if count > LARGE or "://" in store:
            # What many more would add to a clearance is far below a pixel.
            most = SAMPLE if count > LARGE else count
            data = sample_set(
                store, per_type=most, split=options["split"], progress=progress, **spread
            )
            if count > LARGE:
                say(f"note: {count} demonstrations: learned from a random {SAMPLE} of each type")
        else:
            data = read_set(store)
        shown = data.scenes[0] if scene is None else data.scene(scene)
        answer = learn_rules(data, progress=progress, **options, **spread)
    document = rules_document(answer)
    for note in answer.notes:
        say(f"note: {note}")
    if picture is not None:
        from demospec.report import draw_envelopes

        draw_envelopes(data, answer, shown, picture)
        say(f"wrote {picture}")
    save_json(document, out)
    if json:
        print_json(document)
        return
    rows = [
        [name, rule.evidence.get("accepted"), rule.evidence.get("rejected"), rule.sentence]
        for name, rule in answer.rules.items()
    ]
    print_table("Rules", ["type", "accepted", "rejected", "rule"], rows)
    rows = _by_constraint(answer)
    if rows:
        print_table("Constraints", ["type", "constraint", "chance"], rows)
    rows = _by_class(answer)
    if rows:
        # Not in the set's own unit: as the sentence says it.
        header = ["type", "class", "matters", "chance", "clearance (allowed)"]
        print_table("Clearance by class", header, rows)
    rows = [
        [name, rule.evidence["influence"]]
        for name, rule in answer.rules.items()
        if rule.influence is not None
    ]
    if rows and (paper or not any(rule.clearance for rule in answer.rules.values())):
        title = "The paper's rule: distance to centres, and how long (F_max as given)"
        print_table(title, ["type", "rule"], rows)


def _by_class(answer: RuleSet) -> list[list[Any]]:
    """Of every type and class: whether it matters, how probably, and the clearance."""
    from demospec.frames import describe_length

    rows: list[list[Any]] = []
    for name, rule in answer.rules.items():
        if rule.clearance is None:
            continue
        undecided = rule.evidence.get("undecided", ())
        for symbol, probability in rule.evidence.get("probability", {}).items():
            known = symbol not in rule.clearance.uninformed
            word = "not decided" if symbol in undecided else "no"
            length = "–"
            if symbol in rule.clearance.value:
                word = "yes"
                length = describe_length(
                    rule.clearance.value[symbol], answer.metres_per_unit, answer.units,
                    interval=rule.clearance.interval.get(symbol),
                )  # fmt: skip
            chance = "–" if not known else _percent(probability)
            unknown = "see constraints" if symbol in rule.constrained else "not shown"
            rows.append([name, symbol, word if known else unknown, chance, length])
    return rows


def _by_constraint(answer: RuleSet) -> list[list[Any]]:
    """Of every type: what it asks besides clearances, and how probably."""
    return [
        [name, c.sentence, "–" if c.probability is None else _percent(c.probability)]
        for name, rule in answer.rules.items()
        for c in rule.constraints
    ]


def _percent(p: float) -> str:
    """Rounded, but never to certainty."""
    return "> 99 %" if p > 0.99 else "< 1 %" if p < 0.01 else f"{100 * p:.0f} %"


def _enough(
    paths: list[Path],
    settings: dict[str, Any],
    chosen: dict[str, Any],
    *,
    json: bool,
    out: Path | None,
    picture: Path | None,
) -> None:
    """`--enough`: of a set by type (clearance), of a problem by good and bad (influence)."""
    from demospec.rules import enough_problem, enough_set, enough_words, problem_from_document

    if len(paths) != 1:
        raise InputError("one set or one problem", f"{len(paths)} paths", field="--enough")
    path = paths[0]
    document: dict[str, Any]
    if not _is_problem(path):
        from demospec.demonstrations import read_set

        if picture is not None:
            raise InputError("an influence problem to draw", str(path), field="--picture")
        with progress_bar() as progress:
            document = {"types": enough_set(read_set(path), progress=progress, **chosen)}
        rows = [
            [name, n, f"{same:.0%}", width]
            for name, entry in document["types"].items()
            for n, same, width in zip(
                entry["counts"], entry["same_classes"], entry["width"], strict=True
            )
        ]
        title = "Random parts of the demonstrations, answered anew"
        header = ["type", "demonstrations", "same classes as all", "width of the interval"]
        words = ""
    else:
        from demospec.files import read_json

        try:
            content = read_json(path)
            if not isinstance(content, dict) or content.get("family", "influence") != "influence":
                raise InputError("an influence problem, or a set", "another", field="--enough")
            with progress_bar() as progress:
                problem = problem_from_document({**content, **settings})
                document = enough_problem(problem, progress=progress)
        except InputError as error:
            raise error.at(file=path) from error
        width = document["width"]
        rows = [list(row) for row in zip(width["counts"], width["median"], strict=True)]
        title = "Width of the envelope of L"
        header = ["demonstrations", "greatest less least L (median)"]
        words = enough_words(width)
        if picture is not None:
            from demospec.report import draw_transition

            draw_transition(document, picture)
            say(f"wrote {picture}")
    save_json(document, out)
    if json:
        print_json(document)
        return
    print_table(title, header, rows)
    if words:
        show(words)


def _problems(
    paths: list[Path],
    settings: dict[str, Any],
    options: dict[str, Any],
    spread: Spread,
    *,
    json: bool,
    out: Path | None,
) -> None:
    from demospec.parallel import run_tasks
    from demospec.rules import answer_problem

    with progress_bar() as progress:
        answers = run_tasks(
            partial(answer_problem, settings=settings, **options), paths, what="problems",
            progress=progress, **spread,
        )  # fmt: skip
    for path, answer in zip(paths, answers, strict=True):
        for note in answer.notes:
            say(f"warning: {path}: {note}")
    documents = [answer.document for answer in answers]
    document: Any = documents[0] if len(paths) == 1 else documents
    save_json(document, out)
    if json:
        print_json(document)
        return
    for path, answer in zip(paths, answers, strict=True):
        print_table(f"{path.name}: {answer.document['status']}", answer.header, answer.rows)
        for line in answer.sentences:
            show(line)
