"""Detectors of others: results of any tool, registered ones, symbols, one object a thing."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import pytest

from demospec.cli import main
from demospec.demonstrations import DemonstrationSet, read_set, simulate_set, write_set
from demospec.errors import InputError
from demospec.geometry import MultiPolygon
from demospec.perception import detect_in_set
from demospec.perception.detectors import Finding, detector_names, detector_of, listed, symbol_map
from demospec.rules import learn_rules

PICTURE = np.zeros((60, 80, 3), dtype=np.uint8)


def written(file: Path, document: object) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(document if isinstance(document, str) else json.dumps(document))
    return file


def found(path: Path, *names: str, pixels: np.ndarray = PICTURE) -> list[tuple[Any, ...]] | None:
    findings = detector_of(f"json:{path}").detect(pixels, names or ("table.png", "table"))
    if findings is None:
        return None
    things = listed(findings, (pixels.shape[1], pixels.shape[0]), least=0.0)
    return [(t.symbol, t.confidence, tuple(np.round(t.bbox, 2).tolist())) for t in things]


CUP, PLATE = ("cup", 0.9, (10, 20, 30, 15)), ("plate", 0.4, (50, 5, 20, 20))


def test_coco_with_scores(tmp_path: Path) -> None:
    document = {
        "images": [{"id": 1, "file_name": "a/table.png", "width": 80, "height": 60}],
        "categories": [{"id": 3, "name": "cup"}, {"id": 4, "name": "plate"}],
        "annotations": [
            {"id": 1, "image_id": 1, "category_id": 3, "bbox": [10, 20, 30, 15], "score": 0.9},
            {"id": 2, "image_id": 1, "category_id": 4, "bbox": [50, 5, 20, 20], "score": 0.4},
        ],
    }
    file = written(tmp_path / "coco.json", document)
    assert found(file) == [CUP, PLATE]
    # On a picture of twice the size the same places.
    twice = np.zeros((120, 160, 3), dtype=np.uint8)
    assert found(file, "table.png", pixels=twice)[0] == ("cup", 0.9, (20, 40, 60, 30))
    assert found(file, "other.png") is None
    with pytest.raises(InputError, match="shaped as 60x60"):
        found(file, "table.png", pixels=np.zeros((60, 60, 3), dtype=np.uint8))


def test_results_of_coco(tmp_path: Path) -> None:
    """A bare list; pictures by number as in the file's name, classes by name where one stands."""
    rows = [
        {"image_id": 42, "category_id": 3, "category_name": "cup", "bbox": [10, 20, 30, 15],
         "score": 0.9},
        {"image_id": 42, "category_id": 4, "bbox": [50, 5, 20, 20], "score": 0.4},
        {"image_id": 43, "category_id": 4, "bbox": [1, 1, 2, 2], "score": 0.5},
    ]  # fmt: skip
    file = written(tmp_path / "predictions.json", rows)
    assert found(file, "0042.png", "0042") == [CUP, ("4", *PLATE[1:])]


@pytest.mark.parametrize("sure", ["", " 0.9"])
def test_yolo_text_with_and_without_confidence(tmp_path: Path, sure: str) -> None:
    written(tmp_path / "out" / "classes.txt", "cup\nplate\n")
    outline = "1 0.625 0.0833 0.875 0.0833 0.875 0.41667"
    written(tmp_path / "out" / "table.txt", f"0 0.3125 0.45833 0.375 0.25{sure}\n{outline}{sure}")
    (cup, plate) = sorted(found(tmp_path / "out"))
    confidence = 0.9 if sure else 1.0
    assert cup == ("cup", confidence, (10, 20, 30, 15))
    assert plate[1:] == (confidence, pytest.approx((50, 5, 20, 20), abs=0.01))


def test_labelme_with_scores(tmp_path: Path) -> None:
    shapes = [{"label": "cup", "score": 0.9, "shape_type": "rectangle",
               "points": [[10, 20], [40, 35]]}]  # fmt: skip
    document = {"imagePath": "table.png", "imageWidth": 80, "imageHeight": 60, "shapes": shapes}
    assert found(written(tmp_path / "table.json", document)) == [CUP]


SUPERVISION = [
    {"x_min": 10.0, "y_min": 20.0, "x_max": 40.0, "y_max": 35.0, "class_id": 41,
     "confidence": 0.9, "tracker_id": "", "class_name": "cup"},
    {"x_min": 50.0, "y_min": 5.0, "x_max": 70.0, "y_max": 25.0, "class_id": 7,
     "confidence": 0.4, "tracker_id": ""},
]  # fmt: skip


