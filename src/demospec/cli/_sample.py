"""`demospec sample`: varied valid solutions."""

from __future__ import annotations

from typing import Annotated

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
from demospec.cli._plan import Anyway, refuse_unexplained_type


def sample(
    model: ModelPath,
    set_folder: SetFolder,
    scene: Annotated[str, typer.Option("--scene", help="Scene id.")],
    type: Annotated[str, typer.Option("--type", help="Type of user.")],
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
    """Sample varied trajectories that a type of user accepts, on every side of an object."""
    from demospec.demonstrations import read_set
    from demospec.frames import describe_length
    from demospec.specification import load_model, sample_valid

    data = read_set(set_folder)
    fitted = load_model(model, data.types, data)
    refuse_unexplained_type(fitted, type, anyway)
    answer = sample_valid(
        fitted.see(data.scene(scene)), type, n, seed=seed, confidence=confidence, method=method
    )
    document = answer.to_json()
    save_json(document, out)
    if len(answer.control) < n:
        say(f"{type} accepts next to nothing in scene {scene}: {len(answer.control)} of {n} found")
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
