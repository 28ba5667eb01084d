# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Analysis of ONNX graphs for exports to fewer bits: which nodes must stay exact."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.onnx_model import check_file
from aerial_gnss_ros.resources import install_hint

_RESHAPING = ("Transpose", "Reshape")  # between a softmax and the convolution that reads it


def read_float_model(path: Path) -> Any:
    """Return the ONNX model of a file, in 32 bits, each node named.

    Raises:
        ModelError: missing, not an ONNX model, not in 32 bits, or onnx is not installed.
    """
    if path.suffix.lower() != ".onnx":
        raise ModelError(f"{path} is not an .onnx file; export it to ONNX in fp32 first.")
    check_file(path)
    try:
        import onnx
    except ImportError as error:
        raise ModelError(f"export needs onnx; install it with {install_hint('export')}.") from error
    try:
        model = onnx.load(path)
        onnx.checker.check_model(model)
    except Exception as error:  # protobuf and onnx have no common error
        raise ModelError(f"{path} is not an ONNX model, or was cut off.") from error
    kinds = {node.op_type for node in model.graph.node}
    if "QuantizeLinear" in kinds or "DequantizeLinear" in kinds:
        raise ModelError(f"{path} is in 8 bits already; give the model in fp32.")
    half = onnx.TensorProto.FLOAT16
    if any(value.data_type == half for value in model.graph.initializer):
        raise ModelError(f"{path} is in 16 bits already; give the model in fp32.")
    if not any(node.op_type == "Conv" for node in model.graph.node):
        raise ModelError(
            f"{path} has no convolution; it is not a detection model of the YOLO family."
        )
    for number, node in enumerate(model.graph.node):
        node.name = node.name or f"{node.op_type}_{number}"
    return model


def last_nodes(model: Any) -> tuple[list[str], list[str]]:
    """Return the names of the last convolutions, and of all nodes after them.

    The last convolutions of a YOLO head output the logits of sides and scores; the nodes after them
    convert these to boxes, without trained weights. The fixed convolution that takes the mean of a
    distribution (DFL, after a softmax) belongs to the latter.
    """
    nodes = list(model.graph.node)
    readers: dict[str, list[Any]] = defaultdict(list)
    maker = {name: node for node in nodes for name in node.output}
    for node in nodes:
        for name in node.input:
            readers[name].append(node)
    trained = {node.name for node in nodes if node.op_type == "Conv" and not _is_mean(node, maker)}
    before_trained: dict[str, bool] = {}
    for node in reversed(nodes):  # ONNX keeps nodes in the order of their work
        after = [reader for name in node.output for reader in readers[name]]
        before_trained[node.name] = any(
            reader.name in trained or before_trained[reader.name] for reader in after
        )
    behind = [n.name for n in nodes if n.name not in trained and not before_trained[n.name]]
    last = [n.name for n in nodes if n.name in trained and not before_trained[n.name]]
    return last, behind


def _is_mean(convolution: Any, maker: dict[str, Any]) -> bool:
    """Return whether a convolution reads a softmax."""
    node = maker.get(convolution.input[0])
    while node is not None and node.op_type in _RESHAPING:
        node = maker.get(node.input[0])
    return node is not None and node.op_type == "Softmax"


def keep_metadata(source: Any, made: Any, **more: str) -> None:
    """Give a model the metadata of another (class names, task), and more."""
    values = {item.key: item.value for item in source.metadata_props} | more
    del made.metadata_props[:]
    for key, value in values.items():
        made.metadata_props.add(key=key, value=value)
