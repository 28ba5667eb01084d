# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A second look whose answer is known: the mean brightness of the near view, 0 to 1."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from aerial_gnss_ros.detection.second_look_terms import METADATA, Terms


def brightness_look(path: Path, terms: Terms | None = None) -> Path:
    """Write the .onnx file; without terms one that says nothing of a second look."""
    constants = {
        "starts": np.array([0], np.int64),
        "ends": np.array([3], np.int64),
        "axes": np.array([3], np.int64),
        "white": np.array(255.0, np.float32),
    }
    nodes = [
        helper.make_node("Cast", ["views"], ["values"], to=TensorProto.FLOAT),
        helper.make_node("Slice", ["values", "starts", "ends", "axes"], ["near"]),
        helper.make_node("ReduceMean", ["near"], ["mean"], axes=[1, 2, 3], keepdims=0),
        helper.make_node("Div", ["mean", "white"], ["bright"]),
        helper.make_node("ReduceMean", ["traits"], ["told"], axes=[1], keepdims=0),
        helper.make_node("Sub", ["told", "told"], ["nothing"]),
        helper.make_node("Add", ["bright", "nothing"], ["scores"]),
    ]
    graph = helper.make_graph(
        nodes,
        "look",
        [
            helper.make_tensor_value_info("views", TensorProto.UINT8, ["n", "h", "w", 6]),
            helper.make_tensor_value_info("traits", TensorProto.FLOAT, ["n", 3]),
        ],
        [helper.make_tensor_value_info("scores", TensorProto.FLOAT, ["n"])],
        [numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    if terms is not None:
        item = model.metadata_props.add()
        item.key, item.value = METADATA, terms.text
    onnx.save(model, path)
    return path
