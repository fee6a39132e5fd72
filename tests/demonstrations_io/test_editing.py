"""Editing is copying: new sets with a record, inputs byte-identical, nothing half-written."""

from __future__ import annotations

import errno
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_sets import digest

from demospec.cli import main
from demospec.demonstrations import (
    DemonstrationSet,
    check_set,
    edit,
    read_set,
    simulate_set,
    write_set,
)
from demospec.errors import InputError, OutputError
from demospec.scene import Picture
from demospec.testing import small_set, write_small_set

OPERATIONS: dict[str, list[str]] = {
    "split": ["--test-share", "0.5"],
    "relabel": ["--flip", "d0", "--valid", "d3", "--invalid", "d1"],
    "drop": ["--demonstration", "d0", "--type", "normal"],
    "crop": ["--box", "5,5,90,95"],
    "rescale": ["--factor", "0.5"],
    "trim": [],
}


@pytest.mark.parametrize("operation", list(OPERATIONS))
def test_operations_leave_the_input_alone_and_record_themselves(
    operation: str, tmp_path: Path
) -> None:
    root = write_small_set(tmp_path / "set", 8, t=True)
    (root / "truth.json").write_text('{"types": {}}')
    before = digest(root)
    out = tmp_path / "out"
    with pytest.raises(SystemExit) as stop:
        main(["edit", operation, str(root), *OPERATIONS[operation], "--out", str(out)])
    assert stop.value.code == 0
    assert digest(root) == before
    made = [out / "train", out / "test"] if operation == "split" else [out]
    for folder in made:
        assert check_set(folder).readable
        record = json.loads((folder / "provenance.json").read_text())
        assert record["operation"] == operation
        assert record["inputs"][0]["name"] == "set"
        assert len(record["inputs"][0]["sha256"]["demonstrations.parquet"]) == 64
        assert (folder / "truth.json").exists() == (operation != "rescale")
    with pytest.raises(SystemExit) as stop:
        main(["edit", operation, str(root), *OPERATIONS[operation], "--out", str(out)])
    assert stop.value.code == 2  # the output exists


def test_records_chain(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "a")
    data = read_set(root)
    edit.write_edited(data, tmp_path / "b", operation="trim", arguments={}, inputs=[root])
    edit.write_edited(data, tmp_path / "c", operation="drop", arguments={}, inputs=[tmp_path / "b"])
    record = json.loads((tmp_path / "c" / "provenance.json").read_text())
    assert record["inputs"][0]["provenance"]["operation"] == "trim"


def test_merge_joins_equal_scenes_and_renames_clashes() -> None:
    a, b = small_set(4), small_set(4)
    same = edit.merge([a, b], ["a", "b"])
    assert [s.scene_id for s in same.scenes] == ["s0", "s1"]
    assert sorted(same.demonstrations.demo_id)[:4] == ["b-d0", "b-d1", "b-d2", "b-d3"]
    moved = replace(b, scenes=(replace(b.scenes[0], start=(0.0, 0.0)), b.scenes[1]))
    both = edit.merge([a, moved], ["a", "b"])
    assert [s.scene_id for s in both.scenes] == ["s0", "s1", "b-s0"]
    assert list(both.demonstrations.scene_id[4:]) == ["b-s0", "s1", "b-s0", "s1"]
    assert edit.merge([a]) == a
    with pytest.raises(InputError, match="metres_per_unit"):
        edit.merge([a, replace(b, metres_per_unit=0.1)])


def test_merge_then_split_gives_the_parts_back() -> None:
    data = small_set(8)
    parts = edit.split(data, 0.5, seed=3)
    assert set(parts) == {"train", "test"}
    again = edit.merge([parts["train"], parts["test"]])
    assert sorted(again.demonstrations.demo_id) == sorted(data.demonstrations.demo_id)
    assert {s.scene_id for s in parts["train"].scenes} & {
        s.scene_id for s in parts["test"].scenes
    } == set()
    assert edit.split(data, 0.5, seed=3).keys() == parts.keys()
    with pytest.raises(InputError):
        edit.split(data, 0.01)


def test_relabel_flips_and_refuses_unknown_names() -> None:
    data = small_set()
    flipped = edit.relabel(data, {"d0": {"valid": "flip"}, "d1": {"valid": None, "type": "new"}})
    assert flipped.demonstrations.valid.tolist() == [1, -1, 1, 0, 1, 1]
    assert data.demonstrations.valid.tolist() == [0, 1, 1, 0, 1, 1]
    assert flipped.types == ("careful", "normal", "new")
    twice = edit.relabel(edit.relabel(data, {"d0": {"valid": "flip"}}), {"d0": {"valid": "flip"}})
    assert twice == data
    with pytest.raises(InputError, match="d99"):
        edit.relabel(data, {"d99": {"valid": True}})


def _audit(path: Path, *entries: dict[str, Any]) -> Path:
    path.write_text(json.dumps({"demonstrations": [{"verdict": "review", **e} for e in entries]}))
    return path


def _relabelled(root: Path, *options: str) -> int:
    with pytest.raises(SystemExit) as stop:
        main(["edit", "relabel", str(root), "--out", str(root.parent / "out"), *options])
    return int(stop.value.code or 0)


