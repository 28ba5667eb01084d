# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What an exported network gives, by ONNX Runtime itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

onnx = pytest.importorskip("onnx", reason="pip install '.[export]'")
ort = pytest.importorskip("onnxruntime")

from aerial_gnss_ros.detection.images import read_image  # noqa: E402
from aerial_gnss_ros.detection.onnx_model import tensor  # noqa: E402
from aerial_gnss_ros.training.calibration_images import choose_images  # noqa: E402


def output(model: Path, image: np.ndarray) -> np.ndarray:
    """Return what a network makes of an image."""
    options = ort.SessionOptions()
    options.intra_op_num_threads = 1
    options.log_severity_level = 3
    session = ort.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
    return session.run(None, {session.get_inputs()[0].name: image})[0]


def sample(pictures: Path) -> np.ndarray:
    """Return a picture as a network takes it."""
    return tensor(read_image(choose_images(pictures)[0]), np.float32)


def types(path: Path) -> tuple[set[int], dict[str, str]]:
    """Return the types of a network's ends, and its metadata."""
    model = onnx.load(path)
    ends = [*model.graph.input, *model.graph.output]
    metadata = {item.key: item.value for item in model.metadata_props}
    return {item.type.tensor_type.elem_type for item in ends}, metadata
