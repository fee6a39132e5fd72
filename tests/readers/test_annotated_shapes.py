"""Shapes of annotation tools as footprints: none is read as another, none is lost."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest
from drawings import (
    HEIGHT,
    WIDTH,
    annotation,
    answer,
    beside,
    boxes,
    brush,
    coco,
    cvat,
    png64,
    region,
    scenes,
    studio,
    things,
    way,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.demonstrations.readers import Mapping, read_source
from demospec.demonstrations.readers.annotations._shapes import box, ellipse, mask_outline
from demospec.errors import InputError
from demospec.geometry import MultiPolygon, Polygon

BLOCK = np.zeros((HEIGHT, WIDTH), dtype=bool)
BLOCK[30:50, 80:120] = True


def area(shape: object) -> float:
    assert isinstance(shape, Polygon)
    x, y = shape.vertices.T
    return float(abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2)


@given(st.floats(-720, 720), st.sampled_from(["centre", "corner"]))
def test_a_turned_box_keeps_what_it_turns_about(turn: float, about: str) -> None:
    shape = box(10, 20, 40, 10, turn, about=about)
    assert area(shape) == pytest.approx(400)
    where = [10, 20] if about == "corner" else [30, 25]
    depth = float(shape.signed_distance(where))
    assert depth == pytest.approx(0.0 if about == "corner" else -5.0, abs=1e-9)


def test_a_quarter_turn_is_exact_and_clockwise_as_seen() -> None:
    assert box(100, 50, 40, 10, 90, about="corner").bounds == (90, 50, 100, 90)
    assert box(100, 50, 40, 10, -90, about="corner").bounds == (100, 10, 110, 50)
    assert box(100, 50, 40, 10, 90).bounds == (115, 35, 125, 75)


@given(st.floats(1, 50), st.floats(1, 50), st.floats(-180, 180))
def test_an_ellipse_is_near_its_polygon(rx: float, ry: float, turn: float) -> None:
    shape = ellipse(100, 100, rx, ry, turn)
    angle, t = np.deg2rad(turn), np.linspace(0, 2 * np.pi, 500)
    x, y = rx * np.cos(t), ry * np.sin(t)
    c, s = np.cos(angle), np.sin(angle)
    rim = np.stack([100 + c * x - s * y, 100 + s * x + c * y], axis=1)
    assert np.abs(shape.signed_distance(rim)).max() <= 0.0013 * max(rx, ry)


masks = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).random((7, 9)) < 0.5)


@settings(max_examples=30, deadline=None)
@given(masks.filter(lambda m: m.any()))
def test_a_mask_is_covered_by_its_outline(mask: np.ndarray) -> None:
    shape = mask_outline(mask, 5.0, 7.0)
    rows, columns = np.nonzero(mask)
    middles = np.stack([columns + 5.5, rows + 7.5], axis=1)
    assert shape.signed_distance(middles).max() <= -np.sqrt(0.125)
    x0, y0, x1, y1 = shape.bounds
    assert (x0, y0) == (columns.min() + 5, rows.min() + 7)
    assert (x1, y1) == (columns.max() + 6, rows.max() + 8)


def test_a_large_mask_is_thinned_by_half_a_pixel_at_most() -> None:
    y, x = np.mgrid[0:300, 0:300]
    shape = mask_outline(np.hypot(x - 149.5, y - 149.5) < 120)
    assert isinstance(shape, Polygon)
    assert len(shape.vertices) < 200
    angle = np.linspace(0, 2 * np.pi, 1000)
    rim = 150 + 120 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.abs(shape.signed_distance(rim)).max() < 1.2  # half a pixel, and a pixel's corner


def test_parts_of_a_mask_are_parts_and_holes_are_filled() -> None:
    mask = np.zeros((20, 40), dtype=bool)
    mask[2:12, 2:12] = True
    mask[5:8, 5:8] = False
    mask[2:12, 30:35] = True
    shape = mask_outline(mask)
    assert isinstance(shape, MultiPolygon)
    assert sorted(part.bounds for part in shape.parts) == [(2, 2, 12, 12), (30, 2, 35, 12)]
    assert shape.signed_distance([6.5, 6.5]) < -3


# Label Studio


def test_studio_boxes_turn_about_their_corner(tmp_path: Path) -> None:
    turned = region("rectangle", "a", "plate", x=50, y=50, width=20, height=10, rotation=90)
    found = things(studio(tmp_path, [annotation(way(), turned)]))
    assert boxes(found) == {"plate-0": [90, 50, 10, 40]}


def test_studio_ellipses_turn_about_their_centre(tmp_path: Path) -> None:
    round_ = region("ellipse", "a", "glass", x=50, y=50, radiusX=10, radiusY=10, rotation=90)
    found = things(studio(tmp_path, [annotation(way(), round_)]))
    assert boxes(found) == {"glass-0": [90, 30, 20, 40]}  # 20 px wide radius, now upright


def test_studio_polygons_and_boxes_count_within_their_class(tmp_path: Path) -> None:
    shapes = [
        region("rectangle", "a", "plate", x=0, y=0, width=10, height=10, rotation=0),
        region("polygon", "b", "glass", points=[[50, 50], [60, 50], [60, 60]]),
        region("rectangle", "c", "plate", x=80, y=0, width=10, height=10, rotation=0),
    ]
    found = things(studio(tmp_path, [annotation(way(), *shapes)]))
    assert boxes(found) == {
        "plate-0": [0, 0, 20, 10], "glass-0": [100, 50, 20, 10], "plate-1": [160, 0, 20, 10],
    }  # fmt: skip


def test_studio_brushes_are_masks(tmp_path: Path) -> None:
    drawn = region("brush", "a", "glass", format="rle", rle=brush(BLOCK))
    found = things(studio(tmp_path, [annotation(way(), drawn)]))
    assert boxes(found) == {"glass-0": [80, 30, 40, 20]}


def test_studio_bitmasks_are_masks(tmp_path: Path) -> None:
    address = "data:image/png;base64," + base64.b64encode(png64(BLOCK)).decode()
    drawn = region("bitmask", "a", "glass", imageDataURL=address)
    found = things(studio(tmp_path, [annotation(way(), drawn)]))
    assert boxes(found) == {"glass-0": [80, 30, 40, 20]}


def test_studio_points_have_the_radius_that_is_shown(tmp_path: Path) -> None:
    dot = region("keypoint", "a", "cup", x=50, y=50, width=5)
    place = region("keypoint", "b", "tip", x=10, y=10)
    cup, tip = things(studio(tmp_path, [annotation(way(), dot, place)]))
    assert cup.bbox == pytest.approx((90, 40, 20, 20))
    assert (tip.center, tip.footprint) == ((20, 10), None)


@pytest.mark.parametrize(
    ("shape", "match"),
    [
        (region("brush", "a", "glass", format="rle", rle=[0, 0, 0, 1]), "whole run-length mask"),
        (region("brush", "a", "glass", format="rle", rle=brush(BLOCK)[:-3]), "run-length mask"),
        (region("brush", "a", "glass", format="rle", rle=brush(BLOCK[1:])), "80000 values"),
        (region("brush", "a", "glass", format="rle", rle=brush(BLOCK & False)), "one pixel"),
        (region("ellipse", "a", "glass", x=50, y=50, radiusX=0, radiusY=3), "radii above 0"),
        (region("ellipse", "a", "glass", x=50, y=50), "a number"),
        (region("polygon", "a", "glass", points=[[1, 1], [2, 2]]), "at least 3"),
        (region("cuboid", "a", "glass", x=50, y=50), "one of the shapes"),
        (region("rectangle", "a", x=1, y=1, width=2, height=2,
                rectanglelabels=["glass", "plate"]), "one label"),
        ({**region("rectangle", "a", "glass", x=1, y=1, width=2, height=2), "image_rotation": 90},
         "not turned"),
    ],
)  # fmt: skip
def test_studio_shapes_that_cannot_be_read_are_errors(
    tmp_path: Path, shape: dict[str, object], match: str
) -> None:
    with pytest.raises(InputError, match=match) as caught:
        things(studio(tmp_path, [annotation(way(), shape)]))
    assert "region a" in str(caught.value)


def test_a_label_of_its_own_belongs_to_its_shape(tmp_path: Path) -> None:
    bare = region("rectangle", "a", x=10, y=10, width=10, height=10, rotation=0)
    bare["type"] = "rectangle"
    label = {**bare, "type": "labels", "value": {**bare["value"], "labels": ["glass"]}}
    found = things(studio(tmp_path, [annotation(way(), bare, label)]))
    assert boxes(found) == {"glass-0": [20, 10, 20, 10]}


def test_curves_and_closed_outlines_are_no_paths(tmp_path: Path) -> None:
    curve = way()
    curve["value"]["vertices"][1]["controlPoint1"] = {"x": 1, "y": 1}
    with pytest.raises(InputError, match="straight lines"):
        scenes(studio(tmp_path / "a", [annotation(curve)]))
    loop = way()
    loop["value"]["closed"] = True
    with pytest.raises(InputError, match="an open path"):
        scenes(studio(tmp_path / "b", [annotation(loop)]))


# Who annotated


PLATE = region("rectangle", "a", "plate", x=10, y=10, width=10, height=20, rotation=0)


def names(source: Path, **more: object) -> list[str]:
    data = read_source(source, mapping=Mapping(**more)).data  # type: ignore[arg-type]
    return [d.demo_id for d in data.demonstrations]


def test_cancelled_annotations_are_left_out(tmp_path: Path) -> None:
    other = region("rectangle", "b", "glass", x=60, y=10, width=10, height=20, rotation=0)
    source = studio(
        tmp_path,
        [annotation(way(), PLATE), annotation(way("q"), other, number=2, was_cancelled=True)],
    )
    assert names(source) == ["task-1-p"]
    assert list(boxes(things(source))) == ["plate-0"]
    assert any("1 cancelled" in note for note in read_source(source).notes)


def test_a_skipped_task_is_no_scene(tmp_path: Path) -> None:
    source = studio(tmp_path, [annotation(way(), PLATE)], [annotation(way(), was_cancelled=True)])
    assert [s.scene_id for s in scenes(source)] == ["task-1"]


def test_every_annotators_path_counts_and_a_thing_once(tmp_path: Path) -> None:
    nudged = region("rectangle", "z", "plate", x=11, y=11, width=10, height=20, rotation=0)
    cup = region("ellipse", "c", "cup", x=80, y=80, radiusX=3, radiusY=3)
    source = studio(
        tmp_path,
        [
            annotation(way(), PLATE, completed_by={"id": 7, "email": "a@b.c"}),
            annotation(way(bulge=-20), PLATE, number=2, completed_by=8),
            annotation(way("q"), nudged, cup, number=3, completed_by=9),
        ],
    )
    data = read_source(source).data
    assert [d.demo_id for d in data.demonstrations] == ["task-1-p", "task-1-2-p", "task-1-q"]
    assert [d.demonstrator for d in data.demonstrations] == ["a@b.c", "8", "9"]
    assert list(boxes(data.scenes[0].listed_objects())) == ["plate-0", "cup-0"]


def test_two_things_of_one_annotator_are_two(tmp_path: Path) -> None:
    again = {**PLATE, "id": "b"}
    source = studio(tmp_path, [annotation(way(), PLATE, again), annotation(way(), PLATE, number=2)])
    assert list(boxes(things(source))) == ["plate-0", "plate-1"]


def test_annotators_who_disagree_are_refused(tmp_path: Path) -> None:
    other = region("rectangle", "b", "bowl", x=10, y=10, width=10, height=20, rotation=0)
    source = studio(tmp_path / "a", [annotation(way(), PLATE), annotation(other, number=2)])
    with pytest.raises(InputError, match="plate, as another annotator says"):
        scenes(source)
    moved = region("rectangle", "a", "plate", x=70, y=10, width=10, height=20, rotation=0)
    source = studio(tmp_path / "b", [annotation(way(), PLATE), annotation(moved, number=2)])
    with pytest.raises(InputError, match="another place"):
        scenes(source)


def test_the_ground_truth_decides(tmp_path: Path) -> None:
    other = region("rectangle", "b", "bowl", x=10, y=10, width=10, height=20, rotation=0)
    source = studio(
        tmp_path, [annotation(way(), PLATE), annotation(other, number=2, ground_truth=True)]
    )
    assert list(boxes(things(source))) == ["bowl-0"]


def test_answers_about_the_picture_are_those_of_its_paths(tmp_path: Path) -> None:
    source = studio(
        tmp_path,
        [annotation(way(), way("q", bulge=5), answer("p", "valid", "yes"),
                    answer("q", "valid", "no"), answer("whole", "person", "careful"))],
    )  # fmt: skip
    data = read_source(source, mapping=Mapping(valid="valid", type="person")).data
    assert [d.valid for d in data.demonstrations] == [True, False]
    assert {d.type for d in data.demonstrations} == {"careful"}


def test_annotated_and_empty_is_an_empty_table(tmp_path: Path) -> None:
    source = studio(tmp_path / "a", [annotation(way(), PLATE)], [annotation(way())])
    assert [s.objects == () for s in scenes(source)] == [False, True]
    # Nobody outlined a thing anywhere: things were not what these people drew.
    source = studio(tmp_path / "b", [annotation(way())], [annotation(way())])
    assert [s.objects for s in scenes(source)] == [None, None]


def test_drawings_over_another_size_are_scaled(tmp_path: Path) -> None:
    source = studio(tmp_path / "a", [annotation(way(), PLATE)], size=(400, 200))
    data = read_source(source).data
    assert boxes(data.scenes[0].listed_objects()) == {"plate-0": [40, 20, 40, 40]}
    np.testing.assert_allclose(data.demonstrations[0].points, [[20, 100], [200, 40], [380, 100]])


def test_drawings_over_another_shape_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="of the shape 300x300"):
        scenes(studio(tmp_path, [annotation(way(), PLATE)], size=(300, 300)))


# CVAT


def test_cvat_shapes(tmp_path: Path) -> None:
    found = things(
        cvat(
            tmp_path,
            '<box label="plate" xtl="80" ytl="45" xbr="120" ybr="55" rotation="90"/>',
            '<ellipse label="glass" cx="50" cy="50" rx="20" ry="10"/>',
            '<ellipse label="glass" cx="50" cy="50" rx="20" ry="10" rotation="270"/>',
            '<mask label="bowl" left="10" top="20" width="4" height="3" rle="1,2,2,2,2,2,1"/>',
            '<points label="pin" points="150,50"/>',
            '<points label="pole" points="150,50"><attribute name="radius">5</attribute></points>',
            '<polygon label="mat" points="0,0;10,0;10,10"/>',
        )
    )
    assert boxes(found) == {
        "plate-0": [95, 30, 10, 40], "glass-0": [30, 40, 40, 20], "glass-1": [40, 30, 20, 40],
        "bowl-0": [11, 20, 2, 3], "pin-0": [], "pole-0": [145, 45, 10, 10],
        "mat-0": [0, 0, 10, 10],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("shape", "match"),
    [
        ('<cuboid label="g" xtl1="1"/>', "a box, ellipse"),
        ('<skeleton label="g"/>', "a box, ellipse"),
        ('<points label="g" points="1,1;2,2"/>', "one point an object"),
        ('<mask label="g" left="1" top="1" width="4" height="3" rle="3,4"/>', "add up to 12"),
        ('<mask label="g" left="1" top="1" width="4" height="3" rle="12"/>', "at least one pixel"),
        ('<ellipse label="g" cx="1" cy="1" rx="4"/>', "ry: expected a number"),
        ('<polygon label="g" points="1,1;2,2"/>', "three corners"),
        ('<box label="g" xtl="9" ytl="1" xbr="2" ybr="4"/>', "sides of at least 0"),
    ],
)
def test_cvat_shapes_that_cannot_be_read_are_errors(tmp_path: Path, shape: str, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        things(cvat(tmp_path, shape))
    assert "image 0" in str(caught.value)


def test_cvat_pictures_of_another_size(tmp_path: Path) -> None:
    box_ = '<box label="plate" xtl="80" ytl="40" xbr="120" ybr="60"/>'
    data = read_source(cvat(tmp_path / "a", box_, size=(100, 50))).data
    assert boxes(data.scenes[0].listed_objects()) == {"plate-0": [40, 20, 20, 10]}
    np.testing.assert_allclose(data.demonstrations[0].points[1], [50, 10])
    with pytest.raises(InputError, match="of the shape 100x80"):
        scenes(cvat(tmp_path / "b", box_, size=(100, 80)))


def test_cvat_pictures_of_one_name(tmp_path: Path) -> None:
    text = cvat(tmp_path).read_text()
    image = text[text.index("<image") : text.index("</image>") + len("</image>")]
    (tmp_path / "annotations.xml").write_text(f"<annotations>{image}{image}</annotations>")
    with pytest.raises(InputError, match="each picture once"):
        scenes(tmp_path / "annotations.xml")
    two = image.replace('id="0"', 'id="0" task_id="3"') + image.replace('id="0"', 'task_id="4"')
    (tmp_path / "annotations.xml").write_text(f"<annotations>{two}</annotations>")
    assert [s.scene_id for s in scenes(tmp_path / "annotations.xml")] == ["a", "a-task-4"]


def track(number: int, label: str, *shapes: str) -> str:
    return f'<track id="{number}" label="{label}">{"".join(shapes)}</track>'


def frame(number: int, x: float, y: float = 40, *, outside: int = 0) -> str:
    return (
        f'<box frame="{number}" keyframe="1" outside="{outside}" occluded="0" xtl="{x - 5}" '
        f'ytl="{y - 5}" xbr="{x + 5}" ybr="{y + 5}"><attribute name="user">me</attribute></box>'
    )


def video(folder: Path, *tracks: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "run.xml").write_text(
        "<annotations><meta><task><original_size><width>200</width><height>100</height>"
        f"</original_size></task></meta>{''.join(tracks)}</annotations>"
    )
    return folder / "run.xml"


def test_cvat_tracks_that_move_are_paths_and_others_are_objects(tmp_path: Path) -> None:
    hand = track(3, "hand", *(frame(i, 20 + 10 * i) for i in range(6)))
    cup = track(4, "cup", *(frame(i, 100 + 0.3 * (i % 2), 80) for i in range(6)))
    data = read_source(video(tmp_path, hand, cup), mapping=Mapping(type="user")).data
    (item,) = data.demonstrations
    assert (item.demo_id, item.type) == ("track-3", "me")
    np.testing.assert_allclose(item.points, [[20 + 10 * i, 40] for i in range(6)])
    assert boxes(data.scenes[0].listed_objects()) == {"cup-0": [95, 75, 10, 10]}


def test_cvat_tracks_that_leave_the_picture(tmp_path: Path) -> None:
    left = [frame(i, 20 + 10 * i, outside=int(i > 3)) for i in range(6)]
    (item,) = read_source(video(tmp_path / "a", track(1, "hand", *left))).data.demonstrations
    assert len(item.points) == 4
    gap = [frame(i, 20 + 10 * i, outside=int(i == 2)) for i in range(6)]
    source = video(tmp_path / "b", track(1, "hand", *gap))
    with pytest.raises(InputError, match="point 2"):
        read_source(source)
    (item,) = read_source(source, mapping=Mapping(drop_missing=True)).data.demonstrations
    assert len(item.points) == 5


@pytest.mark.parametrize(
    ("tracks", "match"),
    [
        ([track(1, "hand", frame(2, 20), frame(1, 30))], "a frame after 2"),
        ([track(1, "h", frame(1, 2), frame(2, 60)), track(1, "h", frame(1, 2), frame(2, 60))],
         "each track once"),
        ([track(1, "hand", '<skeleton frame="1" outside="0"/>')], "a box, ellipse"),
        ([track(1, "hand", frame(0, 20), frame(1, 60)) + '<image name="a.png"/>'], "both"),
    ],
)  # fmt: skip
def test_cvat_tracks_that_cannot_be_read_are_errors(
    tmp_path: Path, tracks: list[str], match: str
) -> None:
    with pytest.raises(InputError, match=match):
        read_source(video(tmp_path, *tracks))


# COCO


def test_coco_boxes_turn_about_their_centre(tmp_path: Path) -> None:
    turned = {"bbox": [80, 45, 40, 10], "segmentation": [], "attributes": {"rotation": 90.0}}
    corners = {**turned, "segmentation": [[80, 45, 120, 45, 120, 55, 80, 55]]}
    drawn = {**turned, "segmentation": [[95, 30, 105, 30, 105, 70, 95, 70]]}
    found = boxes(beside(coco(tmp_path, turned, corners, drawn)))
    assert found["glass-0"] == found["glass-1"] == [95, 30, 10, 40]
    assert found["glass-2"] == [80, 45, 40, 10]  # its outline is not turned again


def test_coco_segmentations_of_every_kind(tmp_path: Path) -> None:
    pytest.importorskip("pycocotools", reason="pip install 'demospec[objects]'")
    from pycocotools import mask as tool

    packed = tool.encode(np.asfortranarray(BLOCK.astype(np.uint8)))
    packed["counts"] = packed["counts"].decode()
    flat = BLOCK.T.ravel()
    ends = [*(np.flatnonzero(np.diff(flat.astype(int))) + 1), len(flat)]
    runs = np.diff([0, *ends]).tolist()
    found = beside(
        coco(
            tmp_path,
            {"bbox": [80, 30, 40, 20], "segmentation": packed},
            {"bbox": [80, 30, 40, 20], "segmentation": {"size": [HEIGHT, WIDTH], "counts": runs}},
            {"iscrowd": 1, "segmentation": {"size": [HEIGHT, WIDTH], "counts": runs}},
            {"segmentation": [[0, 0, 10, 0, 10, 10], [20, 0, 30, 0, 30, 10], [5, 5]]},
        )
    )
    assert [o.bbox for o in found[:3]] == [(80, 30, 40, 20)] * 3
    for item in found[:3]:
        assert item.outline.bounds == (80, 30, 120, 50)
    assert isinstance(found[3].footprint, MultiPolygon)
    assert found[3].bbox == (0, 0, 30, 10)


@pytest.mark.parametrize(
    ("annotation_", "match"),
    [
        ({"segmentation": {"size": [HEIGHT, WIDTH], "counts": [5, 7]}}, "add up to 20000"),
        ({"segmentation": {"size": [HEIGHT, WIDTH], "counts": "PP"}}, "20000 pixels"),
        ({"segmentation": {"size": [10, 10], "counts": [40, 60]}}, "a mask of 200x100"),
        ({"segmentation": {"size": [0, 10], "counts": []}}, "a size"),
        ({"segmentation": [[1, 2, 3]]}, "a polygon"),
        ({"segmentation": [[1, 2, 3, 4]]}, "three corners"),
        ({"segmentation": [[1, 2, 3, 4, "x", 6]]}, "a number"),
        ({"segmentation": "polygon"}, "polygons or a run-length mask"),
        ({"bbox": [1, 2, 3]}, "width, height"),
        ({"segmentation": []}, "width, height"),
        ({"bbox": [1, 2, 3, 4], "attributes": {"rotation": "left"}}, "a number"),
    ],
)
def test_coco_shapes_that_cannot_be_read_are_errors(
    tmp_path: Path, annotation_: dict[str, object], match: str
) -> None:
    pytest.importorskip("pycocotools", reason="pip install 'demospec[objects]'")
    with pytest.raises(InputError, match=match) as caught:
        beside(coco(tmp_path, {"bbox": [1, 2, 3, 4]}, annotation_))
    assert "row 1" in str(caught.value)


def test_coco_pictures_of_one_name_are_one(tmp_path: Path) -> None:
    images = [
        {"id": i, "file_name": "table.png", "width": WIDTH, "height": HEIGHT} for i in (1, 51)
    ]
    plate = {"bbox": [10, 10, 20, 20], "image_id": 51, "category_id": 2}
    folder = coco(tmp_path / "a", {"bbox": [80, 40, 20, 20]}, plate, images=images)
    assert list(boxes(beside(folder))) == ["glass-0", "plate-0"]
    images[1]["width"] = 300
    folder = coco(tmp_path / "b", {"bbox": [80, 40, 20, 20]}, plate, images=images)
    with pytest.raises(InputError, match=r"the size of table\.png"):
        beside(folder)


@pytest.mark.parametrize(
    "name", ["other.png", "table_png.rf.0123456789abcdef.jpg", "images\\1a2b3c4d-table.png"]
)
def test_objects_of_no_picture_are_refused(tmp_path: Path, name: str) -> None:
    images = [{"id": 1, "file_name": name, "width": WIDTH, "height": HEIGHT}]
    folder = coco(tmp_path, {"bbox": [80, 40, 20, 20]}, images=images)
    with pytest.raises(InputError, match="objects of one of the scenes' pictures"):
        beside(folder)


@pytest.mark.parametrize("name", ["images\\table.png", "train/table.png", "table.jpg"])
def test_folders_of_any_system_and_endings_do_not_matter(tmp_path: Path, name: str) -> None:
    images = [{"id": 1, "file_name": name, "width": WIDTH, "height": HEIGHT}]
    folder = coco(tmp_path, {"bbox": [80, 40, 20, 20]}, images=images)
    assert boxes(beside(folder)) == {"glass-0": [80, 40, 20, 20]}


def test_an_annotated_picture_without_objects_is_an_empty_table(tmp_path: Path) -> None:
    assert beside(coco(tmp_path)) == ()


def test_objects_over_another_size(tmp_path: Path) -> None:
    folder = coco(tmp_path / "a", {"bbox": [80, 40, 20, 20]}, size=(100, 50))
    assert boxes(beside(folder)) == {"glass-0": [40, 20, 10, 10]}
    folder = coco(tmp_path / "b", {"bbox": [80, 40, 20, 20]}, size=(100, 60))
    with pytest.raises(InputError, match="of the shape 100x60"):
        beside(folder)
