"""Damage that keeps a file readable gives the same data or a refusal, never other data."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from damage import Change, changes
from drawn_story import (
    HEIGHT,
    WIDTH,
    Write,
    coco_changes,
    cvat_changes,
    label_studio_changes,
    other_drawing,
)
from listed_story import listed_changes
from stored_story import Write as WriteSource
from stored_story import hdf5_changes, lerobot_changes, mcap_changes
from story import WRITERS, Source, other_data, story

from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import DemospecError

Case = tuple[str, str, Change]
"""Reader, what is done, and the change."""


def cases() -> list[Case]:
    """All that can be done to all the formats, but for what a format has no place for."""
    out = []
    for kind in WRITERS:
        words = kind in ("long table", "tables", "json lists", "json steps")
        for what, change in changes(story()[0], words):
            axis = what.startswith(("x ", "y ", "z ", "all axes", "columns"))
            if kind == "hdf5" and axis:  # its positions are one dataset without names
                continue
            if kind == "mcap" and what.startswith("time"):  # its clock is in nanoseconds
                continue
            out.append((kind, what, change))
    return out


CASES = cases()


def skip_without(kind: str) -> None:
    """Skips the test where the library that writes the format is not installed."""
    if kind == "hdf5":
        pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    if kind == "mcap":
        pytest.importorskip("mcap", reason="pip install 'demospec[ros]'")
        pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")


def outcome(folder: Path, kind: str, change: Change | None) -> str:
    """``same``, ``refused`` or how the data differs."""
    skip_without(kind)
    tables = story()
    try:
        source = WRITERS[kind](folder, tables if change is None else change(tables))
    except (ValueError, TypeError, KeyError, OSError, RuntimeError):  # the format cannot hold it
        return "not written"
    return judged(source, kind)


def judged(source: Source, kind: str) -> str:
    """What reading a source comes to."""
    try:
        result = read_source(source.path, mapping=Mapping.model_validate(source.how))
    except DemospecError as error:
        if "\n" in str(error):
            return f"a refusal of several lines: {error}"
        if "units" not in source.how or "the unit that the columns state" not in str(error):
            return "refused"
        if "(px)" in str(error):
            return "refused"
        # The file says its own unit: then it is not said again.
        how = {k: v for k, v in source.how.items() if k != "units"}
        return judged(Source(source.path, how), kind)
    return other_data(result.data, result.notes, story()) or "same"


@pytest.mark.parametrize("kind", list(WRITERS))
def test_the_story_itself_is_read(tmp_path: Path, kind: str) -> None:
    assert outcome(tmp_path, kind, None) == "same"


def run(tmp_path: Path, chosen: list[tuple[str, str, Change]]) -> dict[str, int]:
    counts = {"same": 0, "refused": 0, "not written": 0}
    wrong = []
    for i, (kind, what, change) in enumerate(chosen):
        folder = tmp_path / str(i)
        folder.mkdir()
        found = outcome(folder, kind, change)
        if found in counts:
            counts[found] += 1
        else:
            wrong.append(f"{kind}, {what}: {found}")
    assert not wrong, f"{len(wrong)} of {len(chosen)}:\n" + "\n".join(wrong[:60])
    return counts


def test_a_sample_of_the_damage(tmp_path: Path) -> None:
    counts = run(tmp_path, CASES[:: len(CASES) // 60])
    assert counts["same"] >= 10
    assert counts["refused"] >= 10


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(WRITERS))
def test_all_the_damage(tmp_path: Path, kind: str) -> None:
    counts = run(tmp_path, [c for c in CASES if c[0] == kind])
    assert sum(counts.values()) - counts["not written"] >= 55
    print(kind, json.dumps(counts))


def test_there_is_enough_of_it() -> None:
    assert len(CASES) >= 1000


DRAWN: list[tuple[str, str, Write]] = [
    (kind, what, write)
    for kind, found in (
        ("label-studio", label_studio_changes()), ("cvat", cvat_changes()),
        ("coco", coco_changes()),
    )
    for what, write in found
]  # fmt: skip
DRAWN += list(listed_changes())


def drawn_outcome(folder: Path, kind: str, write: Write) -> str:
    """As `outcome`, for drawings over a picture."""
    from PIL import Image

    Image.new("RGB", (WIDTH, HEIGHT)).save(folder / "table.png")
    path = write(folder)
    listed = path.suffix == ".csv"
    form = "tables" if listed else kind
    how = {}
    if listed:
        name = "table.json" if kind == "supervisely" else "objects.json"
        how = {"objects": name, "picture": "table.png"}
    try:
        result = read_source(path, format=form, mapping=Mapping.model_validate(how))
    except DemospecError as error:
        return "refused" if "\n" not in str(error) else "a refusal of several lines"
    return other_drawing(result.data, result.notes) or "same"


def run_drawn(tmp_path: Path, chosen: list[tuple[str, str, Write]]) -> dict[str, int]:
    counts = {"same": 0, "refused": 0}
    wrong = []
    for i, (kind, what, write) in enumerate(chosen):
        folder = tmp_path / str(i)
        folder.mkdir()
        found = drawn_outcome(folder, kind, write)
        if found in counts:
            counts[found] += 1
        else:
            wrong.append(f"{kind}, {what}: {found}")
    assert not wrong, f"{len(wrong)} of {len(chosen)}:\n" + "\n".join(wrong[:60])
    return counts


def test_a_sample_of_the_damage_to_drawings(tmp_path: Path) -> None:
    counts = run_drawn(tmp_path, DRAWN[:: len(DRAWN) // 60])
    assert min(counts.values()) >= 10


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(dict.fromkeys(kind for kind, _, _ in DRAWN)))
def test_all_the_damage_to_drawings(tmp_path: Path, kind: str) -> None:
    chosen = [c for c in DRAWN if c[0] == kind]
    assert drawn_outcome(tmp_path, *chosen[0][::2]) == "same"
    print(kind, json.dumps(run_drawn(tmp_path, chosen)))


STORED: list[tuple[str, str, WriteSource]] = [
    (kind, what, write)
    for kind, found in (
        ("hdf5", hdf5_changes()), ("lerobot", lerobot_changes()), ("mcap", mcap_changes()),
    )
    for what, write in found
]  # fmt: skip


def run_stored(tmp_path: Path, chosen: list[tuple[str, str, WriteSource]]) -> dict[str, int]:
    counts = {"same": 0, "refused": 0}
    wrong = []
    for i, (kind, what, write) in enumerate(chosen):
        skip_without(kind)
        folder = tmp_path / str(i)
        folder.mkdir()
        found = judged(write(folder), kind)
        if found in counts:
            counts[found] += 1
        else:
            wrong.append(f"{kind}, {what}: {found}")
    assert not wrong, f"{len(wrong)} of {len(chosen)}:\n" + "\n".join(wrong[:60])
    return counts


def test_a_sample_of_the_damage_to_arrays_and_messages(tmp_path: Path) -> None:
    counts = run_stored(tmp_path, STORED[::8])
    assert min(counts.values()) >= 4


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["hdf5", "lerobot", "mcap"])
def test_all_the_damage_to_arrays_and_messages(tmp_path: Path, kind: str) -> None:
    chosen = [c for c in STORED if c[0] == kind]
    skip_without(kind)
    (tmp_path / "whole").mkdir()
    assert judged(chosen[0][2](tmp_path / "whole"), kind) == "same"
    print(kind, json.dumps(run_stored(tmp_path, chosen)))
