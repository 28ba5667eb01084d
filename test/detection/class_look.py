# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A taught network whose answer is known: how blue and how red the middle of a view is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from aerial_gnss_ros.detection.second_look_terms import METADATA, Terms


def class_look(path: Path, terms: Terms) -> Path:
    """Write the .onnx file: scores (n, 2), the shares of blue and red of full light, squared."""
    constants = {
        "starts": np.array([28, 28], np.int64),
        "ends": np.array([36, 36], np.int64),
        "axes": np.array([1, 2], np.int64),
        "channels": np.array([0, 2], np.int64),
        "white": np.array(255.0, np.float32),
    }
    nodes = [
        helper.make_node("Cast", ["views"], ["values"], to=TensorProto.FLOAT),
        helper.make_node("Slice", ["values", "starts", "ends", "axes"], ["middle"]),
        helper.make_node("ReduceMean", ["middle"], ["mean"], axes=[1, 2], keepdims=0),
        helper.make_node("Gather", ["mean", "channels"], ["colours"], axis=1),
        helper.make_node("Div", ["colours", "white"], ["shares"]),
        helper.make_node("ReduceMean", ["traits"], ["told"], axes=[1], keepdims=1),
        helper.make_node("Sub", ["told", "told"], ["nothing"]),
        helper.make_node("Mul", ["shares", "shares"], ["squares"]),
        helper.make_node("Add", ["squares", "nothing"], ["scores"]),
    ]
    graph = helper.make_graph(
        nodes,
        "look",
        [
            helper.make_tensor_value_info("views", TensorProto.UINT8, ["n", "h", "w", 6]),
            helper.make_tensor_value_info("traits", TensorProto.FLOAT, ["n", 3]),
        ],
        [helper.make_tensor_value_info("scores", TensorProto.FLOAT, ["n", 2])],
        [numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    item = model.metadata_props.add()
    item.key, item.value = METADATA, terms.text
    onnx.save(model, path)
    return path
