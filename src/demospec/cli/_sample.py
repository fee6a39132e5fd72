"""`demospec sample`: varied valid solutions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import (
    Json,
    ModelPath,
    Out,
    Seed,
    SetFolder,
    print_json,
    print_table,
    save_json,
    say,
)
from demospec.cli._plan import Anyway, refuse_unexplained_type, say_misspelt
from demospec.errors import CannotJudgeError, InputError

if TYPE_CHECKING:
    from demospec.demonstrations import DemonstrationSet, ValidityModel


def sample(
    model: ModelPath,
    set_folder: SetFolder,
    scene: Annotated[str, typer.Option("--scene", help="Scene id.")],
    type: Annotated[str | None, typer.Option("--type", help="Type of user.")] = None,
    types: Annotated[
        str | None,
        typer.Option("--types", help="Several, comma-separated: paths that all of them accept."),
    ] = None,
    n: Annotated[int, typer.Option("--n", min=1, max=100_000, help="Number of trajectories.")] = 10,
    method: Annotated[
        str, typer.Option("--method", help="map (cells of the validity map) or langevin.")
    ] = "map",
    confidence: Annotated[
        float, typer.Option("--confidence", min=0.0, max=0.999, help="p(valid) to exceed.")
    ] = 0.5,
    seed: Seed = 0,
    anyway: Anyway = False,
    json: Json = False,
    out: Out = None,
) -> None:
    """Sample varied trajectories that a type of user accepts, on every side of an object.

    With several types: trajectories that please all of them, and how much of what either of two
    types accepts both accept, in this scene and on average over the scenes of the set.
    """
    from demospec.demonstrations import read_set
    from demospec.frames import describe_length
    from demospec.specification import load_model, overlap_of_types, sample_valid

    data = read_set(set_folder)
    fitted = load_model(model, data.types, data)
    say_misspelt(fitted, data)
    asked = _asked(type, types, fitted.types)
    for name in asked:
        refuse_unexplained_type(fitted, name, anyway)
    view = fitted.see(data.scene(scene))
    answer = sample_valid(
        view, asked[0] if len(asked) == 1 else asked, n,
        seed=seed, confidence=confidence, method=method,
    )  # fmt: skip
    document = answer.to_json()
    if len(asked) > 1:
        document["types"] = list(asked)
        document["overlap"] = {
            "scene": overlap_of_types(view, asked).to_json(),
            "scenes": _over_scenes(fitted, data, asked, seed),
        }
    save_json(document, out)
    if len(answer.control) < n:
        found = f"{len(answer.control)} of {n} found"
        who = asked[0] if len(asked) == 1 else f"everybody of {', '.join(asked)}"
        say(f"next to nothing in scene {scene} is accepted by {who}: {found}")
    if json:
        print_json(document)
    elif out is None:
        rows = [
            [i, float(c[0, 0]), float(c[0, 1]), int(m), float(p)]
            for i, (c, m, p) in enumerate(
                zip(answer.control, answer.mode, answer.p_valid, strict=True)
            )
        ]
        note = (
            f"{answer.modes} region(s) of valid control points, {answer.valid_share:.0%} of the "
            f"plane; two curves differ by "
            f"{describe_length(answer.diversity, data.metres_per_unit, data.units)} on average "
            "(largest gap)."
        )
        header = ("", f"control x, {data.units}", f"control y, {data.units}", "region", "p(valid)")
        print_table("", header, rows, note)
        if len(asked) > 1:
            _print_overlap(document["overlap"], scene)


def _asked(type: str | None, types: str | None, known: Sequence[str]) -> tuple[str, ...]:
    """The types named by either option."""
    if (type is None) == (types is None):
        raise InputError(
            "a type with --type, or several with --types",
            "neither" if type is None else "both",
            field="--type",
        )
    names = (type,) if type is not None else tuple(t.strip() for t in (types or "").split(","))
    for name in names:
        if name not in known:
            field = "--type" if type is not None else "--types"
            raise InputError(f"of the model's types ({', '.join(known)})", name, field=field)
    if types is not None and (len(names) < 2 or len(set(names)) < len(names)):
        raise InputError("at least two different types", types, field="--types")
    return names


MOST_SCENES = 40
"""Scenes over which the overlap is averaged: more would hardly narrow the interval."""


def _over_scenes(
    model: ValidityModel, data: DemonstrationSet, types: tuple[str, ...], seed: int
) -> list[dict[str, Any]]:
    """Mean overlap of every two types over the scenes that can be judged, with its interval."""
    from itertools import combinations

    from demospec.causal import mean_interval
    from demospec.specification import overlap_of_types

    found = []
    for scene in data.scenes[:MOST_SCENES]:
        try:
            found.append(overlap_of_types(model.see(scene), types, size=21))
        except CannotJudgeError:
            continue
    out = []
    for a, b in combinations(types, 2):
        shares = [s for s in (o.share(a, b) for o in found) if s is not None]
        ends = mean_interval(shares, seed=seed, bounds=(0.0, 1.0)) if shares else None
        out.append(
            {
                "types": [a, b],
                "overlap": sum(shares) / len(shares) if shares else None,
                "interval": None if ends is None else list(ends),
                "n_scenes": len(shares),
            }
        )
    return out


def _print_overlap(overlap: dict[str, Any], scene: str) -> None:
    rows = []
    for here, mean in zip(overlap["scene"]["pairs"], overlap["scenes"], strict=True):
        ends, over = mean["interval"], mean["overlap"]
        tail = "" if ends is None else f" [{ends[0]:.0%}, {ends[1]:.0%}]"
        rows.append(
            [
                " and ".join(here["types"]),
                "–" if here["overlap"] is None else f"{here['overlap']:.0%}",
                "–" if over is None else f"{over:.0%}{tail} (n = {mean['n_scenes']})",
            ]
        )
    note = (
        f"Share of what either of the two accepts that both accept; all named accept "
        f"{overlap['scene']['by_all']:.0%} of the plane in scene {scene}. [95 % over scenes]"
    )
    print_table("Overlap", ["types", f"scene {scene}", "mean over scenes"], rows, note)
