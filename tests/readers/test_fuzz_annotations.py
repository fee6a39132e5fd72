"""Annotations with spoilt values: the objects or one line that names the file, never a traceback.

Where `test_fuzz_readers.py` spoils bytes, here whole files stay readable and single values become
others: of another type, missing, doubled, huge.
"""

from __future__ import annotations

import base64
import copy
import json
import os
import random
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawings import annotation, answer, brush, cvat, png64, region, studio, way

from demospec.demonstrations.readers import Mapping, read_source
from demospec.demonstrations.readers.annotations._objects import read_objects
from demospec.errors import DemospecError

ROUNDS = max(5, int(os.environ.get("DEMOSPEC_FUZZ_EXAMPLES", "50")) // 4)
TRACKS = (
    "<annotations><meta><task><original_size><width>200</width><height>100</height>"
    '</original_size></task></meta><track id="1" label="hand">'
    '<box frame="0" outside="0" xtl="1" ytl="1" xbr="9" ybr="9"/>'
    '<box frame="1" outside="0" xtl="21" ytl="1" xbr="29" ybr="9"/></track>'
    '<track id="2" label="cup"><box frame="0" outside="0" xtl="1" ytl="1" xbr="9" ybr="9"/>'
    "</track></annotations>"
)
MASK = np.zeros((100, 200), dtype=bool)
MASK[10:20, 30:50] = True
JUNK: list[Any] = [
    None, True, -1, 0, 0.5, 1e308, 10**40, "", "x", "1e9", [], [1], [[1, 2]], {}, {"a": 1},
    float("nan"), [None, None], [1, "x"], {"x": 1, "y": 2},
]  # fmt: skip


def coco_seed() -> Any:
    runs = [2010, 10, 200 * 100 - 2020]
    return {
        "images": [{"id": 1, "file_name": "a.png", "width": 200, "height": 100}],
        "categories": [{"id": 1, "name": "glass"}],
        "annotations": [
            {"id": 1, "image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4],
             "attributes": {"rotation": 30}},
            {"id": 2, "image_id": 1, "category_id": 1, "iscrowd": 0,
             "segmentation": [[1, 2, 3, 4, 5, 9], [10, 10, 20, 10, 20, 20]]},
            {"id": 3, "image_id": 1, "category_id": 1,
             "segmentation": {"size": [100, 200], "counts": runs}},
        ],
    }  # fmt: skip


def labelme_seed() -> Any:
    mask = base64.b64encode(png64(MASK[10:20, 30:50])).decode()
    return {
        "imagePath": "a.png", "imageWidth": 200, "imageHeight": 100,
        "shapes": [
            {"label": "a", "shape_type": "polygon", "points": [[1, 2], [3, 4], [5, 9]],
             "group_id": 1},
            {"label": "a", "shape_type": "rectangle", "points": [[1, 2], [3, 4]], "group_id": 1},
            {"label": "c", "shape_type": "circle", "points": [[1, 2], [3, 4]]},
            {"label": "d", "shape_type": "mask", "points": [[30, 10], [49, 19]], "mask": mask},
            {"label": "e", "shape_type": "point", "points": [[30, 10]]},
        ],
    }  # fmt: skip


def via_seed() -> Any:
    shapes = [
        {"name": "rect", "x": 1, "y": 2, "width": 3, "height": 4},
        {"name": "ellipse", "cx": 1, "cy": 2, "rx": 3, "ry": 4, "theta": 0.1},
        {"name": "polygon", "all_points_x": [1, 2, 3], "all_points_y": [1, 5, 3]},
    ]
    regions = [{"shape_attributes": s, "region_attributes": {"class": "a"}} for s in shapes]
    return {"a.png9": {"filename": "a.png", "size": 9, "regions": regions}}


def supervisely_seed() -> Any:
    data = base64.b64encode(zlib.compress(png64(MASK[10:20, 30:50]))).decode()
    return {
        "size": {"width": 200, "height": 100},
        "objects": [
            {"classTitle": "a", "geometryType": "polygon",
             "points": {"exterior": [[1, 2], [3, 4], [5, 9]], "interior": []}},
            {"classTitle": "a", "geometryType": "bitmap",
             "bitmap": {"origin": [3, 4], "data": data}},
        ],
    }  # fmt: skip


def studio_seed(folder: Path) -> Any:
    shapes = [
        region("rectangle", "a", "plate", x=10, y=10, width=10, height=20, rotation=30),
        region("ellipse", "b", "cup", x=50, y=50, radiusX=10, radiusY=5, rotation=0),
        region("polygon", "c", "mat", points=[[1, 1], [9, 1], [9, 9]]),
        region("keypoint", "d", "pin", x=1, y=2, width=1),
        region("brush", "e", "bowl", format="rle", rle=brush(MASK)),
    ]
    done = annotation(way(), *shapes, answer("p", "valid", "yes"), completed_by=3)
    again = annotation(way("q"), *copy.deepcopy(shapes), number=2, completed_by=4)
    return json.loads(studio(folder, [done, again]).read_text())


def places(document: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to every value of a document."""
    if at:
        yield at
    if isinstance(document, dict):
        for key, value in document.items():
            yield from places(value, (*at, key))
    elif isinstance(document, list):
        for i, value in enumerate(document[:6]):
            yield from places(value, (*at, i))


def spoilt(document: Any, rng: random.Random) -> Any:
    """The document with one to three values replaced, taken away or doubled."""
    out = copy.deepcopy(document)
    for _ in range(rng.randint(1, 3)):
        every = list(places(out))
        if not every:
            break
        way_to = rng.choice(every)
        holder = out
        for step in way_to[:-1]:
            holder = holder[step]
        last, how = way_to[-1], rng.random()
        if how < 0.15:
            del holder[last]
        elif how < 0.3 and isinstance(holder, list):
            holder.append(copy.deepcopy(holder[last]))
        else:
            holder[last] = copy.deepcopy(rng.choice(JUNK))
    return out


def survives(read: Callable[[], object]) -> bool:
    """Whether it was read; a refusal must be one line."""
    try:
        read()
    except DemospecError as error:
        refusal = str(error)
    else:
        return True
    assert "\n" not in refusal
    return False


@pytest.mark.parametrize("seed", [coco_seed, labelme_seed, via_seed, supervisely_seed])
def test_spoilt_lists_of_objects(seed: Callable[[], Any], tmp_path: Path) -> None:
    if seed is coco_seed:
        pytest.importorskip("pycocotools", reason="pip install 'demospec[objects]'")
    file = tmp_path / "a.png.json"
    rng = random.Random(seed.__name__)
    file.write_text(json.dumps(seed()))
    assert survives(lambda: read_objects(file))
    for _ in range(4 * ROUNDS):
        file.write_text(json.dumps(spoilt(seed(), rng)))
        survives(lambda: read_objects(file))


def test_spoilt_exports_of_label_studio(tmp_path: Path) -> None:
    document = studio_seed(tmp_path)
    file, rng = tmp_path / "export.json", random.Random(1)
    assert survives(lambda: read_source(file, format="label-studio"))
    for _ in range(3 * ROUNDS):
        file.write_text(json.dumps(spoilt(document, rng)))
        survives(lambda: read_source(file, format="label-studio"))


def test_spoilt_exports_of_cvat(tmp_path: Path) -> None:
    import xml.etree.ElementTree as ElementTree

    shapes = (
        '<box label="a" xtl="1" ytl="2" xbr="9" ybr="8" rotation="30"/>',
        '<ellipse label="b" cx="5" cy="5" rx="3" ry="2"/>',
        '<mask label="c" left="1" top="2" width="3" height="2" rle="1,4,1"/>',
        '<points label="d" points="3,4"><attribute name="radius">2</attribute></points>',
        '<polygon label="e" points="0,0;5,0;5,5"/>',
    )
    rng = random.Random(2)
    for text in (cvat(tmp_path, *shapes).read_text(), TRACKS):
        file = tmp_path / "annotations.xml"
        file.write_text(text)
        assert survives(lambda file=file: read_source(file))
        for _ in range(2 * ROUNDS):
            root = ElementTree.fromstring(text)
            for _ in range(rng.randint(1, 3)):
                element = rng.choice([e for e in root.iter() if e.attrib])
                name = rng.choice(list(element.attrib))
                if rng.random() < 0.2:
                    del element.attrib[name]
                else:
                    element.set(name, rng.choice(["", "x", "-1", "1e400", "nan", "1,2", "0", ";"]))
            file.write_text(ElementTree.tostring(root, encoding="unicode"))
            survives(lambda file=file: read_source(file, mapping=Mapping(valid="none")))