def test_an_audit_changes_at_most_a_fifth_of_a_type_unasked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_small_set(tmp_path / "set")
    audit = _audit(tmp_path / "a.json", {"demo_id": "d0"}, {"demo_id": "d1"}, {"demo_id": "d2"})
    assert _relabelled(root, "--audit", str(audit)) == 2
    assert "20%" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert _relabelled(root, "--audit", str(audit), "--ids", "d1") == 0
    record = json.loads((tmp_path / "out" / "provenance.json").read_text())
    assert record["arguments"]["by_audit"] == ["d1"]
    labels = read_set(tmp_path / "out").demonstrations.valid.tolist()
    assert labels == [0, 0, 1, 0, 1, 1]
    assert _relabelled(root, "--audit", str(audit), "--anyway", "--force") == 0
    assert read_set(tmp_path / "out").demonstrations.valid.tolist() == [1, 0, 0, 0, 1, 1]


@pytest.mark.parametrize(
    "entry",
    [{"demo_id": "d9"}, {"demo_id": 3}, {"demo_id": "d0", "scene_id": "elsewhere"},
     {"demo_id": "d0", "type": "another"}, {"demo_id": "d0", "valid": True}],
)  # fmt: skip
def test_an_audit_of_another_set_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], entry: dict[str, Any]
) -> None:
    root = write_small_set(tmp_path / "set")
    audit = _audit(tmp_path / "a.json", entry)
    assert _relabelled(root, "--audit", str(audit), "--anyway") == 2
    assert "a.json" in capsys.readouterr().err


def test_ids_need_an_audit_that_doubts_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = write_small_set(tmp_path / "set")
    audit = _audit(tmp_path / "a.json", {"demo_id": "d0"})
    assert _relabelled(root, "--audit", str(audit), "--ids", "d1") == 2
    assert _relabelled(root, "--ids", "d1") == 2
    assert "--ids" in capsys.readouterr().err


