"""Damaged inputs over every entry point: right data, or one line and nothing written."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from damages import Case, Damage, fault_of, file_damages, first_line, json_file

from demospec.cli import main
from demospec.cli._app import build_app
from demospec.demonstrations import write_set
from demospec.testing import demonstrator_set

EACH = 8
"""Cases of an entry point in the quick suite."""

MANY = 150
"""And under the slow mark."""

BY_HAND = {
    "types": {
        "anna": {
            "clearance": {
                "relevant": ["glass"],
                "value": {"glass": 3.0},
                "interval": {"glass": [2.5, 3.5]},
                "uninformed": [],
                "distance": "footprint",
                "draws": [{"glass": 3.1}],
            },
            "sentence": "Keep clear.",
            "evidence": {"at_most": {}, "decided": {"glass": [2.0, 4.0]}, "undecided": []},
            "constraints": [],
        }
    },
    "units": "px",
    "metres_per_unit": 0.0082,
    "notes": ["by hand"],
}
CLEARANCE = {
    "family": "clearance",
    "scenes": [{"objects": [{"id": "drill", "class": "drill", "center": [20, 20]}]}],
    "trajectories": [
        {"valid": True, "points": [[0, 40], [40, 40]]},
        {"valid": False, "points": [[0, 40], [20, 24]]},
    ],
}
INFLUENCE = {
    "F_max": 60,
    "bounds": {"T_min": [1, 12], "T_object": [1, 15]},
    "scenes": CLEARANCE["scenes"],
    "trajectories": CLEARANCE["trajectories"],
}
INNER = {
    "scenes": [{"scene_id": "s", "start": [1, 2], "goal": [30, 4], "objects": [
        {"id": "g", "symbol": "glass", "center": [9, 9], "bbox": [8, 8, 2, 2]}]}],
    "demonstrations": [{"id": "d", "scene_id": "s", "points": [[1, 2], [30, 4]], "valid": True,
                        "type": "anna", "t": [0, 1]}],
}  # fmt: skip
MAPPING = {
    "columns": {"x": "a", "y": "b"},
    "time": "t",
    "time_unit": "s",
    "every": 1,
    "skip_rows": 0,
    "words": {"1": True},
    "include": ["*.csv"],
    "decimal": ".",
    "units": "m",
    "metres_per_unit": 1.0,
    "type": "always:anna",
    "scene": "always:s",
    "projection": {"plane": "xy"},
    "scenes": {"s": {"start": [0, 0], "goal": [3, 3], "split": "train", "objects": []}},
}
COCO = {
    "images": [{"id": 1, "file_name": "s.png", "width": 64, "height": 48}],
    "categories": [{"id": 1, "name": "path"}],
    "annotations": [
        {"id": 1, "image_id": 1, "category_id": 1, "segmentation": [[1, 2, 3, 4, 5, 6]],
         "bbox": [1, 2, 4, 4], "keypoints": [1, 2, 2, 3, 4, 2], "num_keypoints": 2}
    ],
}  # fmt: skip
STUDIO = [{"id": 1, "data": {"image": "a.png"}, "annotations": [{"id": 2, "result": [
    {"id": "p", "type": "vectorlabels", "original_width": 64, "original_height": 48,
     "from_name": "a", "to_name": "b",
     "value": {"vertices": [{"x": 1, "y": 2}, {"x": 3, "y": 4}],
               "vectorlabels": ["a"]}}]}]}]  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with everything undamaged."""
    root = tmp_path_factory.mktemp("whole")
    data = demonstrator_set(np.random.default_rng(0), {"anna": {"glass": 3.0}}, 3, 6)
    write_set(data, root / "set")
    for name, document in DOCUMENTS.items():
        (root / name).write_text(json.dumps(document))
    (root / "a.csv").write_text("demo_id,t,a,b,valid,type\na,0,1,2,1,me\na,1,3,4,1,me\n")
    (root / "b.csv").write_text("demo_id,t,x,y\na,0,10,20\na,1,30,40\n")
    for command in (
        f"audit {root}/set --out {root}/audit.json",
        f"plan {root}/rules.json {root}/set --scene 00 --type anna --out {root}/plan.json",
        f"simulate --out {root}/seen --train-scenes 2 --test-scenes 1 --demonstrations 5",
        f"fit {root}/seen --model irl --out {root}/model",
    ):
        with pytest.raises(SystemExit) as ended:
            main(command.split())
        assert not ended.value.code
    (root / "run").mkdir()
    write_set(data, root / "run" / "set")
    (root / "run" / "rules.json").write_text(json.dumps(BY_HAND))
    for command in (
        f"audit {root}/set --out {root}/run/audit.json",
        f"query {root}/set --type anna --pool 20 --out {root}/run/query.json",
        f"evaluate {root}/rules.json {root}/set --out {root}/run/accuracy.json",
    ):
        with pytest.raises(SystemExit) as ended:
            main(command.split())
        assert not ended.value.code
    return root


