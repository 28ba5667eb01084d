# SPDX-License-Identifier: Apache-2.0
"""ONNX models on OpenVINO: the fastest on Intel and AMD processors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.network import Network, NetworkDetector
from aerial_gnss_ros.detection.onnx_model import check_file, input_size

_WORDS = {"f32": "32 bits", "bf16": "bfloat16"}


def load(path: Path, config: DetectorConfig) -> NetworkDetector:
    """Return the detector of an .onnx file.

    Args:
        path: the .onnx file.
        config: thresholds, size, threads and precision.

    Raises:
        ConfigError: a precision that this processor does not have.
        ModelError: missing, not a model, or a model with another input or output.
    """
    check_file(path)
    model = _read(path)
    if len(model.inputs) != 1:
        raise ModelError(f"{path} has {len(model.inputs)} inputs; a detection model has one.")
    sides = model.inputs[0].partial_shape
    size = input_size([None if side.is_dynamic else side.get_length() for side in sides], str(path))
    metadata = _metadata(model)
    if metadata.get("quantized_for") == "tensorrt":
        raise ModelError(
            f"{path} is in 8 bits for TensorRT, signed, which OpenVINO computes wrongly; use it on "
            "onnxruntime, or export it with --runtime openvino."
        )
    precision = _precision(config.precision)
    requests = _Requests(_with_preparation(model), path, config.threads, precision)
    words = _WORDS[precision]
    if metadata.get("precision") == "int8":
        words = f"8 bits, the rest in {words}"
    network = Network(
        path=path,
        runtime=f"OpenVINO, processor, {words}",
        prepare=_as_batch,
        run=requests.run,
        size=size,
        metadata=metadata,
    )
    return NetworkDetector(network, config)


def _as_batch(image: Image) -> Image:
    return np.ascontiguousarray(image)[None]


class _Requests:
    """Runs a model; sizes of images that come again get a model compiled for just them.

    That is a quarter faster than a model for any size, which matters most for the small windows of
    `search.mode` roi. Compiling takes a quarter of a second, once for each size.

    Raises:
        ModelError: the model cannot be compiled.
    """

    _MOST = 12  # sizes; each takes some 20 MB

    def __init__(self, model: Any, path: Path, threads: int, precision: str) -> None:
        self._compile: Callable[[Any], Any] = lambda made: _compile(made, path, threads, precision)
        self._model = model
        self._any = self._compile(model)
        self._free = model.inputs[0].partial_shape.is_dynamic
        self._seen: set[tuple[int, ...]] = set()
        self._own: dict[tuple[int, ...], Any] = {}

    def run(self, values: Image) -> list[NDArray[Any]]:
        """Return the outputs for a batch of one image."""
        request = self._request(values.shape)
        return list(request.infer({0: values}, share_inputs=True, share_outputs=True).to_tuple())

    def _request(self, shape: tuple[int, ...]) -> Any:
        if shape in self._own:
            return self._own[shape]
        if not self._free or shape not in self._seen or len(self._own) >= self._MOST:
            self._seen.add(shape)
            return self._any
        fitted = self._model.clone()
        fitted.reshape(list(shape))
        self._own[shape] = self._compile(fitted)
        return self._own[shape]


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


def _with_preparation(model: Any) -> Any:
    """Return the model with an input of bytes: colours and scale become part of its first layer."""
    from openvino import Layout, Type
    from openvino.preprocess import ColorFormat, PrePostProcessor

    kind = model.inputs[0].element_type
    preparation = PrePostProcessor(model)
    image = preparation.input()
    image.tensor().set_element_type(Type.u8).set_layout(Layout("NHWC"))
    image.tensor().set_color_format(ColorFormat.BGR)
    image.model().set_layout(Layout("NCHW"))
    steps = image.preprocess().convert_element_type(Type.f32)
    steps.convert_color(ColorFormat.RGB).scale(255.0)
    if kind != Type.f32:
        steps.convert_element_type(kind)
    return preparation.build()


def _precision(asked: str) -> str:
    """Return f32 or bf16.

    Raises:
        ConfigError: bf16 on a processor without it, where it would be slower than f32.
    """
    import openvino

    able = "BF16" in openvino.Core().get_property("CPU", "OPTIMIZATION_CAPABILITIES")
    if asked == "bf16" and not able:
        raise ConfigError(
            "this processor has no bf16 (AVX512-BF16 or AMX); set precision to f32 or auto."
        )
    return "bf16" if able and asked != "f32" else "f32"


def _compile(model: Any, path: Path, threads: int, precision: str) -> Any:
    import openvino

    options: dict[str, Any] = {
        "INFERENCE_PRECISION_HINT": precision,
        "PERFORMANCE_HINT": "LATENCY",
    }
    if threads:
        options["INFERENCE_NUM_THREADS"] = threads
    try:
        compiled = openvino.Core().compile_model(model, "CPU", options)
        return compiled.create_infer_request()
    except RuntimeError as error:
        raise ModelError(f"{path} cannot be compiled by OpenVINO for this processor.") from error


def _metadata(model: Any) -> dict[str, str]:
    """Return what ONNX calls metadata_props; OpenVINO keeps it as run-time info `framework`."""
    found = {}
    for key in ("names", "task", "precision", "quantized_for"):
        if model.has_rt_info(["framework", key]):
            found[key] = str(model.get_rt_info(["framework", key]).astype(str))
    return found
