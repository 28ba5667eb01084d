# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ONNX models on ONNX Runtime: the default, on the processor, or with CUDA."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.network import Network, NetworkDetector, first_line
from aerial_gnss_ros.detection.onnx_model import check_file, input_size, tensor
from aerial_gnss_ros.resources import install_hint

_TYPES: dict[str, type[np.generic]] = {
    "tensor(float)": np.float32,
    "tensor(float16)": np.float16,
}
_CPU, _CUDA = "CPUExecutionProvider", "CUDAExecutionProvider"


def has_cuda() -> bool:
    """Return whether the installed ONNX Runtime is built for CUDA; there may still be no GPU."""
    try:
        import onnxruntime
    except ImportError:
        return False
    return _CUDA in onnxruntime.get_available_providers()


def load(path: Path, config: DetectorConfig, *, cuda: bool = False) -> NetworkDetector:
    """Return the detector of an .onnx file.

    Args:
        path: the .onnx file.
        config: thresholds, size and threads.
        cuda: on the GPU; else on the processor.

    Raises:
        ConfigError: a precision that ONNX Runtime does not have.
        ModelError: missing, not a model, a model with another input or output, or no CUDA here.
    """
    if config.precision == "bf16":
        raise ConfigError(
            "ONNX Runtime has no precision bf16; use the back end openvino, or set precision to "
            "auto."
        )
    check_file(path)
    session = open_session(path, config.threads, cuda=cuda)
    inputs = session.get_inputs()
    if len(inputs) != 1 or inputs[0].type not in _TYPES:
        types = ", ".join(f"{item.name}: {item.type}" for item in inputs)
        raise ModelError(
            f"{path} takes {types or 'no input'}, but one image of type float is needed; export "
            "it from YOLO with task detect."
        )
    name, dtype = inputs[0].name, _TYPES[inputs[0].type]
    metadata = session.get_modelmeta().custom_metadata_map

    def prepare(image: Image) -> NDArray[Any]:
        return tensor(image, dtype)

    def run(values: NDArray[Any]) -> list[NDArray[Any]]:
        outputs: list[NDArray[Any]] = session.run(None, {name: values})
        return outputs

    network = Network(
        path=path,
        runtime=_words(cuda, metadata),
        prepare=prepare,
        run=run,
        size=input_size(inputs[0].shape, str(path)),
        metadata=metadata,
    )
    return NetworkDetector(network, config)


def _words(cuda: bool, metadata: dict[str, str]) -> str:
    made_for = metadata.get("quantized_for", "onnxruntime")
    words = f"ONNX Runtime, {'CUDA' if cuda else 'processor'}"
    if made_for != "onnxruntime":
        words += f" (this int8 file is made for {made_for}: slower here than fp32)"
    return words


def open_session(path: Path, threads: int, *, cuda: bool = False) -> Any:
    """Return ONNX Runtime's session of a model.

    Args:
        path: the .onnx file.
        threads: of the processor; 0: one for each core.
        cuda: on the GPU; else on the processor.

    Raises:
        ModelError: no ONNX Runtime, no CUDA, or not a model.
    """
    try:
        import onnxruntime
    except ImportError as error:
        raise ModelError(
            f"ONNX Runtime is not installed; install it with {install_hint()}."
        ) from error
    if cuda and not has_cuda():
        raise ModelError(
            f"the installed ONNX Runtime {onnxruntime.__version__} is built without CUDA; install "
            "onnxruntime-gpu in its place, or choose another back end."
        )
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    # Spinning threads would take a third more CPU time, which the other nodes need.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    # From the second image of a size on, memory would be allocated as one block in addition to the
    # first image's blocks: 11 to 17 MB more, and no faster.
    options.enable_mem_pattern = cuda
    options.log_severity_level = 3  # errors are reported as ModelError
    providers = [_CUDA, _CPU] if cuda else [_CPU]
    try:
        with warnings.catch_warnings():  # missing providers are reported below
            warnings.simplefilter("ignore")
            session = onnxruntime.InferenceSession(str(path), options, providers=providers)
    except Exception as error:  # ONNX Runtime has no common error
        raise ModelError(
            f"{path} is not a model that ONNX Runtime {onnxruntime.__version__} can read: "
            f"{first_line(error)}"
        ) from error
    if cuda and session.get_providers()[0] != _CUDA:  # it silently falls back to the CPU
        raise ModelError(
            "ONNX Runtime found no GPU that CUDA can use; check nvidia-smi, or choose another "
            "back end."
        )
    return session
