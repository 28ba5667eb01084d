# SPDX-License-Identifier: Apache-2.0
"""ONNX models on OpenVINO: faster than ONNX Runtime on most Intel and AMD processors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.errors import ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.network import Network, NetworkDetector
from aerial_gnss_ros.detection.onnx_model import check_file, input_size


def load(path: Path, config: DetectorConfig) -> NetworkDetector:
    """Return the detector of an .onnx file.

    Args:
        path: the .onnx file.
        config: thresholds, size and threads.

    Raises:
        ModelError: missing, not a model, or a model with another input or output.
    """
    check_file(path)
    model = _read(path)
    if len(model.inputs) != 1:
        raise ModelError(f"{path} has {len(model.inputs)} inputs; a detection model has one.")
    sides = model.inputs[0].partial_shape
    size = input_size([None if side.is_dynamic else side.get_length() for side in sides], str(path))
    metadata = _metadata(model)
    compiled = _compile(model, path, config.threads)

    def run(values: NDArray[Any]) -> list[NDArray[Any]]:
        return list(compiled(values).to_tuple())

    # OpenVINO turns a float16 input into float32 by itself.
    network = Network(path, "OpenVINO, processor", run, size, np.float32, metadata)
    return NetworkDetector(network, config)


def _read(path: Path) -> Any:
    try:
        import openvino
    except ImportError as error:
        raise ModelError(
            "OpenVINO is not installed; install it with `pip install openvino`, or choose the "
            "backend onnxruntime."
        ) from error
    try:
        return openvino.Core().read_model(path)
    except RuntimeError as error:
        raise ModelError(
            f"{path} is not a model that OpenVINO {openvino.__version__} can read."
        ) from error


def _compile(model: Any, path: Path, threads: int) -> Any:
    import openvino

    # 32 bits: the same boxes as on ONNX Runtime, although many processors could do with 16.
    options: dict[str, Any] = {"INFERENCE_PRECISION_HINT": "f32", "PERFORMANCE_HINT": "LATENCY"}
    if threads:
        options["INFERENCE_NUM_THREADS"] = threads
    try:
        return openvino.Core().compile_model(model, "CPU", options)
    except RuntimeError as error:
        raise ModelError(f"{path} cannot be compiled by OpenVINO for this processor.") from error


def _metadata(model: Any) -> dict[str, str]:
    """Return what ONNX calls metadata_props; OpenVINO keeps it as run-time info `framework`."""
    found = {}
    for key in ("names", "task"):
        if model.has_rt_info(["framework", key]):
            found[key] = str(model.get_rt_info(["framework", key]).astype(str))
    return found
