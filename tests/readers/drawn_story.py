"""Two drawn paths and three objects of one picture, and ways to write the same or damage it."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from demospec.demonstrations import DemonstrationSet

WIDTH, HEIGHT = 400, 200
PATHS = {"p1": ([(40, 100), (200, 120), (360, 100)], True),
         "p2": ([(40, 60), (200, 90), (360, 140)], False)}  # fmt: skip
BOXES = {"glass": (100, 20, 40, 60), "plate": (220, 30, 60, 20)}
CORNERS = [(300, 150), (340, 150), (340, 180), (300, 180)]
"""Of the bowl, which is drawn as a polygon."""

Write = Callable[[Path], Path]


def label_studio() -> list[Any]:
    """The export of Label Studio."""

    def region(key: str, kind: str, value: dict[str, Any]) -> dict[str, Any]:
        return {"id": key, "type": kind, "original_width": WIDTH, "original_height": HEIGHT,
                "image_rotation": 0, "to_name": "image", "value": value}  # fmt: skip

    def percent(points: list[tuple[int, int]]) -> list[list[float]]:
        return [[100 * x / WIDTH, 100 * y / HEIGHT] for x, y in points]

    result = []
    for name, (points, valid) in PATHS.items():
        vertices = [{"x": x, "y": y} for x, y in percent(points)]
        word = "good" if valid else "bad"
        result.append(region(name, "vectorlabels", {"vertices": vertices, "vectorlabels": [word]}))
    for symbol, (x, y, w, h) in BOXES.items():
        value = {"x": 100 * x / WIDTH, "y": 100 * y / HEIGHT, "width": 100 * w / WIDTH,
                 "height": 100 * h / HEIGHT, "rectanglelabels": [symbol]}  # fmt: skip
        result.append(region(symbol, "rectanglelabels", value))
    value = {"points": percent(CORNERS), "polygonlabels": ["bowl"], "closed": True}
    result.append(region("bowl", "polygonlabels", value))
    task = {"id": 1, "data": {"image": "table.png"},
            "annotations": [{"id": 1, "completed_by": 1, "result": result}]}  # fmt: skip
    return [task]


def _written(document: Any, name: str) -> Write:
    def write(folder: Path) -> Path:
        text = document if isinstance(document, str) else json.dumps(document)
        (folder / name).write_text(text)
        return folder / name

    return write


def label_studio_changes() -> Iterator[tuple[str, Write]]:
    """Label Studio's export, changed."""

    def case(what: str, change: Callable[[list[Any]], object]) -> tuple[str, Write]:
        document = copy.deepcopy(label_studio())
        change(document)
        return what, _written(document, "a.json")

    def regions(d: list[Any]) -> list[dict[str, Any]]:
        return list(d[0]["annotations"][0]["result"])

    yield case("as it is", lambda d: None)
    yield case("regions reversed", lambda d: d[0]["annotations"][0]["result"].reverse())
    for k in range(5):

        def turned(d: list[Any], k: int = k) -> None:
            d[0]["annotations"][0]["result"] = regions(d)[k:] + regions(d)[:k]

        yield case(f"regions rotated by {k}", turned)
        for key in ("id", "type", "value", "original_width", "original_height"):
            yield case(f"region {k} without {key}", lambda d, k=k, key=key: regions(d)[k].pop(key))
            yield case(
                f"region {k} with {key} renamed",
                lambda d, k=k, key=key: regions(d)[k].update({key + "_": regions(d)[k].pop(key)}),
            )
        for key in ("original_width", "original_height"):
            for value in (800, 0, -400, "400", None, True, 1e308):
                yield case(
                    f"region {k} with {key} {value!r}",
                    lambda d, k=k, key=key, value=value: regions(d)[k].update({key: value}),
                )
        yield case(
            f"region {k} twice",
            lambda d, k=k: d[0]["annotations"][0]["result"].append(copy.deepcopy(regions(d)[k])),
        )
        yield case(
            f"region {k} of a kind that nobody knows",
            lambda d, k=k: regions(d)[k].update({"type": "hologram"}),
        )
        yield case(
            f"region {k} in a picture that was turned",
            lambda d, k=k: regions(d)[k].update({"image_rotation": 90}),
        )
    for k, key in ((2, "x"), (2, "width"), (3, "height"), (3, "y")):
        for value in (None, "10", float("nan"), [1], -1e308):
            yield case(
                f"box {k} with {key} {value!r}",
                lambda d, k=k, key=key, value=value: regions(d)[k]["value"].update({key: value}),
            )
    for k, (x, y, w, h) in enumerate(BOXES.values()):
        # The same box, drawn from another corner and turned about it (in square pixels).
        for angle, (cx, cy, cw, ch) in {
            90: (x + w, y, h, w), 180: (x + w, y + h, w, h), 270: (x, y + h, h, w),
            360: (x, y, w, h),
        }.items():  # fmt: skip
            value = {"x": 100 * cx / WIDTH, "y": 100 * cy / HEIGHT, "width": 100 * cw / WIDTH,
                     "height": 100 * ch / HEIGHT, "rotation": angle}  # fmt: skip
            yield case(
                f"box {k} turned by {angle}",
                lambda d, k=k, value=value: regions(d)[2 + k]["value"].update(value),
            )
    for k in range(1, 4):
        yield case(
            f"polygon begins at corner {k}",
            lambda d, k=k: regions(d)[4]["value"].update(
                {
                    "points": regions(d)[4]["value"]["points"][k:]
                    + regions(d)[4]["value"]["points"][:k]
                }
            ),
        )
    yield case("polygon the other way round", lambda d: regions(d)[4]["value"]["points"].reverse())
    yield case(
        "polygon of two points",
        lambda d: regions(d)[4]["value"].update({"points": regions(d)[4]["value"]["points"][:2]}),
    )
    yield case(
        "cancelled beside",
        lambda d: d[0]["annotations"].append(
            {**copy.deepcopy(d[0]["annotations"][0]), "id": 2, "was_cancelled": True}
        ),
    )
    yield case(
        "skipped task beside",
        lambda d: d.append(
            {
                "id": 2,
                "data": {"image": "b.png"},
                "annotations": [{"was_cancelled": True, "result": []}],
            }
        ),
    )
    yield case("the task twice", lambda d: d.append(copy.deepcopy(d[0])))
    yield case("completions", lambda d: d[0].update({"completions": d[0].pop("annotations")}))
    yield case("the picture's key renamed", lambda d: d[0].update({"data": {"photo": "table.png"}}))


