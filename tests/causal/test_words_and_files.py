"""Sentences, the JSON document, the table of interventions, the picture, the command."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from demospec.causal import (
    Settings,
    estimate,
    findings_from_document,
    run_trials,
    write_trials,
)
from demospec.cli import main
from demospec.demonstrations import simulate_set, write_set
from demospec.errors import InputError
from demospec.report import save_causal_picture
from demospec.rules import plural, read_rules

QUICK = Settings(placements=2, draws=40)


@pytest.fixture(scope="module")
def table(truth, scenes):  # type: ignore[no-untyped-def]
    return run_trials(truth, scenes[:12], settings=QUICK)


@pytest.fixture(scope="module")
def simulated_folder(tmp_path_factory):  # type: ignore[no-untyped-def]
    data, truth = simulate_set(seed=4, train_scenes=9, test_scenes=1, demonstrations=2)
    return write_set(data, tmp_path_factory.mktemp("sets") / "set", documents={"truth.json": truth})


def test_plurals() -> None:
    words = {"glass": "glasses", "bowl": "bowls", "box": "boxes", "battery": "batteries",
             "tray": "trays", "torch": "torches"}  # fmt: skip
    assert {w: plural(w) for w in words} == words


def test_findings_in_words(table) -> None:  # type: ignore[no-untyped-def]
    said = estimate(table, QUICK).sentences
    kinds = {"utensils", "plates", "bowls", "glasses"}
    assert said[0].startswith("careful avoids every kind of object (")
    assert all(word in said[0] for word in kinds)
    assert "normal looks out for glasses." in said
    assert any(s.startswith("aggressive looks out for nothing: ") for s in said)
    assert sum("accepts less than" in s for s in said) == 3
    assert said[-1].startswith("Moving a patch of bare table changes nothing (at most 0.000")


def test_the_document_has_the_agreed_fields(table) -> None:  # type: ignore[no-untyped-def]
    document = json.loads(json.dumps(estimate(table, QUICK).to_json(), allow_nan=False))
    assert set(document["base"]) == {"careful", "normal", "aggressive"}
    assert {"mean", "interval"} <= document["base"]["careful"].keys()
    agreed = {"type", "symbol", "effect", "interval", "p_corrected", "causal"}
    assert all(agreed <= cell.keys() for cell in document["effects"])
    assert all({"type", "effect", "interval"} <= p.keys() for p in document["placebo"])
    agreed = {"from", "to", "effect", "interval", "p_corrected", "differ"}
    assert all(agreed <= pair.keys() for pair in document["types"])
    assert document["relevant"]["normal"] == ["glass"]


def test_findings_survive_their_document(table, truth, scenes) -> None:  # type: ignore[no-untyped-def]
    settings = replace(QUICK, interventions=("add", "swap"))
    found = estimate(run_trials(truth, scenes[:6], settings=settings), settings)
    document = json.loads(json.dumps(found.to_json()))
    assert findings_from_document(document) == found
    nowhere = estimate(replace(table, trials=()), QUICK)
    again = findings_from_document(json.loads(json.dumps(nowhere.to_json())))
    assert again.to_json() == nowhere.to_json()
    assert np.isnan(again.effects[0].effect)
    with pytest.raises(InputError, match="n_scenes"):
        findings_from_document({k: v for k, v in document.items() if k != "n_scenes"})


def test_the_parquet_table_alone_gives_the_effects(table, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import pyarrow.parquet as pq

    file = tmp_path / "trials.parquet"
    write_trials(table, file)
    rows = pq.read_table(file)
    assert {"scene", "placement", "z_theta_x", "z_theta_y", "type", "symbol", "before",
            "after"} <= set(rows.column_names)  # fmt: skip
    assert len(rows) == sum(t.after.size for t in table.trials)
    scenes: dict[str, dict[int, list[float]]] = defaultdict(lambda: defaultdict(list))
    controls = set()
    for row in rows.to_pylist():
        if (row["intervention"], row["symbol"], row["type"]) == ("add", "glass", "normal"):
            scenes[row["scene"]][row["placement"]].append(row["after"] - row["before"])
        if row["scene"] == table.scene_ids[0]:
            controls.add((row["draw"], row["z_theta_x"], row["z_theta_y"]))
    means = [np.mean([np.mean(v) for v in places.values()]) for places in scenes.values()]
    found = estimate(table, QUICK)
    assert np.mean(means) == pytest.approx(found.effect("normal", "glass").effect)
    assert len(controls) == QUICK.draws  # the same paths for every type, symbol and place


def test_the_picture_is_drawn_whatever_was_found(table, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import PIL.Image

    found = estimate(table, QUICK)
    save_causal_picture(found, tmp_path / "all.png")
    one = estimate(replace(table, types=table.types[:1]), QUICK)
    hollow = replace(one, effects=(), symbols=(), placebo=())
    save_causal_picture(hollow, tmp_path / "hollow.png")
    for name in ("all.png", "hollow.png"):
        with PIL.Image.open(tmp_path / name) as picture:
            assert picture.size[0] > 300
            assert len(set(np.asarray(picture.convert("L")).ravel().tolist())) > 20


def run(capsys, *arguments: str):  # type: ignore[no-untyped-def]
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    captured = capsys.readouterr()
    return stop.value.code, captured.out, captured.err


def test_command_prints_one_document(capsys, simulated_folder, tmp_path) -> None:  # type: ignore[no-untyped-def]
    truth = str(simulated_folder / "truth.json")
    files = [tmp_path / name for name in ("out.json", "trials.parquet", "p.png")]
    status, out, err = run(
        capsys, "causes", truth, str(simulated_folder), "--json", "--placements", "2", "--draws",
        "40", "--out", str(files[0]), "--table", str(files[1]), "--picture", str(files[2]),
    )  # fmt: skip
    assert status == 0
    document = json.loads(out)
    assert document == json.loads(files[0].read_text())
    assert document["n_scenes"] == 10
    assert all(file.stat().st_size > 100 for file in files)
    assert "wrote" in err


def test_command_prints_the_table_for_people(capsys, simulated_folder, tmp_path) -> None:  # type: ignore[no-untyped-def]
    truth, cut = str(simulated_folder / "truth.json"), tmp_path / "cut.json"
    status, out, err = run(
        capsys, "causes", truth, str(simulated_folder), "--placements", "2", "--draws", "40",
        "--interventions", "add,remove", "--split", "train", "--symbols", "glass,bowl",
        "--rules", truth, "--relevant-rules", str(cut),
    )  # fmt: skip
    assert status == 0
    assert "E[p(valid)] over 9 scenes" in out
    for word in ("+ glass", "+ bowl", "placebo", "careful", ")*", "removing a glass"):
        assert word in out
    assert "+ plate" not in out
    assert "model and rules agree on 100 % of 6 cells" in out
    assert "Traceback" not in err
    assert read_rules(cut).rules["normal"].clearance.relevant == ("glass",)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--symbols", "unicorn"], "found unicorn"),
        (["--types", "reckless"], "careful, normal, aggressive"),
        (["--interventions", "burn"], "found burn"),
        (["--catalogue", "attic"], "found attic"),
        (["--minimum-effect", "2"], "minimum"),
        (["--relevant-rules", "cut.json"], "--rules"),
    ],
)
def test_command_refuses_in_one_line(capsys, simulated_folder, arguments, message) -> None:  # type: ignore[no-untyped-def]
    truth = str(simulated_folder / "truth.json")
    status, out, err = run(capsys, "causes", truth, str(simulated_folder), *arguments)
    assert status == 2
    assert out == ""
    assert message in err
    assert len(err.strip().splitlines()) == 1


def test_results_load_no_heavy_library() -> None:
    code = (
        "import sys, demospec.causal as c; "
        "heavy = {'torch', 'scipy', 'skimage', 'matplotlib', 'pyarrow', 'ortools', 'mujoco'}; "
        "print(sorted(heavy & set(sys.modules))); [getattr(c, name) for name in c.__all__]"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
