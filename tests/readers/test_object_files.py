"""Lists of objects by LabelMe, VIA, Supervisely, YOLO and drawn exports, through `--objects`."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawings import (
    HEIGHT,
    WIDTH,
    annotation,
    beside,
    boxes,
    coco,
    cvat,
    picture,
    png64,
    region,
    studio,
    things,
    way,
)

from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import InputError
from demospec.geometry import MultiPolygon

BLOCK = np.ones((20, 40), dtype=bool)
CUT = np.array([[1, 1, 0, 1], [1, 1, 0, 1]], dtype=bool)


def written(folder: Path, document: object, name: str = "objects.json") -> Path:
    """A file of objects beside a path and its picture."""
    coco(folder)
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(document if isinstance(document, str) else json.dumps(document))
    return folder


# LabelMe


def labelme(*shapes: dict[str, Any]) -> dict[str, Any]:
    return {
        "version": "5.4.1", "flags": {}, "imagePath": "table.png", "imageData": None,
        "imageHeight": HEIGHT, "imageWidth": WIDTH,
        "shapes": [{"group_id": None, "flags": {}, **s} for s in shapes],
    }  # fmt: skip


def shape(kind: str, *points: list[float], label: str = "glass", **more: Any) -> dict[str, Any]:
    return {"label": label, "shape_type": kind, "points": [*points], **more}


def test_labelme(tmp_path: Path) -> None:
    found = beside(
        written(
            tmp_path,
            labelme(
                shape("rectangle", [100, 60], [80, 40]),
                shape("circle", [50, 50], [53, 54]),
                shape("polygon", [0, 0], [10, 0], [10, 10], label="plate"),
                shape("point", [30, 30], label="pin"),
                shape("mask", [80, 30], [119, 49], mask=base64.b64encode(png64(BLOCK)).decode()),
            ),
        )
    )
    assert boxes(found) == {
        "glass-0": [80, 40, 20, 20], "glass-1": [45, 45, 10, 10], "plate-0": [0, 0, 10, 10],
        "pin-0": [], "glass-2": [80, 30, 40, 20],
    }  # fmt: skip


def test_labelme_groups_are_one_object(tmp_path: Path) -> None:
    found = beside(
        written(
            tmp_path,
            labelme(
                shape("rectangle", [0, 0], [10, 10], group_id=3),
                shape("rectangle", [50, 0], [60, 10], group_id=3),
                shape("rectangle", [50, 50], [60, 60], group_id=3, label="plate"),
                shape("rectangle", [80, 0], [90, 10]),
            ),
        )
    )
    assert list(boxes(found)) == ["glass-0", "plate-0", "glass-1"]
    assert isinstance(found[0].footprint, MultiPolygon)


@pytest.mark.parametrize(
    ("bad", "match"),
    [
        (shape("line", [0, 0], [9, 9]), "one of polygon"),
        (shape("linestrip", [0, 0], [9, 9]), "one of polygon"),
        (shape("circle", [0, 0], [0, 0]), "radii above 0"),
        (shape("rectangle", [0, 0]), "at least 2 points"),
        (shape("polygon", [0, 0], [1, 1]), "at least 3 points"),
        (shape("mask", [0, 0], [1, 1], mask="!"), "base64"),
        (shape("rectangle", [0, 0], [1, 1], label=""), "a class of object"),
    ],
)
def test_labelme_shapes_that_cannot_be_read(
    tmp_path: Path, bad: dict[str, Any], match: str
) -> None:
    with pytest.raises(InputError, match=match):
        beside(written(tmp_path, labelme(bad)))


def test_a_folder_of_labelme_files(tmp_path: Path) -> None:
    coco(tmp_path)
    other = {**labelme(), "imagePath": "elsewhere.png"}
    written(tmp_path, labelme(shape("point", [1, 1])), "lists/table.json")
    written(tmp_path, other, "lists/elsewhere.json")
    result = read_source(tmp_path / "run.csv", mapping=Mapping(picture="table.png",
                                                               objects="lists"))  # fmt: skip
    assert list(boxes(result.data.scenes[0].listed_objects())) == ["glass-0"]
    assert any("1 listed pictures are no scene (elsewhere.png)" in n for n in result.notes)


# VIA


def via(*regions: tuple[dict[str, Any], dict[str, Any]], old: bool = False) -> dict[str, Any]:
    listed: Any = [{"shape_attributes": s, "region_attributes": a} for s, a in regions]
    if old:
        listed = {str(i): r for i, r in enumerate(listed)}
    return {"table.png1234": {"filename": "table.png", "size": 1234, "regions": listed,
                              "file_attributes": {}}}  # fmt: skip


RECT = {"name": "rect", "x": 80, "y": 40, "width": 20, "height": 10}
KINDS = [
    (RECT, {"object": "glass"}),
    ({"name": "circle", "cx": 50, "cy": 50, "r": 5}, {"label": "cup", "note": "chipped"}),
    ({"name": "ellipse", "cx": 50, "cy": 50, "rx": 20, "ry": 10, "theta": np.pi / 2},
     {"type": "plate"}),
    ({"name": "polygon", "all_points_x": [0, 10, 10], "all_points_y": [0, 0, 10]},
     {"class": {"mat": True, "rug": False}}),
    ({"name": "point", "cx": 3, "cy": 4}, {"object": "pin"}),
]  # fmt: skip


@pytest.mark.parametrize("old", [False, True])
@pytest.mark.parametrize("project", [False, True])
def test_via(tmp_path: Path, old: bool, project: bool) -> None:
    document = via(*KINDS, old=old)
    if project:
        document = {"_via_settings": {}, "_via_img_metadata": document}
    assert boxes(beside(written(tmp_path, document))) == {
        "glass-0": [80, 40, 20, 10], "cup-0": [45, 45, 10, 10], "plate-0": [40, 30, 20, 40],
        "mat-0": [0, 0, 10, 10], "pin-0": [],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("bad", "match"),
    [
        ((RECT, {}), "one attribute with the class"),
        ((RECT, {"a": "x", "b": "y"}), "one attribute with the class"),
        ((RECT, {"class": {"mat": True, "rug": True}}), "one attribute with the class"),
        (({"name": "polyline", "all_points_x": [0], "all_points_y": [0]}, {"a": "x"}), "rect"),
        (({"name": "polygon", "all_points_x": [0, 1, 1], "all_points_y": [0, 1]}, {"a": "x"}),
         "3 numbers"),
        (({"name": "rect", "x": 1}, {"a": "x"}), "a number"),
    ],
)  # fmt: skip
def test_via_regions_that_cannot_be_read(tmp_path: Path, bad: Any, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        beside(written(tmp_path, via((RECT, {"class": "glass"}), bad)))
    assert "region 1" in str(caught.value)


# Supervisely


def supervisely(*objects: dict[str, Any]) -> dict[str, Any]:
    return {"description": "", "tags": [], "size": {"height": HEIGHT, "width": WIDTH},
            "objects": [*objects]}  # fmt: skip


def thing(kind: str, title: str = "glass", **more: Any) -> dict[str, Any]:
    return {"classTitle": title, "geometryType": kind, **more}


def bitmap(mask: np.ndarray, x: float, y: float) -> dict[str, Any]:
    data = base64.b64encode(zlib.compress(png64(mask))).decode()
    return {"data": data, "origin": [x, y]}


def test_supervisely(tmp_path: Path) -> None:
    document = supervisely(
        thing("rectangle", points={"exterior": [[80, 40], [100, 50]], "interior": []}),
        thing("polygon", "plate", points={"exterior": [[0, 0], [10, 0], [10, 10]]}),
        thing("bitmap", "cup", bitmap=bitmap(CUT, 50, 60)),
        thing("point", "pin", points={"exterior": [[3, 4]]}),
    )
    found = beside(written(tmp_path, document, "ann/table.png.json"), "ann")
    assert boxes(found) == {
        "glass-0": [80, 40, 20, 10], "plate-0": [0, 0, 10, 10], "cup-0": [50, 60, 4, 2],
        "pin-0": [],
    }  # fmt: skip
    assert isinstance(found[2].footprint, MultiPolygon)


@pytest.mark.parametrize(
    ("bad", "match"),
    [
        (thing("line", points={"exterior": [[0, 0], [1, 1]]}), "rectangle, polygon"),
        (thing("bitmap", bitmap={"data": "AAAA", "origin": [0, 0]}), "base64"),
        (thing("bitmap", bitmap=bitmap(BLOCK & False, 0, 0)), "at least one pixel"),
        (thing("bitmap"), "at least 1 points"),
        (thing("rectangle", points={"exterior": [[0, 0]]}), "at least 2 points"),
    ],
)
def test_supervisely_objects_that_cannot_be_read(
    tmp_path: Path, bad: dict[str, Any], match: str
) -> None:
    with pytest.raises(InputError, match=match):
        beside(written(tmp_path, supervisely(bad), "table.png.json"), "table.png.json")


# YOLO


def yolo(folder: Path, text: str, names: str = "glass\nplate\n", file: str = "classes.txt") -> Path:
    written(folder, text, "labels/table.txt")
    (folder / file).write_text(names)
    return folder


@pytest.mark.parametrize(
    ("file", "names"),
    [
        ("classes.txt", "glass\nplate\n"),
        ("labels/classes.txt", "glass\nplate"),
        ("data.yaml", "names: [glass, plate]\nnc: 2\n"),
        ("data.yaml", "names:\n  0: glass\n  1: plate\n"),
    ],
)
def test_yolo(tmp_path: Path, file: str, names: str) -> None:
    if file.endswith("yaml"):
        pytest.importorskip("yaml", reason="pip install 'demospec[objects]'")
    text = "1 0.5 0.5 0.1 0.2\n0 0.1 0.1 0.2 0.1 0.2 0.2\n\n"
    folder = yolo(tmp_path, text, names, file)
    assert boxes(beside(folder, "labels")) == {
        "plate-0": [90, 40, 20, 20], "glass-0": [20, 10, 20, 10],
    }  # fmt: skip


def test_yolo_shares_follow_the_picture(tmp_path: Path) -> None:
    folder = yolo(tmp_path, "1 0.5 0.5 0.1 0.2\n")
    picture(folder / "table.png", (100, 300))
    assert boxes(beside(folder, "labels")) == {"plate-0": [45, 120, 10, 60]}


def test_yolo_without_a_picture_is_refused(tmp_path: Path) -> None:
    folder = yolo(tmp_path, "1 0.5 0.5 0.1 0.2\n")
    (folder / "labels/table.txt").rename(folder / "labels/scene.txt")
    with pytest.raises(InputError, match="shares of its size"):
        things(folder / "run.csv", objects="labels")


def test_an_empty_yolo_file_is_an_empty_table(tmp_path: Path) -> None:
    assert beside(yolo(tmp_path, ""), "labels") == ()


@pytest.mark.parametrize(
    ("line", "match"),
    [
        ("7 0.5 0.5 0.1 0.2", "a class of classes.txt"),
        ("glass 0.5 0.5 0.1 0.2", "a class of classes.txt"),
        ("1 0.5 0.5 0.1 0.2 0.93", "5 numbers"),
        ("1 0.5 0.5 0.1", "3 numbers"),
        ("1 90 40 20 20", "shares of the picture"),
        ("1 0.5 0.5 x 0.2", "numbers"),
    ],
)
def test_yolo_lines_that_cannot_be_read(tmp_path: Path, line: str, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        beside(yolo(tmp_path, f"1 0.5 0.5 0.1 0.2\n{line}\n"), "labels")
    assert "line 2" in str(caught.value)


def test_yolo_without_names_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the names of the classes"):
        beside(written(tmp_path, "0 0.5 0.5 0.1 0.2\n", "labels/table.txt"), "labels")


# Drawn exports as lists of objects


def test_drawn_exports_list_objects_too(tmp_path: Path) -> None:
    coco(tmp_path)
    plate = region("rectangle", "a", "plate", x=10, y=10, width=10, height=20, rotation=0)
    export = studio(tmp_path / "studio", [annotation(way(), plate)])
    document = json.loads(export.read_text())
    document[0]["data"]["image"] = "/data/upload/3/table.png"
    export.write_text(json.dumps(document))
    assert list(boxes(beside(tmp_path, "studio/export.json"))) == ["plate-0"]
    file = cvat(tmp_path / "cvat", '<box label="mat" xtl="1" ytl="1" xbr="9" ybr="9"/>')
    file.write_text(file.read_text().replace("a.png", "table.png"))
    assert list(boxes(beside(tmp_path, "cvat/annotations.xml"))) == ["mat-0"]


@pytest.mark.parametrize("document", ["[]", "{}", '{"a": 1}', "3", '{"images": []}'])
def test_what_lists_no_objects_is_refused(tmp_path: Path, document: str) -> None:
    with pytest.raises(InputError, match=r"objects\.json"):
        beside(written(tmp_path, document))
