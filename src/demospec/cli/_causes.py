"""`demospec causes`: which objects matter to whom."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from demospec.cli._common import (
    Cluster,
    Json,
    ModelPath,
    Out,
    Seed,
    SetFolder,
    Workers,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
    show,
    spelt,
)
from demospec.errors import InputError

if TYPE_CHECKING:
    from demospec.causal import CausalFindings, SymbolEffect
    from demospec.demonstrations import DemonstrationSet

Words = Annotated[str | None, typer.Option(help="Comma-separated; default: all.")]


def causes(
    model: ModelPath,
    set_folder: SetFolder,
    json: Json = False,
    out: Out = None,
    table: Annotated[
        Path | None,
        typer.Option("--table", help="Write one row per path and intervention (Parquet)."),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Draw the effects and the causal graph (PNG).")
    ] = None,
    placements: Annotated[int, typer.Option(min=1, max=1000, help="Places tried per scene.")] = 3,
    draws: Annotated[
        int, typer.Option(min=1, max=100_000, help="Paths (control points z_theta) per scene.")
    ] = 100,
    minimum_effect: Annotated[
        float, typer.Option(min=0, max=1, help="Least change of p(valid) that is called causal.")
    ] = 0.05,
    symbols: Words = None,
    types: Words = None,
    interventions: Annotated[
        str, typer.Option(help="Comma-separated, from add, remove, move and swap.")
    ] = "add",
    split: Annotated[
        Literal["train", "test", "all"], typer.Option(help="Which scenes of the set.")
    ] = "all",
    paths: Annotated[
        Literal["random", "demonstrations"],
        typer.Option(
            help="Random Bezier curves, or the set's own demonstrations (always where the rule "
            "speaks of heights, tilts or times)."
        ),
    ] = "random",
    source: Annotated[
        Literal["auto", "catalogue", "cutouts"],
        typer.Option(help="Where added objects come from."),
    ] = "auto",
    catalogue: Annotated[
        str | None, typer.Option(help="builtin or sweethome3d; default: the set's own.")
    ] = None,
    hide_lists: Annotated[
        bool,
        typer.Option(
            "--hide-lists", help="Hide the object lists: the model sees the changed pictures only."
        ),
    ] = False,
    rules: Annotated[
        str | None,
        typer.Option(help="Compare with these rules: a rule file, or the word learn."),
    ] = None,
    relevant_rules: Annotated[
        Path | None,
        typer.Option(help="Write the rules of --rules without the symbols that have no effect."),
    ] = None,
    outcome: Annotated[
        Literal["probability", "verdict"],
        typer.Option(help="Effects on E[p(valid)], or on the share with p > 0.5."),
    ] = "probability",
    boundaries: Annotated[
        bool,
        typer.Option(
            "--boundaries",
            help="Also how far the boundary of validity moves, by each symbol and between types.",
        ),
    ] = False,
    but_for: Annotated[
        int,
        typer.Option(
            "--but-for",
            min=0,
            help="Also N rejected demonstrations of each type, object by object.",
        ),
    ] = 0,
    workers: Workers = 1,
    cluster: Cluster = None,
    seed: Seed = 0,
) -> None:
    """Estimate which objects cause rejection, by interventions on the scenes.

    A cell is causal (*) where its p-value, corrected over all cells, is below 0.05 and the
    change of p(valid) is at least the minimum effect. The placebo moves bare table and must
    change nothing. Of answers that the model's rule does not explain nothing is claimed.
    """
    from demospec.causal import (
        Settings,
        boundary_effects,
        but_for_rejected,
        causation,
        checked,
        editor_for,
        estimate,
        trials_of_stored,
        write_trials,
    )
    from demospec.demonstrations import pictures_in_memory, read_set
    from demospec.specification import load_model

    if relevant_rules is not None and rules is None:
        raise InputError("--rules beside it: a rule file, or learn", "none", field="--rules")

    settings = Settings(
        placements=placements,
        draws=draws,
        minimum_effect=minimum_effect,
        interventions=tuple(_words(interventions) or ()),  # type: ignore[arg-type]
        seed=seed,
        hide_lists=hide_lists,
        outcome=outcome,
    )
    if cluster is not None:  # its workers may stand in other folders than we do
        model, set_folder = model.resolve(), set_folder.resolve()
    with progress_bar() as progress:
        trials = trials_of_stored(
            partial(load_model, model),
            set_folder,
            symbols=_words(symbols),
            types=_words(types),
            split=split,
            paths=paths,
            settings=settings,
            source=source,
            catalogue=catalogue,
            workers=workers,
            cluster=cluster,
            progress=progress,
        )
    data = read_set(set_folder)
    asked = load_model(model, data.types, data)
    findings = checked(estimate(trials, settings), asked, data.scenes)
    document = findings.to_json()
    if rules is not None:
        from demospec.causal import agreement, rules_of_causes
        from demospec.rules import learn_rules, read_rules, rules_document

        known = learn_rules(data) if rules == "learn" else read_rules(rules)
        document["agreement"] = agreement(findings, known).to_json()
        if relevant_rules is not None:
            save_json(rules_document(rules_of_causes(known, findings)), relevant_rules)
    document["causation"] = [c.to_json() for c in causation(trials)]
    chosen = data if split == "all" else data.of_split(split)
    if boundaries or but_for:
        with progress_bar() as progress:
            if boundaries:
                document["boundaries"] = [
                    e.to_json()
                    for e in boundary_effects(
                        asked, pictures_in_memory(chosen).scenes, findings.symbols, findings.types,
                        seed=seed, hide_lists=hide_lists, progress=progress,
                        editor=editor_for(
                            chosen.scenes, source=source, catalogue=catalogue,
                            metres_per_unit=data.metres_per_unit,
                        ),
                    )
                ]  # fmt: skip
            if but_for:
                rejected = but_for_rejected(
                    asked, chosen, but_for, types=findings.types, progress=progress
                )
                document["but_for"] = [r.to_json() for r in rejected]
    save_json(document, out)
    if table is not None:
        write_trials(trials, table)
        say(f"wrote {table}")
    if picture is not None:
        from demospec.report import save_causal_picture

        save_causal_picture(findings, picture)
        say(f"wrote {picture}")
    for note in findings.notes:
        say(f"note: {note}")
    if json:
        print_json(document)
    else:
        _print(findings)
        if "agreement" in document:
            _print_agreement(document["agreement"])
        if "boundaries" in document:
            _print_boundaries(document["boundaries"], data)
        for case in document.get("but_for", ()):
            show(f"{case['scene_id']}, {case['demo_id']}: {case['sentence']}")


def _print_boundaries(rows: list[dict[str, Any]], data: DemonstrationSet) -> None:
    """How far each symbol, and each other type, moves the boundary of validity."""
    from demospec.frames import describe_length

    cells = []
    for row in rows:
        moved = row["distance"]
        far = "–" if moved is None else describe_length(moved, data.metres_per_unit, data.units)
        what = f"+ {row['symbol']}" if "symbol" in row else f"→ {row['to']}"
        cells.append([row["type"], what, *(_share_of(row, k) for k in ("lost", "gained")), far])
    header = ["type", "intervention", "lost", "gained", "boundary moves"]
    note = "Shares of the plane of control points, [95 % interval over scenes]."
    print_table("Boundary of validity", header, cells, note)


def _share_of(row: dict[str, Any], key: str) -> str:
    ends = row[f"{key}_interval"]
    tail = "" if ends is None else f" [{ends[0]:.3f}, {ends[1]:.3f}]"
    return f"{row[key]:.3f}{tail}"


def _words(text: str | None) -> list[str] | None:
    return None if text is None else [w.strip() for w in text.split(",") if w.strip()]


def _print(findings: CausalFindings) -> None:
    """The paper's table: E[p(valid)] as is, after adding each symbol, after the placebo."""
    import sys

    from rich import box
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, width=None if sys.stdout.isatty() else 140)
    grid = Table(
        title=spelt(f"{_what(findings)} over {findings.n_scenes} scenes, and its change"),
        box=box.SIMPLE_HEAD,
        title_justify="left",
    )
    shown = [s for s in findings.symbols if any(c.symbol == s for c in findings.effects)]
    for name in ("type", "base", *(f"+ {s}" for s in shown), "placebo"):
        grid.add_column(spelt(name), justify="left" if name == "type" else "right")
    for type_ in findings.types:
        row = [spelt(type_), spelt(f"{findings.base[type_].mean:.2f}")]
        row += [_cell(findings.effect(type_, symbol)) for symbol in shown]
        patch = next(p for p in findings.placebo if p.type == type_)
        row.append(spelt(f"{patch.effect:+.3f}" + ("" if patch.null else " !")))
        grid.add_row(*row)
    console.print(grid)
    for cell in findings.others:
        if cell.causal:
            console.print(spelt(_other(cell)))
    for sentence in findings.sentences:
        console.print(spelt(sentence))
    least = findings.settings.minimum_effect
    console.print(
        spelt(
            f"* causal: corrected p < {findings.settings.significance:g} and a change of at "
            f"least {least:g}. [low, high]: 95 % interval of the change, over scenes."
            if findings.settings.level == 0.95
            else f"* causal: corrected p < {findings.settings.significance:g}, change ≥ {least:g}."
        )
    )


