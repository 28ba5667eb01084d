# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Weights between a network and those tuned from it."""

from __future__ import annotations

import numpy as np
import pytest

onnx = pytest.importorskip("onnx", reason="pip install '.[export]'")

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError, OutputError  # noqa: E402
from aerial_gnss_ros.training.averaging import average, main  # noqa: E402


def network(path, *weights, name="w", about="first"):
    """Write a convolution with these weights and a whole number."""
    table = np.array(weights, dtype=np.float32).reshape(-1, 1, 1, 1)
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    graph = helper.make_graph(
        [
            helper.make_node("Conv", ["x", name], ["c"]),
            helper.make_node("Reshape", ["c", "shape"], ["y"]),
        ],
        "graph",
        [helper.make_tensor_value_info("x", kind, [1, 1, 1, 1])],
        [helper.make_tensor_value_info("y", kind, [len(weights)])],
        [
            onnx.numpy_helper.from_array(table, name),
            onnx.numpy_helper.from_array(np.array([len(weights)], np.int64), "shape"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    model.metadata_props.add(key="names", value=about)
    onnx.save(model, path)
    return path


def weights(path):
    """Return the weights of a network, and what it says about itself."""
    model = onnx.load(path)
    (table,) = [t for t in model.graph.initializer if t.name == "w"]
    return onnx.numpy_helper.to_array(table).ravel().tolist(), model.metadata_props[0].value


def test_the_mean_of_the_tuned_counts_its_share(tmp_path):
    start = network(tmp_path / "start.onnx", 0.0, 8.0)
    tuned = [
        network(tmp_path / "one.onnx", 4.0, 0.0, about="one"),
        network(tmp_path / "two.onnx", 8.0, 0.0, about="two"),
    ]
    assert weights(average(start, tuned, 0.25, tmp_path / "a.onnx")) == ([1.5, 6.0], "first")
    assert weights(average(start, tuned, 0.0, tmp_path / "b.onnx")) == ([0.0, 8.0], "first")
    with pytest.raises(OutputError):
        average(start, tuned, 0.25, tmp_path / "a.onnx")


@pytest.mark.parametrize(("values", "name"), [((1.0,), "w"), ((1.0, 2.0), "v")])
def test_another_network_is_refused_in_words(tmp_path, capsys, values, name):
    start = network(tmp_path / "start.onnx", 0.0, 8.0)
    other = network(tmp_path / "other.onnx", *values, name=name)
    with pytest.raises(ModelError, match=r"other\.onnx is another network than"):
        average(start, [other], 0.5, tmp_path / "a.onnx")
    assert main([str(start), str(other), "-o", str(tmp_path / "a.onnx")]) == 2
    assert "averaging: " in capsys.readouterr().err
    assert not (tmp_path / "a.onnx").exists()


@pytest.mark.parametrize("share", [-0.1, 1.1, float("nan")])
def test_a_share_is_no_more_than_all(tmp_path, share):
    start = network(tmp_path / "start.onnx", 0.0)
    with pytest.raises(ConfigError, match="--share must lie within 0 to 1"):
        average(start, [start], share, tmp_path / "a.onnx")