def cvat() -> str:
    """CVAT's XML."""
    lines = [f'<annotations><image id="0" name="table.png" width="{WIDTH}" height="{HEIGHT}">']
    for points, valid in PATHS.values():
        text = ";".join(f"{x},{y}" for x, y in points)
        lines.append(f'<polyline label="path" points="{text}"><attribute name="valid">'
                     f'{"good" if valid else "bad"}</attribute></polyline>')  # fmt: skip
    for symbol, (x, y, w, h) in BOXES.items():
        lines.append(f'<box label="{symbol}" xtl="{x}" ytl="{y}" xbr="{x + w}" ybr="{y + h}"/>')
    text = ";".join(f"{x},{y}" for x, y in CORNERS)
    lines += [f'<polygon label="bowl" points="{text}"/>', "</image></annotations>"]
    return "\n".join(lines)


def cvat_changes() -> Iterator[tuple[str, Write]]:
    """CVAT's XML, changed."""
    whole = cvat()
    lines = whole.split("\n")
    yield "as it is", _written(whole, "a.xml")
    inner = lines[1:-1]
    for k in range(1, len(inner)):
        turned = [lines[0], *inner[k:], *inner[:k], lines[-1]]
        yield f"shapes rotated by {k}", _written("\n".join(turned), "a.xml")
    for k, line in enumerate(inner):
        unknown = line.replace("<polyline", "<spline").replace("</polyline", "</spline")
        unknown = unknown.replace("<box", "<cuboid").replace("<polygon", "<hologram")
        changed = [lines[0], *(unknown if j == k else x for j, x in enumerate(inner)), lines[-1]]
        yield f"shape {k} of another kind", _written("\n".join(changed), "a.xml")
    for old, new in (
        ("points=", "corners="), ("label=", "class="), ("xtl=", "left="), ("ybr=", "bottom="),
        ('name="table.png"', ""), ("40,100;", "40;100;"), ("40,100;", "40,nan;"),
        ('xtl="100"', 'xtl="1e400"'), ('xbr="140"', 'xbr="60"'), ('ytl="20"', 'ytl=""'),
        ("good", "perhaps"), ('name="valid"', 'name="verdict"'), ("<annotations>", "<marks>"),
        (".png", ".PNG"), ('width="400"', 'width="none"'), ('width="400"', 'width="0"'),
        ('id="0"', 'id="7"'), ('"40,100;', '"40.0,100.00;'), ('xtl="100"', 'xtl="1.0e2"'),
        ('<box label="glass"', '<box occluded="1" label="glass"'),
    ):  # fmt: skip
        yield f"{old} → {new}", _written(whole.replace(old, new), "a.xml")
    for symbol, (x, y, w, h) in BOXES.items():
        plain = f'<box label="{symbol}" xtl="{x}" ytl="{y}" xbr="{x + w}" ybr="{y + h}"/>'
        cx, cy = x + w / 2, y + h / 2
        for angle, (tw, th) in {90: (h, w), 180: (w, h), 270: (h, w), 360: (w, h)}.items():
            other = (f'<box label="{symbol}" xtl="{cx - tw / 2}" ytl="{cy - th / 2}" '
                     f'xbr="{cx + tw / 2}" ybr="{cy + th / 2}" rotation="{angle}"/>')  # fmt: skip
            yield f"{symbol} turned by {angle}", _written(whole.replace(plain, other), "a.xml")


