# SPDX-License-Identifier: Apache-2.0
"""ONNX models on ONNX Runtime: the default, on the processor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.errors import ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.network import Network, NetworkDetector, first_line
from aerial_gnss_ros.detection.onnx_model import check_file, input_size

_TYPES: dict[str, type[np.generic]] = {
    "tensor(float)": np.float32,
    "tensor(float16)": np.float16,
}


def load(path: Path, config: DetectorConfig) -> NetworkDetector:
    """Return the detector of an .onnx file.

    Args:
        path: the .onnx file.
        config: thresholds, size and threads.

    Raises:
        ModelError: missing, not a model, or a model with another input or output.
    """
    check_file(path)
    session = _session(path, config.threads)
    inputs = session.get_inputs()
    if len(inputs) != 1 or inputs[0].type not in _TYPES:
        types = ", ".join(f"{item.name}: {item.type}" for item in inputs)
        raise ModelError(
            f"{path} takes {types or 'no input'}, but one image of type float is wanted; export "
            "it from YOLO with task detect."
        )
    name = inputs[0].name

    def run(values: NDArray[Any]) -> list[NDArray[Any]]:
        outputs: list[NDArray[Any]] = session.run(None, {name: values})
        return outputs

    network = Network(
        path=path,
        runtime="ONNX Runtime, processor",
        run=run,
        size=input_size(inputs[0].shape, str(path)),
        dtype=_TYPES[inputs[0].type],
        metadata=session.get_modelmeta().custom_metadata_map,
    )
    return NetworkDetector(network, config)


def _session(path: Path, threads: int) -> Any:
    try:
        import onnxruntime
    except ImportError as error:
        raise ModelError(
            "ONNX Runtime is not installed; install it with `pip install onnxruntime`."
        ) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    # Waiting threads would burn a third more processor time, which the other nodes need.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 3  # what is wrong reaches the reader as ModelError
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # ONNX Runtime has no common error
        raise ModelError(
            f"{path} is not a model that ONNX Runtime {onnxruntime.__version__} can read: "
            f"{first_line(error)}"
        ) from error