def test_supervision_json_and_csv(tmp_path: Path) -> None:
    expected = [CUP, ("7", *PLATE[1:])]
    assert found(written(tmp_path / "s.json", SUPERVISION)) == expected
    names = list(SUPERVISION[0])
    lines = [",".join(str(r.get(n, "")) for n in [*names, "file_name"]) for r in SUPERVISION]
    header = ",".join([*names, "file_name"])
    assert found(written(tmp_path / "s.csv", "\n".join([header, *lines]))) == expected
    several = [{**row, "file_name": f"{i}/x{i}.png"} for i, row in enumerate(SUPERVISION)]
    assert found(written(tmp_path / "m.json", several), "x0.png") == expected[:1]


def test_masks_of_several_parts_stay_whole(tmp_path: Path) -> None:
    document = {
        "images": [{"id": 1, "file_name": "table.png"}],
        "categories": [{"id": 3, "name": "cup"}],
        "annotations": [{"id": 1, "image_id": 1, "category_id": 3, "segmentation":
                         [[10, 20, 20, 20, 20, 30], [30, 20, 40, 20, 40, 35]]}],
    }  # fmt: skip
    findings = detector_of(f"json:{written(tmp_path / 'c.json', document)}").detect(
        PICTURE, ("table",)
    )
    (thing,) = listed(findings, (80, 60))
    assert isinstance(thing.footprint, MultiPolygon)
    assert thing.bbox == (10, 20, 30, 15)


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ([{"x_min": 1, "y_min": 1, "x_max": 3}], "row 0, y_max: expected a number"),
        ([{"x_min": 1, "y_min": 1, "x_max": 3, "y_max": 4, "class_id": 1, "confidence": 97.0}],
         "expected a confidence from 0 to 1, found 97"),
        ([{"image_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}], "category_id"),
        ({"cups": []}, "COCO"),
    ],
)  # fmt: skip
def test_bad_results_are_one_line(tmp_path: Path, document: object, words: str) -> None:
    file = written(tmp_path / "bad.json", document)
    with pytest.raises(InputError, match=words) as error:
        found(file)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_yolo_annotation_with_a_confidence_is_still_no_annotation(tmp_path: Path) -> None:
    from demospec.demonstrations.readers import read_objects

    written(tmp_path / "classes.txt", "cup")
    written(tmp_path / "table.txt", "0 0.5 0.5 0.1 0.1 0.9")
    with pytest.raises(InputError, match="5 numbers"):
        read_objects(tmp_path)


# One object a thing


def test_one_thing_under_two_words_is_one_object() -> None:
    found = [
        Finding("cup", 0.7, bbox=(10, 10, 20, 20)),
        Finding("bowl", 0.8, bbox=(10, 10, 21, 20)),
        Finding("saucer", 0.6, bbox=(6, 6, 30, 30)),
        Finding("spoon", 0.3, bbox=(60, 10, 5, 30)),
        Finding("fork", 0.9, bbox=(200, 10, 5, 30)),
    ]
    things = listed(found, (80, 60), symbols={"bowl": "vessel", "saucer": "plate"})
    assert [(t.id, t.symbol, t.confidence) for t in things] == [
        ("vessel-0", "vessel", 0.8), ("plate-0", "plate", 0.6),
    ]  # fmt: skip
    assert {t.symbol for t in listed(found, (80, 60), least=0.2)} == {"bowl", "saucer", "spoon"}


def test_a_symbol_map_is_read_from_words() -> None:
    assert symbol_map("cup=glass,wine glass=glass") == {"cup": "glass", "wine glass": "glass"}
    for text in ("cup", "cup=", "=glass", "cup=glass,cup=bowl", ""):
        with pytest.raises(InputError, match="--symbols"):
            symbol_map(text)


def test_findings_outside_the_picture_are_cut_or_left_out() -> None:
    found = [Finding("cup", 0.9, bbox=(-5, 50, 20, 30)), Finding("cup", 0.9, bbox=(90, 1, 5, 5))]
    (thing,) = listed(found, (80, 60))
    assert thing.bbox == (0, 50, 15, 10)


# Registered detectors, and sets


class Oracle:
    """Says what stands in each scene, a little off, in words of its own."""

    name = "oracle"

    def __init__(self, data: DemonstrationSet, off_px: float = 0.0) -> None:
        self.data, self.off, self.rng = data, off_px, np.random.default_rng(0)

    def detect(self, pixels: np.ndarray, names: tuple[str, ...] = ()) -> list[Finding] | None:
        assert pixels.dtype == np.uint8
        scene = self.data.scene(names[-1])
        found = []
        for item in scene.objects or ():
            x0, y0, x1, y1 = item.outline.moved(self.rng.normal(0, self.off, 2)).bounds
            if hasattr(item.outline, "vertices"):
                rim = item.outline.vertices + (np.array([x0, y0]) - item.outline.bounds[:2])
                found.append(Finding(f"my {item.symbol}", 0.9, polygon=rim))
            else:
                found.append(Finding(f"my {item.symbol}", 0.9, bbox=(x0, y0, x1 - x0, y1 - y0)))
        return found


@pytest.fixture(scope="module")
def simulated() -> DemonstrationSet:
    return simulate_set(train_scenes=8, test_scenes=2, demonstrations=10, seed=41)[0]


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch, simulated: DemonstrationSet) -> None:
    """An installed package that brings two detectors, of which one does not load."""

    def entries(**wanted: str) -> EntryPoints:
        group = "demospec.detectors"
        both = EntryPoints([
            EntryPoint("oracle", f"{__name__}:made", group),
            EntryPoint("broken", "no_such_package:made", group),
            EntryPoint("none", f"{__name__}:PICTURE.copy", group),
        ])  # fmt: skip
        return both.select(**wanted)

    monkeypatch.setattr("importlib.metadata.entry_points", entries)
    global made
    made = lambda argument: Oracle(simulated, float(argument or 0))  # noqa: E731


