# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exports an ONNX model to 16 bits (fp16); its input and output stay in 32.

Written here because the usual converters can keep single nodes in 32 bits, but round the values
between them to 16.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.training.onnx_graph import keep_metadata, last_nodes, read_float_model

_FLOAT, _HALF = 1, 10  # onnx.TensorProto's numbers
_STAYS_FLOAT = {"Resize": (1, 2)}  # inputs that ONNX requires in 32 bits: region and scales
_LARGEST = float(np.finfo(np.float16).max)


def export_half(source: Path, output: Path) -> Path:
    """Write `source` with weights and activations in 16 bits.

    The conversion of the last logits to boxes stays in 32 bits: in 16 bits a coordinate beyond 1024
    px would be a whole number.

    Args:
        source: .onnx in fp32.
        output: .onnx to write; must not exist.

    Raises:
        ModelError: `source` is unusable, or onnx is not installed.
        OutputError: `output` exists or cannot be written.
    """
    model = read_float_model(source)
    import onnx

    made = _converted(model, set(last_nodes(model)[1]))
    keep_metadata(model, made, precision="fp16")
    try:
        onnx.checker.check_model(made)
        onnx.shape_inference.infer_shapes(made, check_type=True, strict_mode=True)
    except Exception as error:  # onnx has no common error
        raise ModelError(f"{source} has a layer that cannot be converted to fp16.") from error
    with partial(output) as file:
        onnx.save(made, file)
    return output


def _converted(model: Any, exact: set[str]) -> Any:
    """Return a copy in 16 bits but for the nodes in `exact`."""
    import onnx

    made = onnx.ModelProto()
    made.CopyFrom(model)
    work = _Conversion(made.graph, _float_tensors(model))
    for node in made.graph.node:
        if node.name in exact:
            work.keep(node)
        else:
            work.convert(node)
    for item in made.graph.output:
        work.give_back(item.name)
    _replace_nodes(made.graph, work.nodes)
    return made


class _Conversion:
    """Nodes converted one by one, in the order of their work.

    Args:
        graph: its constants gain copies in 16 bits.
        floats: names of the tensors in 32 bits.
    """

    def __init__(self, graph: Any, floats: set[str]) -> None:
        self.nodes: list[Any] = []
        self._graph = graph
        self._floats = floats
        self._constants = {value.name: value for value in graph.initializer}
        self._half: dict[str, str] = {}  # tensor -> its name in 16 bits
        self._given_back = set(self._constants) | {item.name for item in graph.input}
        for item in graph.input:
            if item.name in floats:
                self._half[item.name] = self._cast(item.name, f"{item.name}_half", _HALF)

    def convert(self, node: Any) -> None:
        """Convert a node that works in 16 bits."""
        for place, name in enumerate(node.input):
            if place in _STAYS_FLOAT.get(node.op_type, ()):
                self.give_back(name)
            elif name in self._floats:
                if name not in self._half:
                    self._half[name] = self._constant(name)
                node.input[place] = self._half[name]
        for place, name in enumerate(node.output):
            if name in self._floats:
                node.output[place] = self._half[name] = f"{name}_half"
        _set_types(node)
        self.nodes.append(node)

    def keep(self, node: Any) -> None:
        """Copy a node that works in 32 bits."""
        for name in node.input:
            self.give_back(name)
        self._given_back.update(node.output)
        self.nodes.append(node)

    def give_back(self, name: str) -> None:
        """Make a tensor that is in 16 bits available in 32 under its own name."""
        if name in self._half and name not in self._given_back:
            self._given_back.add(name)
            self._cast(self._half[name], name, _FLOAT)

    def _cast(self, name: str, output: str, kind: int) -> str:
        import onnx

        self.nodes.append(onnx.helper.make_node("Cast", [name], [output], name=output, to=kind))
        return output

    def _constant(self, name: str) -> str:
        half = f"{name}_half"
        self._graph.initializer.append(_half_constant(self._constants[name], half))
        return half


def _float_tensors(model: Any) -> set[str]:
    """Return the names of all tensors in 32 bits."""
    import onnx

    graph = onnx.shape_inference.infer_shapes(model).graph
    typed = [*graph.input, *graph.output, *graph.value_info]
    return {v.name for v in typed if v.type.tensor_type.elem_type == _FLOAT} | {
        value.name for value in graph.initializer if value.data_type == _FLOAT
    }


def _half_constant(value: Any, name: str) -> Any:
    import onnx

    array = onnx.numpy_helper.to_array(value)
    return onnx.numpy_helper.from_array(
        np.clip(array, -_LARGEST, _LARGEST).astype(np.float16), name
    )


def _set_types(node: Any) -> None:
    """Convert a node's own output type, of a cast or a constant, to 16 bits."""
    for attribute in node.attribute:
        if node.op_type == "Cast" and attribute.name == "to" and attribute.i == _FLOAT:
            attribute.i = _HALF
        if node.op_type in ("Constant", "ConstantOfShape") and attribute.t.data_type == _FLOAT:
            attribute.t.CopyFrom(_half_constant(attribute.t, attribute.t.name))


def _replace_nodes(graph: Any, nodes: list[Any]) -> None:
    copies = [type(node)() for node in nodes]
    for copy, node in zip(copies, nodes, strict=True):
        copy.CopyFrom(node)
    used = {name for node in copies for name in node.input}
    constants = [value for value in graph.initializer if value.name in used]
    del graph.node[:], graph.initializer[:], graph.value_info[:]
    graph.node.extend(copies)
    graph.initializer.extend(constants)
