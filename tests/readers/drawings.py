"""Exports of annotation tools, small and of chosen content."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations.readers import Mapping, read_source
from demospec.scene import Scene, SceneObject

WIDTH, HEIGHT = 200, 100


def picture(file: Path, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Path:
    import PIL.Image

    file.parent.mkdir(parents=True, exist_ok=True)
    PIL.Image.new("RGB", size, (90, 120, 80)).save(file)
    return file


def region(kind: str, key: str = "r", label: str | None = None, **value: Any) -> dict[str, Any]:
    """An entry of Label Studio's results; places are per cent."""
    if label is not None:
        value[f"{kind}labels"] = [label]
    return {
        "id": key, "type": f"{kind}labels", "from_name": "shape", "to_name": "image",
        "original_width": WIDTH, "original_height": HEIGHT, "image_rotation": 0, "value": value,
    }  # fmt: skip


def way(key: str = "p", label: str = "good", bulge: float = 30.0) -> dict[str, Any]:
    corners = [{"x": 5, "y": 50}, {"x": 50, "y": 50 - bulge}, {"x": 95, "y": 50}]
    return region("vector", key, label, vertices=corners)


def answer(key: str, question: str, *words: str) -> dict[str, Any]:
    return {"id": key, "type": "choices", "from_name": question, "value": {"choices": [*words]}}


def annotation(*results: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"id": more.pop("number", 1), "result": [*results], **more}


def studio(folder: Path, *tasks: list[dict[str, Any]], size: tuple[int, int] | None = None) -> Path:
    """A Label Studio export: one list of annotations a task, with pictures beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    document = []
    for i, done in enumerate(tasks, start=1):
        picture(folder / f"{i}.png", size or (WIDTH, HEIGHT))
        document.append({"id": i, "data": {"image": f"{i}.png"}, "annotations": done})
    (folder / "export.json").write_text(json.dumps(document))
    return folder / "export.json"


def cvat(folder: Path, *shapes: str, image: str = "", size: tuple[int, int] | None = None) -> Path:
    """ "CVAT for images" with one picture and one path."""
    picture(folder / "a.png", size or (WIDTH, HEIGHT))
    text = "".join(shapes)
    (folder / "annotations.xml").write_text(
        f'<annotations><image id="0" name="a.png" width="{WIDTH}" height="{HEIGHT}" {image}>'
        f'<polyline label="good" points="10,50;100,20;190,50"/>{text}</image></annotations>'
    )
    return folder / "annotations.xml"


def coco(
    folder: Path,
    *annotations: dict[str, Any],
    images: list[dict[str, Any]] | None = None,
    size: tuple[int, int] = (WIDTH, HEIGHT),
) -> Path:
    """A COCO file of a glass and a plate, beside a path over its picture; the folder."""
    picture(folder / "table.png", size)
    (folder / "run.csv").write_text("x,y\n10,50\n100,20\n190,50\n")
    if images is None:
        images = [{"id": 1, "file_name": "table.png", "width": WIDTH, "height": HEIGHT}]
    document = {
        "images": images, "categories": [{"id": 1, "name": "glass"}, {"id": 2, "name": "plate"}],
        "annotations": [{"id": i, "image_id": 1, "category_id": 1, **a}
                        for i, a in enumerate(annotations)],
    }  # fmt: skip
    (folder / "objects.json").write_text(json.dumps(document))
    return folder


def scenes(source: Path, **more: Any) -> tuple[Scene, ...]:
    return read_source(source, mapping=Mapping(**more)).data.scenes


def things(source: Path, **more: Any) -> tuple[SceneObject, ...]:
    """The objects of the only scene."""
    (scene,) = scenes(source, **more)
    return scene.listed_objects()


def beside(folder: Path, objects: str = "objects.json", **more: Any) -> tuple[SceneObject, ...]:
    """The objects that a file lists for the picture of a folder made by `coco`."""
    return things(folder / "run.csv", picture="table.png", objects=objects, **more)


def boxes(items: tuple[SceneObject, ...]) -> dict[str, list[float]]:
    return {o.id: [round(v, 6) for v in o.bbox or ()] for o in items}


def brush(mask: np.ndarray) -> list[int]:
    """A mask (h, w) as Label Studio's run lengths: one value a run, 16 bits a length."""
    values = np.repeat(mask.astype(np.uint8).ravel() * 255, 4)
    bits = f"{len(values):032b}{7:05b}" + f"{15:04b}" * 4
    ends = [*(np.flatnonzero(np.diff(values)) + 1), len(values)]
    start = 0
    for end in sorted({*ends, *range(1 << 16, len(values), 1 << 16)}):
        bits += "1" + "00" + f"{end - start - 1:016b}" + f"{values[start]:08b}"
        start = end
    bits += "0" * (-len(bits) % 8)
    return [int(bits[i : i + 8], 2) for i in range(0, len(bits), 8)]


def png64(mask: np.ndarray) -> bytes:
    """A mask as a PNG of one bit a pixel."""
    import io

    import PIL.Image

    data = io.BytesIO()
    PIL.Image.fromarray(mask.astype(bool)).save(data, format="PNG")
    return data.getvalue()
