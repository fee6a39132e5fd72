"""Detectors in ONNX: every layout of output that common tools export, on models made here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

from tiny_models import brightness_model, constant_model

from demospec.errors import InputError
from demospec.perception.detectors import detector_of, listed

NAMES = {0: "cup", 1: "wine glass"}
PICTURE = np.full((32, 64, 3), 200, dtype=np.uint8)  # wide: bars of 16 px above and below
CUP, GLASS = (10.0, 5.0, 20.0, 10.0), (40.0, 4.0, 12.0, 24.0)  # in the picture, x y w h


def found(file: Path, picture: np.ndarray = PICTURE, least: float = 0.5) -> list[tuple]:
    findings = detector_of(f"onnx:{file}").detect(picture)
    things = listed(findings, (picture.shape[1], picture.shape[0]), least=least)
    return [(t.symbol, round(t.confidence, 3), tuple(np.round(t.bbox, 1))) for t in things]


def middles(*boxes: tuple[float, ...], down: float = 16.0) -> np.ndarray:
    """Boxes of the picture → middle and size in the square input."""
    return np.array([[x + w / 2, y + h / 2 + down, w, h] for x, y, w, h in boxes], np.float32)


EXPECTED = [("cup", 0.9, CUP), ("wine glass", 0.8, GLASS)]


def test_yolo_8(tmp_path: Path) -> None:
    """(1, 4 + k, n), with the neighbours that every export lists of one thing."""
    boxes = middles(CUP, GLASS, (11.0, 5.0, 20.0, 10.0), (0.0, 0.0, 9.0, 9.0))
    scores = np.array([[0.9, 0.1], [0.2, 0.8], [0.7, 0.0], [0.3, 0.1]], np.float32)
    output = np.concatenate([boxes, scores], axis=1).T[None]
    assert found(constant_model(tmp_path / "m.onnx", {"output0": output}, names=NAMES)) == EXPECTED


def test_yolo_8_with_more_classes_than_boxes(tmp_path: Path) -> None:
    """Names say which way round the table is; its sides alone would say the wrong one."""
    names = {i: f"class {i}" for i in range(20)}
    scores = np.zeros((1, 20), np.float32)
    scores[0, 7] = 0.75
    output = np.concatenate([middles(CUP), scores], axis=1).T[None]
    file = constant_model(tmp_path / "m.onnx", {"output0": output}, names=names)
    assert found(file) == [("class 7", 0.75, CUP)]


def test_yolo_8_masks(tmp_path: Path) -> None:
    """Coefficients of two prototypes: the left half and the right half of the input."""
    prototypes = np.full((1, 2, 16, 16), -9.0, np.float32)
    prototypes[0, 0, :, :5] = 9.0  # input x < 20
    prototypes[0, 1, :, 5:] = 9.0
    row = np.concatenate([middles(CUP)[0], [0.9, 0.0], [1.0, 0.0]]).astype(np.float32)
    model = {"output0": row[None, :, None], "output1": prototypes}
    file = constant_model(tmp_path / "m.onnx", model, names=NAMES)
    (finding,) = detector_of(f"onnx:{file}").detect(PICTURE)
    (thing,) = listed([finding], (64, 32))
    x, y, right, low = thing.outline.bounds
    assert (x, y, low) == (10, 5, 15)
    assert right == pytest.approx(20, abs=1.0)  # a prototype pixel is four of the picture


def test_yolo_5(tmp_path: Path) -> None:
    """(1, n, 5 + k): a class counts as far as there is a thing."""
    boxes = middles(CUP, GLASS, (2.0, 2.0, 8.0, 8.0))
    rest = np.array([[1.0, 0.9, 0.1], [0.8, 0.1, 1.0], [0.1, 1.0, 0.0]], np.float32)
    output = np.concatenate([boxes, rest], axis=1)[None]
    assert found(constant_model(tmp_path / "m.onnx", {"output": output}, names=NAMES)) == EXPECTED


@pytest.mark.parametrize("names", [NAMES, {0: "cup"}])
def test_yolo_end_to_end(tmp_path: Path, names: dict[int, str]) -> None:
    """(1, n, 6): corners, score, class. With one class v5 has six columns too."""
    things = [(CUP, 0.9, 0), (GLASS, 0.8, len(names) - 1)]
    rows = [[x, y + 16, x + w, y + h + 16, p, k] for (x, y, w, h), p, k in things]
    output = np.array([[*rows, [0, 0, 0, 0, 0, 0]]], np.float32)
    file = constant_model(tmp_path / "m.onnx", {"output0": output}, names=names)
    assert [f[1:] for f in found(file)] == [f[1:] for f in EXPECTED]
    assert [f[0] for f in found(file)] == ["cup", names[len(names) - 1]]


def test_yolo_5_of_one_class(tmp_path: Path) -> None:
    output = np.concatenate([middles(CUP), [[1.0, 0.9]]], axis=1).astype(np.float32)[None]
    file = constant_model(tmp_path / "m.onnx", {"output": output}, names={0: "cup"})
    assert found(file) == EXPECTED[:1]


def shares(*boxes: tuple[float, ...]) -> np.ndarray:
    """Boxes of the picture → shares of a picture that is stretched to the input."""
    return middles(*boxes, down=0.0) / np.array([64, 32, 64, 32], np.float32)


def test_rt_detr_as_one_output(tmp_path: Path) -> None:
    scores = np.array([[0.9, 0.1], [0.2, 0.8]], np.float32)
    output = np.concatenate([shares(CUP, GLASS), scores], axis=1)[None]
    assert found(constant_model(tmp_path / "m.onnx", {"output0": output}, names=NAMES)) == EXPECTED


@pytest.mark.parametrize("nothing", [False, True])
def test_rt_detr_as_two_outputs(tmp_path: Path, nothing: bool) -> None:
    """Log-odds of every class, or, as DETR, of every class and of nothing."""
    p = np.array([[0.9, 0.05, 0.05], [0.1, 0.8, 0.1]])
    logits = np.log(p) if nothing else np.log(p / (1 - p))[:, :2]
    model = {"logits": logits.astype(np.float32)[None], "pred_boxes": shares(CUP, GLASS)[None]}
    assert found(constant_model(tmp_path / "m.onnx", model, names=NAMES)) == EXPECTED


def test_rt_detr_with_the_size_as_input(tmp_path: Path) -> None:
    corners = shares(CUP, GLASS) * 64
    corners = np.concatenate([corners[:, :2] - corners[:, 2:] / 2,
                              corners[:, :2] + corners[:, 2:] / 2], axis=1)  # fmt: skip
    model = {"labels": np.array([[0, 1]], np.int64), "boxes": corners[None],
             "scores": np.array([[0.9, 0.8]], np.float32)}  # fmt: skip
    assert found(constant_model(tmp_path / "m.onnx", model, names=NAMES, sized=True)) == EXPECTED


def rcnn(masks: np.ndarray) -> dict[str, np.ndarray]:
    corners = np.array([[x, y, x + w, y + h] for x, y, w, h in (CUP, GLASS)], np.float32)
    labels = np.array([1, 2], np.int64)
    return {"boxes": corners, "labels": labels, "scores": np.array([0.9, 0.8], np.float32),
            "masks": masks}  # fmt: skip


def test_mask_rcnn_of_a_picture_of_any_size(tmp_path: Path) -> None:
    """As torchvision exports it: labels from 1, masks of the whole picture, names in a file."""
    masks = np.zeros((2, 1, 32, 64), np.float32)
    masks[0, 0, 6:14, 12:28] = 1.0
    file = constant_model(tmp_path / "m.onnx", rcnn(masks), shape=(3, "height", "width"))
    (tmp_path / "m.names").write_text("\ncup\nwine glass\n")
    assert found(file) == [("cup", 0.9, (12, 6, 16, 8)), EXPECTED[1]]


def test_mask_rcnn_with_masks_of_boxes(tmp_path: Path) -> None:
    """As in the ONNX model zoo: 28x28 pixels that fill the box; without names, numbers."""
    masks = np.ones((2, 1, 28, 28), np.float32)
    masks[0, 0, :, 14:] = 0.0
    file = constant_model(tmp_path / "m.onnx", rcnn(masks), shape=(3, "height", "width"))
    (cup, glass) = found(file)
    assert cup == ("1", 0.9, (10, 5, 10, 10))
    assert glass == ("2", 0.8, GLASS)


def test_the_model_sees_the_picture_between_grey_bars(tmp_path: Path) -> None:
    """Scores are the brightness of what was fed: white in the middle, 114 of 255 beside."""
    file = brightness_model(tmp_path / "m.onnx")
    white = np.full((100, 200, 3), 255, dtype=np.uint8)
    findings = detector_of(f"onnx:{file}").detect(white)
    by_place = sorted((f.bbox[1], f.confidence) for f in findings)
    assert [p for _, p in by_place] == pytest.approx([114 / 255, 1.0, 114 / 255], abs=1e-3)
    # The middle box, (22, 28) to (42, 36) of the input, is 200/64 times as large in the picture.
    assert findings[0].bbox == pytest.approx((68.75, 37.5, 62.5, 25.0))


def test_bad_models_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "text.onnx").write_text("no model")
    strange = constant_model(tmp_path / "strange.onnx", {"out": np.zeros((1, 7), np.float32)})
    names = constant_model(
        tmp_path / "names.onnx", {"out": np.zeros((1, 6, 9), np.float32)}, said={"names": "{0:"}
    )
    for argument, words in {
        tmp_path / "none.onnx": "nothing there", tmp_path / "text.onnx": "a model in ONNX",
        strange: "YOLO, RT-DETR or Mask R-CNN", names: "names of classes",
    }.items():  # fmt: skip
        with pytest.raises(InputError, match=words) as error:
            detector_of(f"onnx:{argument}").detect(PICTURE)
        assert "\n" not in str(error.value)
        assert str(argument) in str(error.value)
