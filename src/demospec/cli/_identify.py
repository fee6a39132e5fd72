"""`demospec identify`: whose demonstrations are these?"""

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


def identify(model: ModelPath, set_folder: SetFolder, json: Json = False, out: Out = None) -> None:
    """Identify the type of user of every demonstrator, without reading the types.

    Demonstrations without a demonstrator are taken together. The answer is "none of these" where
    no type of the model explains the paths.
    """
    from demospec.cli._predict import say_unjudged
    from demospec.demonstrations import read_set
    from demospec.specification import identify as identify_set
    from demospec.specification import load_model

    data = read_set(set_folder)
    with progress_bar() as progress:
        answer = identify_set(load_model(model, data=data), data, progress=progress)
    say_unjudged(answer.unjudged)
    unnamed = [d for d in answer.demonstrators if d.demonstrator is None]
    if unnamed:
        say(f"{unnamed[0].n} demonstrations name no demonstrator: judged together, as one")
    document = answer.to_json()
    save_json(document, out)
    if json:
        print_json(document)
    elif out is None:
        types = list(answer.demonstrators[0].posterior)
        rows = [
            [
                d.demonstrator or "(unnamed)",
                d.n,
                d.type or f"none of these (nearest: {d.nearest})",
                *[d.posterior[t] for t in types],
            ]
            for d in answer.demonstrators
        ]
        print_table("", ["demonstrator", "n", "type", *[f"p({t})" for t in types]], rows)