def coco() -> dict[str, Any]:
    """COCO's document, for a table of paths beside it."""
    names = ["glass", "plate", "bowl"]
    boxes = [*BOXES.values(), (300, 150, 40, 30)]
    return {
        "images": [{"id": 4, "file_name": "table.png", "width": WIDTH, "height": HEIGHT}],
        "categories": [{"id": 10 + i, "name": n} for i, n in enumerate(names)],
        "annotations": [
            {"id": i, "image_id": 4, "category_id": 10 + i, "bbox": list(b), "iscrowd": 0}
            | ({"segmentation": [[v for c in CORNERS for v in c]]} if i == 2 else {})
            for i, b in enumerate(boxes)
        ],
    }


def coco_changes() -> Iterator[tuple[str, Write]]:
    """COCO's document, changed."""

    def case(what: str, change: Callable[[dict[str, Any]], object]) -> tuple[str, Write]:
        document = copy.deepcopy(coco())
        change(document)

        def write(folder: Path) -> Path:
            (folder / "objects.json").write_text(json.dumps(document))
            rows = [(n, x, y, v) for n, (points, v) in PATHS.items() for x, y in points]
            text = "".join(f"{n},{x},{y},{int(v)}\n" for n, x, y, v in rows)
            (folder / "paths.csv").write_text("demo_id,x,y,valid\n" + text)
            return folder / "paths.csv"

        return what, write

    yield case("as it is", lambda d: None)
    for key in ("images", "categories", "annotations"):
        yield case(f"{key} reversed", lambda d, key=key: d[key].reverse())
        yield case(f"{key} renamed", lambda d, key=key: d.update({key + "_": d.pop(key)}))
        yield case(f"{key} twice", lambda d, key=key: d[key].append(copy.deepcopy(d[key][0])))
        yield case(f"{key} as an object", lambda d, key=key: d.update({key: {"0": d[key]}}))
        yield case(f"{key} with one that is none", lambda d, key=key: d[key].append(None))
    for key in ("image_id", "category_id", "bbox", "id"):
        for k in range(3):
            yield case(
                f"annotation {k} without {key}",
                lambda d, k=k, key=key: d["annotations"][k].pop(key),
            )
            for value in (None, "4", 4.0, [4], True, 99):
                yield case(
                    f"annotation {k} with {key} {value!r}",
                    lambda d, k=k, key=key, value=value: d["annotations"][k].update({key: value}),
                )
    for k, (x, y, w, h) in enumerate(BOXES.values()):
        cx, cy = x + w / 2, y + h / 2
        for angle, (tw, th) in {90: (h, w), 180: (w, h), 270: (h, w), 0: (w, h)}.items():
            change = {"bbox": [cx - tw / 2, cy - th / 2, tw, th], "attributes": {"rotation": angle}}
            yield case(
                f"box {k} turned by {angle}",
                lambda d, k=k, change=change: d["annotations"][k].update(change),
            )
        halves = [[x, y, x + w / 2, y, x + w / 2, y + h, x, y + h],
                  [x + w / 2, y, x + w, y, x + w, y + h, x + w / 2, y + h]]  # fmt: skip
        yield case(
            f"box {k} in two parts",
            lambda d, k=k, halves=halves: d["annotations"][k].update({"segmentation": halves}),
        )
        for wrong in (
            [[1, 2, 3]],
            [[1, 2, 3, 4]],
            "RLE",
            {"counts": "x", "size": [1]},
            [["a"] * 6],
            7,
        ):
            yield case(
                f"box {k} with segmentation {wrong!r}",
                lambda d, k=k, wrong=wrong: d["annotations"][k].update({"segmentation": wrong}),
            )
    for value in (
        "images/table.png",
        "images\\table.png",
        "/data/table.png",
        "TABLE.png",
        "b.png",
        "",
    ):
        yield case(
            f"file name {value!r}",
            lambda d, value=value: d["images"][0].update({"file_name": value}),
        )
    for size in ((800, 400), (200, 100), (200, 200), (0, 0), ("400", "200"), (None, None)):

        def resized(d: dict[str, Any], size: Any = size) -> None:
            d["images"][0].update({"width": size[0], "height": size[1]})
            ok = isinstance(size[0], int) and size[0]
            f = size[0] / WIDTH if ok else 1
            for a in d["annotations"]:
                a["bbox"] = [v * f for v in a["bbox"]]
                if "segmentation" in a:
                    a["segmentation"] = [[v * f for v in a["segmentation"][0]]]

        yield case(f"made on a picture of {size}", resized)
    yield case(
        "the picture under two ids",
        lambda d: (
            d["images"].append({**d["images"][0], "id": 5}),
            d["annotations"][0].update({"image_id": 5}),
        ),
    )
    yield case(
        "another picture beside", lambda d: d["images"].append({"id": 6, "file_name": "b.png"})
    )