def test_labels_from_a_table(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set")
    (tmp_path / "labels.csv").write_text("demo_id,valid\nd0,yes\nd1,\nd2,rejected\n")
    with pytest.raises(SystemExit) as stop:
        main(["edit", "relabel", str(root), "--labels", str(tmp_path / "labels.csv"),
              "--out", str(tmp_path / "out")])  # fmt: skip
    assert stop.value.code == 0
    labels = read_set(tmp_path / "out").demonstrations.valid.tolist()
    assert labels == [1, -1, 0, 0, 1, 1]


def test_drop_by_scene_type_label_and_repetition() -> None:
    data = small_set()
    assert len(edit.drop(data, scenes=["s0"]).scenes) == 1
    assert edit.drop(data, types=["normal"]).types == ("careful",)
    double = edit.merge([data, data])
    assert len(edit.drop(double, duplicates=True).demonstrations) == 6
    with pytest.raises(InputError, match="stays"):
        edit.drop(data, types=["careful", "normal"])


@pytest.mark.parametrize("factor", [0.5, 2.0, 3.0])
def test_rescaling_keeps_metres(factor: float) -> None:
    data = replace(small_set(), metres_per_unit=0.008)
    scaled = edit.rescale(data, factor)
    assert scaled.metres_per_unit == pytest.approx(0.008 / factor)
    np.testing.assert_allclose(scaled.demonstrations.flat, data.demonstrations.flat * factor)
    assert scaled.scenes[0].size_px == (100 * factor, 100 * factor)
    there = data.scenes[0].listed_objects()[0].outline.signed_distance([[10.0, 20.0]])
    here = (
        scaled.scenes[0].listed_objects()[0].outline.signed_distance([[10 * factor, 20 * factor]])
    )
    np.testing.assert_allclose(here, there * factor)


def test_cropping_moves_everything_together() -> None:
    data = small_set()
    cut = edit.crop(data, (30, 35, 40, 50))
    np.testing.assert_allclose(
        cut.demonstrations.flat + np.array([30, 35]), data.demonstrations.flat
    )
    assert cut.scenes[0].size_px == (40, 50)
    assert cut.scenes[0].listed_objects()[0].center == (20.0, 15.0)
    assert edit.crop(data, (0, 57, 100, 43)).scenes[0].objects == ()  # an empty table
    with pytest.raises(InputError, match="within one picture width"):
        edit.crop(data, (40, 40, 10, 10))
    with pytest.raises(InputError, match="inside the picture"):
        edit.crop(data, (50, 50, 60, 10))


def test_trimming_removes_rests_only() -> None:
    data = small_set(2, t=True)
    d = data.demonstrations
    still = np.concatenate([np.repeat(d.points(0)[:1], 4, axis=0), d.points(0)])
    rests = edit.joined([
        replace_points(d[:1], np.concatenate([still, still[-1:]])), d[1:],
    ])  # fmt: skip
    trimmed = edit.trim(replace(data, demonstrations=rests))
    np.testing.assert_array_equal(trimmed.demonstrations.points(0), d.points(0))
    np.testing.assert_array_equal(trimmed.demonstrations.points(1), d.points(1))


def replace_points(part: Any, points: np.ndarray) -> Any:
    from demospec.demonstrations import Demonstrations

    return Demonstrations(
        demo_id=part.demo_id, scene_id=part.scene_id, type=part.type,
        demonstrator=part.demonstrator, valid=part.valid, flat=points,
        offsets=np.array([0, len(points)]), t=np.arange(len(points)) / 10,
    )  # fmt: skip


def test_the_output_may_not_be_the_input(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set")
    before = digest(root)
    for out in (root, root / "new", tmp_path):
        with pytest.raises(SystemExit) as stop:
            main(["edit", "trim", str(root), "--out", str(out), "--force"])
        assert stop.value.code == 2
    assert digest(root) == before


def fails_at(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk is full at the n-th file that is written."""
    import pyarrow.parquet as pq

    count = 0

    def guarded(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*a: Any, **k: Any) -> Any:
            nonlocal count
            count += 1
            if count == n:
                raise OSError(errno.ENOSPC, "No space left on device")
            return function(*a, **k)

        return call

    monkeypatch.setattr(Path, "write_text", guarded(Path.write_text))
    monkeypatch.setattr(Path, "write_bytes", guarded(Path.write_bytes))
    monkeypatch.setattr(pq, "write_table", guarded(pq.write_table))


@pytest.mark.parametrize("n", [1, 2, 3, 4])
@pytest.mark.parametrize("replacing", [False, True])
def test_a_full_disk_leaves_what_was_there(
    n: int, replacing: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "out"
    data: DemonstrationSet = read_set(write_small_set(tmp_path / "in"))
    if replacing:
        write_small_set(target, 3)
    before = {p.name for p in tmp_path.iterdir()}
    content = digest(target) if replacing else None
    fails_at(n, monkeypatch)
    with pytest.raises(OutputError, match="No space left"):
        write_set(data, target, replace_existing=replacing)
    assert {p.name for p in tmp_path.iterdir()} == before
    if replacing:
        assert digest(target) == content


def test_a_really_full_disk(tmp_path: Path) -> None:
    import os
    import subprocess

    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("mounting a small disk needs root")
    try:
        (disk / "filling").write_bytes(b"x" * 50_000)
        with pytest.raises(OutputError, match="No space left"):
            write_set(small_set(200), disk / "out")
        assert [p.name for p in disk.iterdir()] == ["filling"]
    finally:
        subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.parametrize("factor", [0.64, 0.4])
def test_rescaling_a_picture_moves_nothing_in_it(factor: float) -> None:
    """A disc's centre goes where the set says, to a twentieth of a pixel (a box filter: 0.1)."""
    axis = np.arange(100) + 0.5
    for x, y in ((31.7, 42.2), (60.4, 55.9), (48.1, 47.6)):
        inside = np.clip(9.5 - np.hypot(*np.meshgrid(axis - x, axis - y)), 0.0, 1.0)
        pixels = np.repeat(np.asarray(inside * 255 + 0.5, np.uint8)[..., None], 3, axis=2)
        data = small_set()
        shown = replace(data.scenes[0], picture=Picture(array=pixels))
        data = replace(data, scenes=(shown, *data.scenes[1:]))
        small = edit.rescale(data, factor).scenes[0].pixels().mean(axis=2)
        at = np.arange(len(small)) + 0.5
        found = np.array([small.sum(axis=0) @ at, small.sum(axis=1) @ at]) / small.sum()
        assert np.abs(found - np.array([x, y]) * factor).max() < 0.05


def test_a_picture_that_was_cut_or_resized_has_no_recipe_of_another_size(tmp_path: Path) -> None:
    data, _ = simulate_set(train_scenes=1, test_scenes=0, demonstrations=2)
    write_set(data, tmp_path / "set")
    scene = read_set(tmp_path / "set").scenes[0]
    assert scene.recipe is not None
    assert scene.recipe == data.scenes[0].recipe
    assert edit.crop(data, (5, 5, 90, 90)).scenes[0].recipe is None
    half = edit.rescale(data, 0.5)
    assert half.scenes[0].recipe is None
    write_set(half, tmp_path / "half")
    assert "render" not in (tmp_path / "half" / "scenes" / "metadata.jsonl").read_text()


def test_a_spoilt_recipe_is_named_with_its_row(tmp_path: Path) -> None:
    data, _ = simulate_set(train_scenes=2, test_scenes=0, demonstrations=2)
    write_set(data, tmp_path / "set")
    file = tmp_path / "set" / "scenes" / "metadata.jsonl"
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    lines[0]["render"] = "by hand"  # somebody else's word: kept as it came
    lines[1]["render"]["light"]["azimuth"] = "left"
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with pytest.raises(
        InputError, match=r"row 1.*render\.light\.azimuth: expected a finite number"
    ):
        read_set(tmp_path / "set")
    lines[1]["render"]["light"]["azimuth"] = 0
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    first, second = read_set(tmp_path / "set").scenes
    assert (first.recipe, dict(first.extra)) == (None, {"render": "by hand"})
    assert second.recipe is not None
    assert second.recipe.light.azimuth == 0
