"""Detection: objects in the set format, symbols as a set names them, sets that stay as they are."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, read_set, simulate_set, write_set
from demospec.errors import CannotJudgeError
from demospec.perception import KINDS, detect_in_set, detect_objects, fit_symbol_head
from demospec.rules import learn_rules


@pytest.fixture(scope="module")
def simulated() -> DemonstrationSet:
    return simulate_set(train_scenes=8, test_scenes=4, demonstrations=6, seed=41)[0]


@pytest.fixture(scope="module")
def folder(simulated: DemonstrationSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(simulated, tmp_path_factory.mktemp("sets") / "S")


def digest(folder: Path) -> str:
    files = sorted(p for p in folder.rglob("*") if p.is_file())
    return hashlib.sha256(b"".join(p.read_bytes() for p in files)).hexdigest()


def run(*arguments: object) -> int:
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    return int(stop.value.code or 0)


def test_objects_of_unseen_items_are_found_where_they_are(simulated: DemonstrationSet) -> None:
    """Guard: most things found, few imagined; the benchmark measures how many."""
    head = fit_symbol_head(simulated.of_split("train").scenes)
    listed = found = imagined = 0
    for scene in simulated.of_split("test").scenes:
        assert scene.objects is not None
        centres = [thing.center for thing in detect_objects(scene, head=head)]
        for item in scene.objects:
            listed += 1
            low_x, low_y, high_x, high_y = item.outline.bounds
            middle = np.array([(low_x + high_x) / 2, (low_y + high_y) / 2])
            found += any(np.hypot(*(middle - c)) < 4 for c in centres)
        imagined += max(0, len(centres) - len(scene.objects))
    assert found >= 0.8 * listed
    assert imagined <= 0.25 * listed


def test_generic_words_without_a_head(simulated: DemonstrationSet) -> None:
    things = detect_objects(simulated.scenes[0])
    assert things
    assert {thing.symbol for thing in things} <= set(KINDS)
    assert len({thing.id for thing in things}) == len(things)
    assert all(0.5 <= thing.confidence < 1 for thing in things)


def test_a_head_names_things_as_the_set_does(simulated: DemonstrationSet) -> None:
    head = fit_symbol_head(simulated.of_split("train").scenes)
    assert head is not None
    things = [t for s in simulated.of_split("test").scenes for t in detect_objects(s, head=head)]
    assert {thing.symbol for thing in things} <= set(simulated.symbols)
    # Confidence is that of the symbol: it cannot exceed that something is there.
    assert all(0 < thing.confidence <= 1 for thing in things)


def test_no_head_from_scenes_that_list_nothing(simulated: DemonstrationSet) -> None:
    assert fit_symbol_head([replace(s, objects=None) for s in simulated.scenes[:2]]) is None


def test_rules_are_learned_from_pictures_alone(simulated: DemonstrationSet) -> None:
    """The lists of the judged scenes are taken away; another part of the set names symbols."""
    train = simulated.of_split("train")
    head = fit_symbol_head(train.scenes)
    blind = replace(train, scenes=tuple(replace(s, objects=None) for s in train.scenes))
    seen, skipped = detect_in_set(blind, head=head)
    assert skipped == ()
    assert all(s.recipe is None for s in seen.scenes)
    assert "glass" in learn_rules(seen).rules["careful"].clearance.value


def test_a_set_becomes_a_new_set(folder: Path, tmp_path: Path) -> None:
    before = digest(folder)
    out = tmp_path / "seen"
    assert (
        run("detect", folder, "--set", folder, "--out", out, "--overlay", tmp_path / "o.png") == 0
    )
    assert digest(folder) == before
    old, new = read_set(folder), read_set(out)
    assert [s.scene_id for s in new.scenes] == [s.scene_id for s in old.scenes]
    assert len(new.demonstrations) == len(old.demonstrations)
    assert all(
        (a.pixels() == b.pixels()).all() for a, b in zip(old.scenes, new.scenes, strict=True)
    )
    line = json.loads((out / "scenes" / "metadata.jsonl").read_text().splitlines()[0])
    assert 0 < line["objects"][0]["confidence"] <= 1
    with PIL.Image.open(tmp_path / "o.png") as drawn:
        assert drawn.size[0] > 300
    assert run("check", out) == 0


def test_a_picture_becomes_a_list(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        run("detect", folder / "scenes" / "0000.png", "--json", "--out", tmp_path / "o.json") == 0
    )
    document = json.loads(capsys.readouterr().out)
    assert document == json.loads((tmp_path / "o.json").read_text())
    assert document["size_px"] == [100, 100]
    for item in document["objects"]:
        assert {"id", "symbol", "center", "bbox", "polygon", "confidence"} <= set(item)


def test_scenes_without_pictures_keep_their_lists(simulated: DemonstrationSet) -> None:
    first, *others = simulated.scenes[:3]
    bare = replace(first, picture=None)
    ids = {s.scene_id for s in (first, *others)}
    rows = np.array([s in ids for s in simulated.demonstrations.scene_id])
    few = replace(
        simulated, scenes=(bare, *others), demonstrations=simulated.demonstrations.rows(rows)
    )
    seen, skipped = detect_in_set(few)
    assert skipped == (first.scene_id,)
    assert seen.scenes[0] == bare
    with pytest.raises(CannotJudgeError):
        detect_in_set(replace(few, scenes=tuple(replace(s, picture=None) for s in few.scenes)))


@pytest.mark.parametrize(
    "case", ["absent", "text", "folder", "unlisted", "scene", "taken", "weights"]
)
def test_bad_input_is_one_line(
    case: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = folder / "scenes" / "0000.png"
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "file").write_text("here")
    arguments = {
        "absent": [tmp_path / "absent.png"],
        "text": [tmp_path / "text.png"],
        "folder": [tmp_path],
        "unlisted": [picture, "--set", tmp_path],
        "scene": [folder, "--scene", "no-such", "--overlay", tmp_path / "o.png"],
        "taken": [folder, "--out", tmp_path / "taken"],
        "weights": [picture, "--network", tmp_path / "text.png"],
    }[case]
    assert run("detect", *arguments) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not (tmp_path / "o.png").exists()
