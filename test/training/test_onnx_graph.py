# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The last nodes of a network."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.resources import model_path

pytest.importorskip("onnx", reason="pip install '.[export]'")

from aerial_gnss_ros.training.onnx_graph import last_nodes, read_float_model


def test_last_nodes_of_the_shipped_model():
    last, behind = last_nodes(read_float_model(model_path("aqua_yolo11n.onnx")))
    # Three scales, each with sides and scores: the heads of YOLO11.
    assert sorted(name.split("/")[2] for name in last) == [
        "cv2.0", "cv2.1", "cv2.2", "cv3.0", "cv3.1", "cv3.2",
    ]  # fmt: skip
    assert "/model.23/dfl/conv/Conv" in behind
    assert not any("/model.22/" in name for name in behind)
