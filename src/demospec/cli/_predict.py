"""`demospec predict`: p(valid) of every demonstration of a set."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from demospec.cli._common import (
    Json,
    ModelPath,
    Out,
    SetFolder,
    print_json,
    print_table,
    progress_bar,
    save_json,
    say,
)

if TYPE_CHECKING:
    from demospec.progress import Progress

LARGE = 100_000
"""Sets of more demonstrations are judged batch by batch."""


def predict(model: ModelPath, set_folder: SetFolder, json: Json = False, out: Out = None) -> None:
    """Judge every demonstration of a set: p(valid) for its type. Never reads the labels.

    A demonstration without type gets one entry for each type of the model. p_valid is null
    where the model cannot judge (a rule on a scene that lists no objects).
    """
    from demospec.demonstrations import count_rows, read_set
    from demospec.specification import load_model
    from demospec.specification import predict as predict_set

    if (json or out is not None) and count_rows(set_folder) > LARGE:
        _in_batches(model, set_folder, json=json, out=out)
        return
    data = read_set(set_folder)
    fitted = load_model(model)
    with progress_bar() as progress:
        answer = predict_set(fitted, data, progress=progress)
    say_unjudged(answer.unjudged)
    if answer.unknown_types:
        say(f"p_valid is null for types the model does not know: {', '.join(answer.unknown_types)}")
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
    elif out is None:
        rows = [[p.demo_id, p.scene_id, p.type, p.p_valid] for p in answer.items]
        print_table("", ("demonstration", "scene", "type", "p(valid)"), rows)


def _in_batches(model: Path, set_folder: Path, *, json: bool, out: Path | None) -> None:
    """The same document for a set that need not fit into memory, written as it comes."""
    from demospec.files import writing_file
    from demospec.specification import load_model

    fitted = load_model(model)
    with progress_bar() as progress:
        if out is None:
            _stream(sys.stdout, fitted, set_folder, progress)
            return
        with writing_file(out) as temporary, open(temporary, "w", encoding="utf-8") as file:
            _stream(file, fitted, set_folder, progress)
    say(f"wrote {out}")
    if json:
        with open(out, encoding="utf-8") as file:
            shutil.copyfileobj(file, sys.stdout)


def _stream(file: TextIO, model: Any, set_folder: Path, progress: Progress) -> None:
    from json import dumps

    from demospec.specification import predict_batches

    file.write('{"predictions": [')
    between = "\n"
    unjudged: dict[str, str] = {}
    unknown: dict[str, None] = {}
    for part in predict_batches(model, set_folder, progress=progress):
        for entry in part.to_json()["predictions"]:
            file.write(between + dumps(entry, ensure_ascii=False, allow_nan=False))
            between = ",\n"
        unjudged |= part.unjudged
        unknown |= dict.fromkeys(part.unknown_types)
    file.write("\n]}\n")
    say_unjudged(unjudged)
    if unknown:
        say(f"p_valid is null for types the model does not know: {', '.join(unknown)}")


def say_unjudged(unjudged: dict[str, str]) -> None:
    """Says on stderr which scenes a model could not judge, and why."""
    if unjudged:
        scenes = list(unjudged)
        some = ", ".join(scenes[:5]) + (", …" if len(scenes) > 5 else "")
        say(f"cannot judge {len(scenes)} scene(s) ({some}): {unjudged[scenes[0]]}")