def test_a_registered_detector_is_called_by_its_name(registered: None) -> None:
    assert {"json", "onnx", "torchvision", "oracle"} <= set(detector_names())
    assert detector_of("oracle:2.5").off == 2.5
    assert detector_of("oracle").off == 0
    for name, words in {
        "yolo": "a detector .*oracle", "broken": "no_such_package", "json": "json:ARGUMENT",
        "none": "a detector",
    }.items():  # fmt: skip
        with pytest.raises(InputError, match=words):
            detector_of(name)


def test_rules_of_a_detector_a_little_off_hold_the_truth(simulated: DemonstrationSet) -> None:
    """Its errors of position widen the interval: it still holds the clearance that made the
    labels (3 px), as that of the true lists does."""
    train = simulated.of_split("train")
    words = {f"my {s}": s for s in train.symbols}
    seen, skipped = detect_in_set(train, detector=Oracle(simulated, 0.5), symbols=words)
    assert skipped == ()
    assert {o.symbol for s in seen.scenes for o in s.objects or ()} <= set(train.symbols)
    rule = learn_rules(seen).rules["careful"].clearance
    low, high = rule.interval["glass"]
    assert low <= 3 <= high


def test_a_set_remembers_the_detector_of_its_lists(
    registered: None, simulated: DemonstrationSet, tmp_path: Path
) -> None:
    folder = write_set(simulated, tmp_path / "S")
    symbols = ",".join(f"my {s}={s}" for s in simulated.symbols if s != "glass")
    assert _run("detect", folder, "--detector", "oracle:0.2", "--symbols", symbols,
                "--out", tmp_path / "seen") == 0  # fmt: skip
    seen = read_set(tmp_path / "seen")
    assert {"my glass", *simulated.symbols} == set(seen.symbols)  # unknown words stay
    for scene in seen.scenes:
        assert dict(scene.extra)["detector"] == {"name": "oracle", "least": 0.5}
    # Detected anew, the record is the new one's.
    again, _ = detect_in_set(seen, detector=Oracle(simulated), least=0.25)
    assert dict(again.scenes[0].extra)["detector"] == {"name": "oracle", "least": 0.25}


def test_convert_and_fit_take_a_detector(
    registered: None, simulated: DemonstrationSet, tmp_path: Path
) -> None:
    blind = replace(simulated, scenes=tuple(replace(s, objects=None) for s in simulated.scenes))
    folder = write_set(blind, tmp_path / "blind")
    assert _run("convert", folder, tmp_path / "listed", "--detector", "oracle") == 0
    listed_set = read_set(tmp_path / "listed")
    assert [len(s.objects or ()) for s in listed_set.scenes] == [
        len(s.objects or ()) for s in simulated.scenes
    ]
    assert _run("fit", folder, "--model", "irl", "--detector", "oracle", "--out",
                tmp_path / "model") == 0  # fmt: skip


def test_a_picture_and_a_file_of_results(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    PIL.Image.fromarray(PICTURE).save(tmp_path / "table.png")
    results = written(tmp_path / "s.json", SUPERVISION)
    command = ("detect", tmp_path / "table.png", "--detector", f"json:{results}", "--json")
    assert _run(*command, "--symbols", "cup=glass") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["size_px"] == [80, 60]
    (thing,) = document["objects"]
    assert (thing["symbol"], thing["confidence"]) == ("glass", 0.9)
    assert _run(*command, "--set", tmp_path) == 2
    assert _run("detect", tmp_path / "table.png", "--symbols", "cup=glass") == 2
    assert _run("detect", tmp_path / "table.png", "--detector", f"json:{tmp_path}/none") == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert len(error) == 3


def test_pixels_are_no_places_of_a_set_in_metres(simulated: DemonstrationSet) -> None:
    with pytest.raises(InputError, match=r"units: expected px"):
        detect_in_set(
            replace(simulated, units="m", metres_per_unit=None), detector=Oracle(simulated)
        )


def _run(*arguments: object) -> int:
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    return int(stop.value.code or 0)
