# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ONNX models whose answer is known: the box around the white pixels of the image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

OPSET, IR_VERSION = 17, 8


def white_box_model(
    path: Path,
    *,
    size: tuple[int, int] | None = None,
    end_to_end: bool = False,
    names: str | None = "{0: 'aqua'}",
    task: str = "detect",
    dtype: int = TensorProto.FLOAT,
) -> Path:
    """Write a model that finds the smallest box around pixels brighter than 0.9 (padding is 0.45).

    Args:
        path: where to.
        size: width and height of a fixed input; None: free.
        end_to_end: rows of corners, score, class instead of columns of centre, size, score.
        names: the metadata `names`; None: no metadata at all.
        task: the metadata `task`.
        dtype: of the input.
    """
    constants, nodes = {}, []

    def constant(name: str, value: np.ndarray) -> str:
        constants[name] = value
        return name

    def node(kind: str, inputs: list[str], output: str, **attributes: object) -> str:
        nodes.append(helper.make_node(kind, inputs, [output], **attributes))
        return output

    zero = constant("zero", np.array(0, np.int64))
    one = constant("one", np.array(1, np.int64))
    values = node("Cast", ["images"], "values", to=TensorProto.FLOAT)
    grey = node("ReduceMean", [values], "grey", axes=[1], keepdims=1)
    white = node("Greater", [grey, constant("limit", np.array(0.9, np.float32))], "white")
    mask = node("Cast", [white], "mask", to=TensorProto.FLOAT)
    edges = {}
    for side, other in (("x", 2), ("y", 3)):
        line = node("ReduceMax", [mask], f"line_{side}", axes=[1, other], keepdims=0)
        shape = node("Shape", [line], f"shape_{side}")
        count = node("Gather", [shape, one], f"count_{side}", axis=0)
        index = node("Range", [zero, count, one], f"index_{side}")
        up = node("Add", [index, one], f"up_{side}")
        down = node("Sub", [count, index], f"down_{side}")
        for name, weight in (("high", up), ("low", down)):
            as_float = node("Cast", [weight], f"{name}_w_{side}", to=TensorProto.FLOAT)
            product = node("Mul", [line, as_float], f"{name}_p_{side}")
            node("ReduceMax", [product], f"{name}_m_{side}", axes=[1], keepdims=1)
        total = node("Cast", [count], f"total_{side}", to=TensorProto.FLOAT)
        edges[f"{side}1"] = node("Sub", [total, f"low_m_{side}"], f"{side}1")
        edges[f"{side}2"] = node("Identity", [f"high_m_{side}"], f"{side}2")
    score = constant("score", np.array([[0.75]], np.float32))
    if end_to_end:
        zero_f = constant("class", np.array([[0.0]], np.float32))
        parts = [edges["x1"], edges["y1"], edges["x2"], edges["y2"], score, zero_f]
        row = node("Concat", parts, "row", axis=1)
        blank = constant("blank", np.zeros((1, 299, 6), np.float32))
        lifted = node("Unsqueeze", [row, constant("ax1", np.array([1], np.int64))], "lifted")
        node("Concat", [lifted, blank], "output0", axis=1)
    else:
        half = constant("half", np.array(0.5, np.float32))
        total = {
            side: node("Add", [edges[f"{side}1"], edges[f"{side}2"]], f"sum_{side}")
            for side in "xy"
        }
        centre = [node("Mul", [total[side], half], f"centre_{side}") for side in "xy"]
        extent = [
            node("Sub", [edges[f"{side}2"], edges[f"{side}1"]], f"extent_{side}") for side in "xy"
        ]
        column = node("Concat", [*centre, *extent, score], "column", axis=1)
        lifted = node("Unsqueeze", [column, constant("ax2", np.array([2], np.int64))], "lifted")
        # A second box 1 px larger, and boxes below any threshold: suppression has work to do.
        worse = constant("worse", np.array([0, 0, 1, 1, -0.25], np.float32).reshape(1, 5, 1))
        second = node("Add", [lifted, worse], "second")
        blank = constant("blank", np.zeros((1, 5, 30), np.float32))
        node("Concat", [second, blank, lifted], "output0", axis=2)
    width, height = size or ("width", "height")
    graph = helper.make_graph(
        nodes,
        "white_box",
        [helper.make_tensor_value_info("images", dtype, [1, 3, height, width])],
        [helper.make_tensor_value_info("output0", TensorProto.FLOAT, ["n", "a", "b"])],
        [numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)])
    model.ir_version = IR_VERSION
    if names is not None:
        helper.set_model_props(model, {"names": names, "task": task})
    onnx.checker.check_model(model)
    onnx.save(model, path)
    return path
