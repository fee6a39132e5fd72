"""Two classes that always stand together: the question is to put one of them alone."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, write_set
from demospec.rules import query_set
from demospec.scene import Disc, SceneObject
from demospec.testing import demonstrator_set


def mirrored(item: SceneObject) -> tuple[float, float]:
    return 100.0 - item.center[0], 100.0 - item.center[1]


def with_jugs(together: bool) -> DemonstrationSet:
    """A person who keeps 6 from glasses; in the same place as each, or elsewhere, stands a jug."""
    data = demonstrator_set(np.random.default_rng(4), {"anna": {"glass": 6.0}}, 8, 12)
    scenes = []
    for scene in data.scenes:
        glasses = [o for o in scene.listed_objects() if o.symbol == "glass"]
        jugs = [
            replace(o, id=f"jug-{i}", symbol="jug") if together
            else SceneObject(f"jug-{i}", "jug", mirrored(o), None, Disc(mirrored(o), 4.0))
            for i, o in enumerate(glasses)
        ]  # fmt: skip
        items = (*glasses, *jugs)
        scenes.append(replace(scene, objects=items, picture=None, recipe=None))
    return replace(data, scenes=tuple(scenes), symbols=(*data.symbols, "jug"))


def test_it_asks_to_put_one_alone() -> None:
    answer = query_set(with_jugs(together=True))
    assert set(answer.alone) == {"glass", "jug"}
    assert "glasses" in answer.note
    assert "jugs" in answer.note
    assert "alone" in answer.note
    assert answer.to_json()["alone"] == list(answer.alone)


def test_classes_that_stand_apart_are_no_question() -> None:
    answer = query_set(with_jugs(together=False))
    assert answer.alone == ()
    assert "alone" not in answer.to_json()
    assert "alone" not in answer.note


def test_the_command_prints_the_question(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_set(with_jugs(together=True), tmp_path / "set")
    for more in ([], ["--json"]):
        with pytest.raises(SystemExit) as left:
            main(["query", str(tmp_path / "set"), *more])
        assert left.value.code == 0
        said = capsys.readouterr().out
        if more:
            assert set(json.loads(said)["alone"]) == {"glass", "jug"}
        else:
            assert "put one of them alone" in " ".join(said.split())