DOCUMENTS: dict[str, Any] = {
    "rules.json": BY_HAND,
    "clearance.json": CLEARANCE,
    "influence.json": INFLUENCE,
    "inner.json": INNER,
    "mapping.json": MAPPING,
    "coco.json": COCO,
    "studio.json": STUDIO,
}


def of_file(name: str) -> Callable[[Path], Iterator[tuple[str, Damage]]]:
    def damages(whole: Path) -> Iterator[tuple[str, Damage]]:
        return json_file(name, json.loads((whole / name).read_text()))

    return damages


def of_line(name: str) -> Callable[[Path], Iterator[tuple[str, Damage]]]:
    def damages(whole: Path) -> Iterator[tuple[str, Damage]]:
        first = (whole / name).read_text().splitlines()[0]
        return first_line(name)(json.loads(first))

    return damages


def of_bytes(*names: str) -> Callable[[Path], Iterator[tuple[str, Damage]]]:
    return lambda whole: (case for name in names for case in file_damages(name))


def of_table(whole: Path) -> Iterator[tuple[str, Damage]]:
    """Columns of another type, gone, with values that are none."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    name = "set/demonstrations.parquet"
    table = pq.read_table(whole / name)
    n = len(table)
    columns: dict[str, Any] = {
        "null": pa.nulls(n),
        "text": pa.array(["x"] * n),
        "escape": pa.array(["\x1b[31m"] * n),
        "long": pa.array(["x" * 5000] * n),
        "whole": pa.array([2**62] * n),
        "float": pa.array([1e308] * n),
        "NaN": pa.array([float("nan")] * n),
        "bytes": pa.array([b"\xed\xa0\x80"] * n),
        "lists": pa.array([[1e308, -1e308]] * n),
        "lists of lists": pa.array([[[1e308, 0.0], [0.0, float("inf")]]] * n),
        "empty lists": pa.array([[]] * n, pa.list_(pa.list_(pa.float64()))),
        "structs": pa.array([{"a": 1}] * n),
        "booleans": pa.array([True] * n),
    }
    for i, column in enumerate(table.column_names):
        for kind, values in columns.items():

            def write(root: Path, i: int = i, c: str = column, v: Any = values) -> None:
                pq.write_table(table.set_column(i, c, v), root / name)

            yield f"{name}: {column} is {kind}", write
        yield f"{name}: no {column}", lambda root, c=column: pq.write_table(
            table.drop_columns([c]), root / name
        )  # fmt: skip


ENTRIES: dict[str, tuple[Callable[[Path], Iterator[tuple[str, Damage]]], tuple[str, ...]]] = {
    "header": (of_file("set/dataset.json"), (
        "check set --json", "rules set --json --out out.json", "query set --type anna --pool 20",
        "edit split set --test-share 0.3 --out new", "predict rules.json set --json")),
    "scene": (of_line("set/scenes/metadata.jsonl"), (
        "check set --json", "rules set --out out.json", "predict rules.json set",
        "plan rules.json set --scene 00 --type anna --out out.json", "audit set --json",
        "edit trim set --out new")),
    "table": (of_table, (
        "check set --json", "rules set --json", "predict rules.json set --out out.json",
        "identify rules.json set", "edit trim set --out new")),
    "files of a set": (of_bytes(
        "set/dataset.json", "set/demonstrations.parquet", "set/scenes/metadata.jsonl"),
        ("check set", "rules set --out out.json", "edit trim set --out new")),
    "rules": (of_file("rules.json"), (
        "plan rules.json set --scene 00 --type anna --out out.json",
        "predict rules.json set --json", "evaluate rules.json set --json",
        "export rules.json set --scene 00 --type anna --to csv --out out.csv",
        "export rules.json set --scene 00 --type anna --to numpy --out out",
        "sample rules.json set --scene 00 --type anna --n 2 --json",
        "identify rules.json set", "causes rules.json set --draws 2 --placements 1 --json")),
    "truth": (of_file("rules.json"), (
        "evaluate rules.json set --truth rules.json --json",
        "repair model seen --type careful --steps 1 --rules rules.json --json")),
    "clearance": (of_file("clearance.json"), (
        "rules clearance.json --json --out out.json", "rules clearance.json",
        "query clearance.json")),
    "influence": (of_file("influence.json"), (
        "rules influence.json --json --out out.json", "rules influence.json",
        "query influence.json")),
    "audit": (of_file("audit.json"), (
        "edit relabel set --audit audit.json --flip 0-anna-0 --out new",)),
    "model": (of_file("model/config.json"), ("predict model seen --json", "identify model seen")),
    "provenance": (of_file("model/provenance.json"), ("predict model seen --json",)),
    "files of a model": (of_bytes("model/config.json", "model/weights.safetensors"), (
        "predict model seen --json",)),
    "inner": (of_file("inner.json"), ("convert inner.json new", "convert inner.json --dry-run")),
    "mapping": (of_file("mapping.json"), ("convert a.csv new --map mapping.json",)),
    "coco": (of_file("coco.json"), ("convert inner.json new --objects coco.json",)),
    "studio": (of_file("studio.json"), ("convert studio.json new",)),
    "plan": (of_file("plan.json"), (
        "check-run rules.json set --scene 00 --type anna --run b.csv --plan plan.json --json",)),
    "run rules": (of_file("run/rules.json"), ("report run --out page.html",)),
    "run audit": (of_file("run/audit.json"), ("report run --out page.html",)),
    "run query": (of_file("run/query.json"), ("report run --out page.html",)),
    "run accuracy": (of_file("run/accuracy.json"), ("report run --markdown --out page",)),
}  # fmt: skip


OPTIONS = {
    "causes": "causes rules.json set --draws 2 --placements 1",
    "plan": "plan rules.json set --scene 00 --type anna",
    "sample": "sample rules.json set --scene 00 --type anna --n 2",
    "repair": "repair model seen --type careful --steps 1",
    "predict": "predict rules.json set",
    "rules": "rules set",
    "influence": "rules influence.json",
    "query": "query set --type anna --pool 20",
    "audit": "audit set",
    "export": "export rules.json set --scene 00 --type anna --to csv --out out.csv",
    "convert": "convert b.csv new",
    "simulate": "simulate --train-scenes 1 --test-scenes 0 --demonstrations 1 --out new",
    "check-run": "check-run rules.json set --scene 00 --type anna --run b.csv",
    "evaluate": "evaluate rules.json set",
    "identify": "identify rules.json set",
    "fit": "fit seen --model irl --out new",
}
WORDS = ("nan", "inf", "1e400", "1e308", "-1", "9" * 30, "", "\udcff", "\x1b[2J", "x" * 300,
         "../../x", "a\nb")  # fmt: skip


def option_cases(whole: Path) -> Iterator[Case]:
    """Every option of a command that takes one value, with values that are none."""
    root = typer.main.get_command(build_app())
    for name, line in OPTIONS.items():
        command = root.commands[line.split()[0]]  # type: ignore[attr-defined]
        for option in command.params:
            flag = next((o for o in option.opts if o.startswith("--")), None)
            if flag is None or getattr(option, "is_flag", False) or option.nargs != 1:
                continue
            for word in WORDS:
                arguments = (*line.split(), f"{flag}={word}")
                yield Case(f"{name} {flag} {word[:12]!r}", lambda root: None, arguments, whole)


@pytest.mark.parametrize("n", [24, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_options(n: int, whole: Path, room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    every = list(option_cases(whole))
    chosen = every if n >= len(every) else random.Random("options").sample(every, n)
    faults = [fault for case in chosen if (fault := fault_of(case, room, capsys))]
    assert not faults, "\n".join(faults)


def cases(name: str, whole: Path, n: int) -> list[Case]:
    """`n` damages of an entry point, always the same ones."""
    damages, commands = ENTRIES[name]
    every = list(damages(whole))
    draw = random.Random(f"{name} {n}")
    chosen = every if n >= len(every) else draw.sample(every, n)
    return [
        Case(what, damage, tuple(draw.choice(commands).split()), whole) for what, damage in chosen
    ]


def judge(
    name: str, n: int, whole: Path, room: Path, capsys: pytest.CaptureFixture[str]
) -> list[str]:
    found = [fault_of(case, room, capsys) for case in cases(name, whole, n)]
    return [fault for fault in found if fault is not None]


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "room"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.parametrize("name", ENTRIES)
def test_a_sample(name: str, whole: Path, room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    faults = judge(name, EACH, whole, room, capsys)
    assert not faults, "\n".join(faults)


@pytest.mark.slow
@pytest.mark.parametrize("name", ENTRIES)
def test_many(name: str, whole: Path, room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    faults = judge(name, MANY, whole, room, capsys)
    assert not faults, "\n".join(faults)


def test_undamaged_all_is_well(whole: Path, room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    every = dict.fromkeys(command for _, commands in ENTRIES.values() for command in commands)
    plain = [Case("undamaged", lambda root: None, tuple(c.split()), whole) for c in every]
    faults = [fault for case in plain if (fault := fault_of(case, room, capsys))]
    assert not faults, "\n".join(faults)


def test_there_are_enough(whole: Path) -> None:
    there = [sum(1 for _ in damages(whole)) for damages, _ in ENTRIES.values()]
    assert sum(min(n, EACH) for n in there) >= 150
    assert sum(min(n, MANY) for n in there) >= 1500
