"""Small ONNX models whose outputs are known: one of each layout that detectors are exported in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np


def constant_model(
    file: Path,
    outputs: dict[str, np.ndarray],
    *,
    shape: tuple[Any, ...] = (1, 3, 64, 64),
    names: dict[int, str] | None = None,
    said: dict[str, str] | None = None,
    sized: bool = False,
) -> Path:
    """A model that says the same of every picture (it adds nothing times the picture's mean)."""
    from onnx import TensorProto, helper, numpy_helper, save

    kinds = {np.dtype("float32"): TensorProto.FLOAT, np.dtype("int64"): TensorProto.INT64}
    picture = helper.make_tensor_value_info("images", TensorProto.FLOAT, shape)
    nodes, values, out = [], [], []
    for name, array in outputs.items():
        values.append(numpy_helper.from_array(array, f"{name}_value"))
        nodes.append(helper.make_node("Identity", [f"{name}_value"], [name]))
        out.append(helper.make_tensor_value_info(name, kinds[array.dtype], array.shape))
    inputs = [picture]
    if sized:
        size = helper.make_tensor_value_info("orig_target_sizes", TensorProto.INT64, (1, 2))
        inputs.append(size)
    return _saved(helper.make_graph(nodes, "tiny", inputs, out, values), file, names, said, save)


def brightness_model(file: Path, *, side: int = 64) -> Path:
    """YOLO v8 with one class and three boxes: the score of each is the brightness of the input's
    upper bar, middle and lower bar, so that the test sees what the model was fed."""
    from onnx import TensorProto, helper, numpy_helper, save

    third = side // 4
    rows = np.zeros((3, side, side), dtype=np.float32)
    rows[0, :third] = rows[1, third:-third] = rows[2, -third:] = 1
    rows /= rows.sum(axis=(1, 2), keepdims=True)
    boxes = np.array([[32, 8, 20, 8], [32, 32, 20, 8], [32, 56, 20, 8]], dtype=np.float32)
    constants = {
        "rows": rows.reshape(3, -1).T / np.float32(3),
        "flat": np.array([1, 3, side * side], dtype=np.int64),
        "boxes": boxes.T[None],
    }
    values = [numpy_helper.from_array(v.copy(), k) for k, v in constants.items()]
    nodes = [
        helper.make_node("Reshape", ["images", "flat"], ["pixels"]),
        helper.make_node("MatMul", ["pixels", "rows"], ["by_colour"]),
        helper.make_node("ReduceSum", ["by_colour", "axis"], ["scores"], keepdims=1),
        helper.make_node("Concat", ["boxes", "scores"], ["output0"], axis=1),
    ]
    values.append(numpy_helper.from_array(np.array([1], dtype=np.int64), "axis"))
    picture = helper.make_tensor_value_info("images", TensorProto.FLOAT, (1, 3, side, side))
    out = helper.make_tensor_value_info("output0", TensorProto.FLOAT, (1, 5, 3))
    graph = helper.make_graph(nodes, "bright", [picture], [out], values)
    return _saved(graph, file, {0: "light"}, None, save)


def _saved(graph: Any, file: Path, names: Any, said: Any, save: Any) -> Path:
    from onnx import helper

    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 9
    metadata = dict(said or {})
    if names is not None:
        metadata["names"] = str(names)
    helper.set_model_props(model, metadata)
    save(model, str(file))
    return file