def other_drawing(data: DemonstrationSet, notes: tuple[str, ...]) -> str | None:
    """How a set differs from the drawing: None where it says the same, or less and says so."""
    items = list(data.demonstrations)
    if len(items) != len(PATHS):
        return f"{len(items)} paths"
    wanted = {tuple(points): valid for points, valid in PATHS.values()}
    for item in items:
        key = tuple((round(x, 6), round(y, 6)) for x, y in item.points[:, :2].tolist())
        if key not in wanted:
            return f"another path {key}"
        if item.valid is not wanted[key] and not (
            item.valid is None and any(n.startswith("valid: none") for n in notes)
        ):
            return f"valid {item.valid}"
    boxes = sorted([*BOXES.items(), ("bowl", (300, 150, 40, 30))])
    for scene in data.scenes:
        found = sorted((o.symbol, o.outline.bounds) for o in scene.objects or ())
        if len(found) != len(boxes):
            return f"objects {[s for s, _ in found]}"
        for (symbol, (x, y, w, h)), (said, bounds) in zip(boxes, found, strict=True):
            gaps = [abs(a - b) for a, b in zip(bounds, (x, y, x + w, y + h), strict=True)]
            if symbol != said or max(gaps) > 1e-6:
                return f"{said} at {bounds}"
    return None
