"""No causal claim rests on answers that no rule explains; checks that do not apply say so."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from demospec.causal import Settings, find_causes, findings_from_document
from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, simulate_set, write_set
from demospec.rules import learn_rules, rules_document


def simulated(coin: bool) -> DemonstrationSet:
    data, _ = simulate_set(train_scenes=12, test_scenes=0, demonstrations=8, seed=4)
    d = data.demonstrations
    if coin:
        rng = np.random.default_rng(0)
        d = replace_labels(d, (rng.random(len(d)) < 0.5).astype(np.int8))
    scenes = tuple(replace(s, picture=None) for s in data.scenes)
    return replace(data, scenes=scenes, demonstrations=d)


def replace_labels(d, valid):  # type: ignore[no-untyped-def]
    from demospec.demonstrations import Demonstrations

    return Demonstrations(
        demo_id=d.demo_id, scene_id=d.scene_id, type=d.type, demonstrator=d.demonstrator,
        valid=valid, flat=d.flat, offsets=d.offsets, t=d.t,
    )  # fmt: skip


SETTINGS = Settings(placements=2, draws=30)


def test_of_coin_flips_nothing_is_claimed() -> None:
    data = simulated(coin=True)
    rules = learn_rules(data, influence=False)
    findings = find_causes(rules, data.scenes, settings=SETTINGS)
    assert {fit.verdict for fit in findings.labels.values()} == {"not"}
    assert not any(cell.causal for cell in findings.effects)
    assert not any(pair.differ for pair in findings.type_effects)
    assert any("nothing is claimed" in s for s in findings.sentences)


def test_of_real_answers_it_is_said_whose_effects_these_are() -> None:
    data = simulated(coin=False)
    findings = find_causes(learn_rules(data, influence=False), data.scenes, settings=SETTINGS)
    assert findings.effect("normal", "glass").causal
    assert findings.sentences[0] == (
        "Effects are on what the model learned from these answers accepts."
    )
    assert findings.labels["normal"].verdict == "explains"
    assert any(
        s.startswith("Permuted labels are not explained as well") for s in findings.sentences
    )
    assert any("not applicable" in s for s in findings.sentences)
    again = findings_from_document(json.loads(json.dumps(findings.to_json())))
    assert again.labels["normal"].verdict == "explains"


def test_the_command_withholds_them_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = simulated(coin=True)
    write_set(data, tmp_path / "set")
    rules = rules_document(learn_rules(data, influence=False))
    (tmp_path / "r.json").write_text(json.dumps(rules))
    with pytest.raises(SystemExit) as stop:
        main(["causes", str(tmp_path / "r.json"), str(tmp_path / "set"), "--json",
              "--placements", "1", "--draws", "20"])  # fmt: skip
    assert not stop.value.code
    document = json.loads(capsys.readouterr().out)
    assert not any(cell["causal"] for cell in document["effects"])
    assert document["labels"]["careful"]["verdict"] == "not"


def test_a_short_name_takes_no_others_sentence_with_it() -> None:
    """Only the type whose answers nothing explains falls silent, whatever its name."""
    data = simulated(coin=False)
    d = data.demonstrations
    rng = np.random.default_rng(1)
    coin = (rng.random(len(d)) < 0.5).astype(np.int8)
    d = replace_labels(d, np.where(d.type == "careful", coin, d.valid).astype(np.int8))
    renamed = np.array(["and" if t == "careful" else t for t in d.type], dtype=object)
    d.type = renamed
    data = replace(data, demonstrations=d, types=("and", "normal", "aggressive"))
    findings = find_causes(learn_rules(data, influence=False), data.scenes, settings=SETTINGS)
    assert findings.labels["and"].verdict == "not"
    assert any(s.startswith("and: the rule does not explain") for s in findings.sentences)
    assert any(s.startswith("normal looks out for") for s in findings.sentences)
    assert not any(s.startswith("and ") for s in findings.sentences)


def test_rules_in_metres_are_asked_in_the_pixels_of_the_set(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = simulated(coin=False)
    assert data.metres_per_unit is not None
    write_set(data, tmp_path / "set")
    said = []
    for units, value in (("px", 6.0), ("m", 6.0 * data.metres_per_unit)):
        rule = {"clearance": {"value": {"glass": value}}}
        document = {"types": {"normal": rule}, "units": units}
        (tmp_path / "r.json").write_text(json.dumps(document))
        with pytest.raises(SystemExit) as stop:
            main(["causes", str(tmp_path / "r.json"), str(tmp_path / "set"), "--json",
                  "--placements", "1", "--draws", "20"])  # fmt: skip
        assert not stop.value.code
        said.append(json.loads(capsys.readouterr().out)["effects"])
    assert said[0] == said[1]
