"""`demospec predict`: p(valid) of every demonstration of a set."""

from __future__ import annotations

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


def predict(model: ModelPath, set_folder: SetFolder, json: Json = False, out: Out = None) -> None:
    """Judge every demonstration of a set: p(valid) for its type. Never reads the labels.

    A demonstration without type gets one entry for each type of the model. p_valid is null
    where the model cannot judge (a rule on a scene that lists no objects).
    """
    from demospec.demonstrations import read_set
    from demospec.specification import load_model
    from demospec.specification import predict as predict_set

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


def say_unjudged(unjudged: dict[str, str]) -> None:
    """Says on stderr which scenes a model could not judge, and why."""
    if unjudged:
        scenes = list(unjudged)
        some = ", ".join(scenes[:5]) + (", …" if len(scenes) > 5 else "")
        say(f"cannot judge {len(scenes)} scene(s) ({some}): {unjudged[scenes[0]]}")