def _print_agreement(document: dict[str, Any]) -> None:
    """Model against rules: the score and every disagreement."""
    if document["score"] is None:
        show("model and rules: nothing to compare")
    else:
        share = f"{100 * document['score']:.0f} % of {document['n_cells']} cells"
        show(f"model and rules agree on {share}")
    for cell in document["disagreements"]:
        show(f"  {cell['type']}/{cell['symbol']}: {cell['why']}")
    for line in document["open"]:
        show(f"  not compared: {line}")


def _what(findings: CausalFindings) -> str:
    whole = findings.settings.outcome == "probability"
    return "E[p(valid)]" if whole else "Share of paths judged valid"


def _cell(cell: SymbolEffect) -> Any:
    from rich.text import Text

    if cell.n_scenes == 0:
        return Text("no room")
    text = Text(f"{cell.after:.2f} ({cell.effect:+.2f})", style="bold" if cell.causal else "")
    text.append("*" if cell.causal else " ")
    if cell.interval is not None:
        text.append(f"\n[{cell.interval[0]:+.2f}, {cell.interval[1]:+.2f}]", style="dim")
    return text


def _other(cell: SymbolEffect) -> str:
    verb = {"remove": "removing", "move": "moving", "swap": "replacing"}[cell.intervention]
    more = f" by a {cell.onto}" if cell.onto else ""
    return (
        f"{cell.type}: {verb} a {cell.symbol}{more} changes E[p(valid)] by {cell.effect:+.2f} "
        f"({cell.n_scenes} scenes)."
    )
