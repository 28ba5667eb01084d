# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A network of half precision finds what the other does."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

onnx = pytest.importorskip("onnx", reason="pip install '.[export]'")
pytest.importorskip("onnxruntime")

sys.path.insert(0, str(Path(__file__).parent))

from networks import output, sample, types  # noqa: E402

from aerial_gnss_ros.resources import model_path  # noqa: E402
from aerial_gnss_ros.training.half import export_half  # noqa: E402


def test_half_keeps_boxes_ends_and_names(tmp_path, pictures):
    source = model_path("aqua_yolo11n.onnx")
    made = export_half(source, tmp_path / "half.onnx")
    kinds, metadata = types(made)
    assert kinds == {onnx.TensorProto.FLOAT}
    assert metadata["names"] == "{0: 'aqua'}"
    assert metadata["precision"] == "fp16"
    assert made.stat().st_size < 0.55 * source.stat().st_size
    image = sample(pictures)
    exact, half = output(source, image), output(made, image)
    likely = exact[0, 4] > 0.05
    assert likely.any()
    assert np.abs(half[0, :4, likely] - exact[0, :4, likely]).max() < 0.5  # px
    assert np.abs(half[0, 4] - exact[0, 4]).max() < 0.02
