"""`demospec scenes`: what a model saw, and new scenes like those of a set."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from demospec.cli._common import (
    Force,
    Json,
    ModelPath,
    OutFolder,
    Seed,
    SetFolder,
    print_json,
    print_table,
    progress_bar,
    say,
)


def scenes(
    model: ModelPath,
    set_folder: SetFolder,
    out: OutFolder,
    scene: Annotated[
        list[str] | None,
        typer.Option("--scene", help="Scene id; may be repeated. Default: all."),
    ] = None,
    sample: Annotated[
        int | None,
        typer.Option("--sample", min=1, max=10_000, help="Number of new scenes to sample instead."),
    ] = None,
    seed: Seed = 0,
    force: Force = False,
    json: Json = False,
) -> None:
    """Reconstruct scenes from the latent code of a model, or sample new ones.

    Without --sample: the pictures after encoder and decoder, and scenes.json with their errors.
    With --sample: a demonstration set whose scenes resemble the training scenes of SET.
    """
    from demospec.demonstrations import read_set, write_set
    from demospec.errors import InputError
    from demospec.files import check_free_folder
    from demospec.specification import load_model, reconstruct_scenes, set_of_sampled_scenes

    data = read_set(set_folder)
    fitted = load_model(model)
    check_free_folder(out, replace=force)
    if sample is not None:
        if scene:
            raise InputError("no scene where new ones are drawn", scene[0], field="--scene")
        made = set_of_sampled_scenes(fitted, data, sample, seed=seed)
        write_set(made, out, replace_existing=force)
        say(f"wrote {out}")
        rows = [[s.scene_id, None if s.objects is None else len(s.objects)] for s in made.scenes]
        if json:
            print_json({"scenes": [{"scene_id": a, "things": b} for a, b in rows]})
        else:
            print_table(f"{made.name}: {len(rows)} scenes", ("scene", "things"), rows)
        return
    chosen = [data.scene(name) for name in scene] if scene else list(data.scenes)
    with progress_bar() as progress:
        found = reconstruct_scenes(fitted, chosen, progress=progress)
    document: dict[str, Any] = {
        "scenes": [{**r.to_json(), "file_name": f"{i:04d}.png"} for i, r in enumerate(found)]
    }
    _write(out, [r.picture for r in found], document, force)
    say(f"wrote {out}")
    if json:
        print_json(document)
    else:
        shown = [[r.scene_id, r.rmse, r.psnr_db, r.numbers, r.things] for r in found]
        header = ("scene", "error (1 = white)", "PSNR dB", "numbers", "things")
        print_table(f"{data.name}: {len(shown)} scenes, reconstructed", header, shown)


def _write(out: Path, pictures: list[Any], document: dict[str, Any], force: bool) -> None:
    import PIL.Image

    from demospec.files import to_json, writing_folder

    with writing_folder(out, replace=force) as root:
        for i, picture in enumerate(pictures):
            PIL.Image.fromarray(picture).save(root / f"{i:04d}.png")
        (root / "scenes.json").write_text(to_json(document) + "\n", encoding="utf-8")
