"""Damaged files of every format: a set or one line, never anything else.

Seeds are whole files that other libraries wrote; hypothesis cuts them, overwrites stretches and
repeats others. What once broke a reader is kept in `corpus/` and tried first.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from foreign_files import arc, write_lerobot, write_mcap, write_robomimic
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from demospec.demonstrations import check_set, read_set
from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import DemospecError

EXAMPLES = int(os.environ.get("DEMOSPEC_FUZZ_EXAMPLES", "50"))
CORPUS = Path(__file__).parent / "corpus"
MAPPINGS = {
    "hdf5": {"picture": "obs/agentview_image"},
    "lerobot": {"picture": "observation.images.top"},
    "ros": {"picture": "/camera", "path": "/tool_pose"},
}


def csv_seed(folder: Path) -> Path:
    (folder / "a.csv").write_text("demo_id,t,x,y,valid,type\na,0,1,2,1,me\na,1,3,4,1,me\n")
    return folder / "a.csv"


def npz_seed(folder: Path) -> Path:
    np.savez(folder / "a.npz", points=np.zeros((3, 2)), success=np.array(True))
    return folder / "a.npz"


def npy_seed(folder: Path) -> Path:
    np.save(folder / "a.npy", np.zeros((3, 2)))
    return folder / "a.npy"


def json_seed(folder: Path) -> Path:
    scene = {"scene_id": "s", "start": [1, 2], "goal": [3, 4], "objects": []}
    item = {"id": "d", "scene_id": "s", "points": [[1, 2], [3, 4]], "valid": True}
    (folder / "a.json").write_text(json.dumps({"scenes": [scene], "demonstrations": [item]}))
    return folder / "a.json"


def studio_seed(folder: Path) -> Path:
    corners = [{"x": 1, "y": 2}, {"x": 3, "y": 4}]
    region = {"id": "p", "type": "vectorlabels", "original_width": 64, "original_height": 48,
              "value": {"vertices": corners, "vectorlabels": ["a"]}}  # fmt: skip
    (folder / "a.json").write_text(json.dumps([{"id": 1, "annotations": [{"result": [region]}]}]))
    return folder / "a.json"


def cvat_seed(folder: Path) -> Path:
    (folder / "a.xml").write_text(
        '<?xml version="1.0"?><annotations><image name="a.png" width="64" height="48">'
        '<polyline label="me" points="1,2;3,4"/><box label="g" xtl="1" ytl="1" xbr="4" ybr="4"/>'
        "</image></annotations>"
    )
    return folder / "a.xml"


def hdf5_seed(folder: Path) -> Path:
    pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    write_robomimic(folder / "a.hdf5", demos=1)
    return folder / "a.hdf5"


def mcap_seed(folder: Path) -> Path:
    pytest.importorskip("mcap", reason="pip install 'demospec[ros]'")
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]'")
    write_mcap(folder / "a.mcap", arc(5), True)
    return folder / "a.mcap"


SEEDS: dict[str, tuple[str, Callable[[Path], Path]]] = {
    "csv": ("tables", csv_seed),
    "npy": ("tables", npy_seed),
    "npz": ("tables", npz_seed),
    "json": ("json", json_seed),
    "studio": ("label-studio", studio_seed),
    "cvat": ("cvat", cvat_seed),
    "hdf5": ("hdf5", hdf5_seed),
    "mcap": ("ros", mcap_seed),
}

edits = st.lists(
    st.tuples(
        st.sampled_from(["cut", "write", "repeat", "drop"]),
        st.floats(0, 1),
        st.one_of(
            st.binary(max_size=8),
            st.sampled_from(
                [b"\xff" * 4, b"\0" * 8, b"1e300", b"NaN", b"-1", b"[[[[", b'"', b",,"]
            ),
        ),
    ),
    min_size=1,
    max_size=3,
)


def damaged(data: bytes, changes: list[tuple[str, float, bytes]]) -> bytes:
    for kind, where, piece in changes:
        at = int(where * len(data))
        if kind == "cut":
            data = data[:at]
        elif kind == "write":
            data = data[:at] + piece + data[at + len(piece) :]
        elif kind == "repeat":
            data = data[:at] + data[max(0, at - 20) : at] + data[at:]
        else:
            data = data[:at] + data[at + len(piece) + 1 :]
    return data


def one_line(error: DemospecError) -> None:
    assert "\n" not in str(error)


def survives(file: Path, kind: str) -> None:
    """Reading gives a set or a `DemospecError`; anything else fails the test."""
    try:
        result = read_source(
            file, format=kind, mapping=Mapping.model_validate(MAPPINGS.get(kind, {}))
        )
    except DemospecError as error:
        one_line(error)
        return
    assert len(result.data.demonstrations) >= 1


@pytest.mark.parametrize("name", list(SEEDS))
def test_damaged_files(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp(name)
    kind, make = SEEDS[name]
    seed = make(folder)
    whole = seed.read_bytes()
    survives(seed, kind)

    @settings(deadline=None, max_examples=EXAMPLES, database=None,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(changes=edits)
    def run(changes: list[tuple[str, float, bytes]]) -> None:
        seed.write_bytes(damaged(whole, changes))
        survives(seed, kind)

    run()


@pytest.mark.parametrize("part", ["meta/info.json", "meta/episodes/chunk-000/file-000.parquet",
                                  "data/chunk-000/file-000.parquet"])  # fmt: skip
def test_damaged_lerobot(part: str, tmp_path: Path) -> None:
    write_lerobot(tmp_path / "set", episodes=2)
    file = tmp_path / "set" / part
    whole = file.read_bytes()

    @settings(deadline=None, max_examples=EXAMPLES, database=None,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(changes=edits)
    def run(changes: list[tuple[str, float, bytes]]) -> None:
        file.write_bytes(damaged(whole, changes))
        survives(tmp_path / "set", "lerobot")

    run()


@pytest.mark.parametrize(
    "part", ["dataset.json", "scenes/metadata.jsonl", "demonstrations.parquet", "scenes/s0.png"]
)
def test_damaged_sets(part: str, tmp_path: Path) -> None:
    from dataclasses import replace

    from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, write_set
    from demospec.scene import Picture, Scene, SceneObject

    glass = SceneObject("g", "glass", (5.0, 5.0), (4.0, 4.0, 2.0, 2.0), None)
    shade = Picture(array=np.full((12, 12, 3), 90, np.uint8))
    scene = Scene("s0", (1.0, 9.0), (9.0, 1.0), (glass,), shade)
    items = [
        Demonstration(
            f"d{i}", "s0", np.array([[1.0, 9.0], [i, 5.0], [9.0, 1.0]]), "me", None, i > 1
        )
        for i in range(4)
    ]
    data = DemonstrationSet((scene,), Demonstrations.of(items), symbols=("glass",), types=("me",))
    root = write_set(replace(data, name="seed"), tmp_path / "set")
    file = root / part
    whole = file.read_bytes()

    @settings(deadline=None, max_examples=EXAMPLES, database=None,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(changes=edits)
    def run(changes: list[tuple[str, float, bytes]]) -> None:
        file.write_bytes(damaged(whole, changes))
        report = check_set(root)
        try:
            found = read_set(root)
        except DemospecError as error:
            one_line(error)
            found = None
        whole_pictures = True
        try:
            _ = [s.pixels() for s in (found.scenes if found else ()) if s.picture is not None]
        except DemospecError as error:
            one_line(error)
            whole_pictures = False
        assert report.readable == (found is not None and whole_pictures)

    run()


def corpus_files() -> list[Path]:
    return sorted(p for p in CORPUS.iterdir() if p.name != "README.md") if CORPUS.is_dir() else []


@pytest.mark.parametrize("file", corpus_files(), ids=lambda p: p.name)
def test_corpus(file: Path, tmp_path: Path) -> None:
    """Names are FORMAT--WHAT.SUFFIX."""
    kind = file.name.split("--")[0]
    shutil.copy(file, tmp_path / file.name)
    survives(tmp_path / file.name, kind)
