# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ONNX models on OpenVINO: the fastest on Intel and AMD processors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.compiled_sizes import CompiledSizes
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.letterbox import Letterbox
from aerial_gnss_ros.detection.network import Network, NetworkDetector
from aerial_gnss_ros.detection.onnx_model import InputSize, check_file, input_size
from aerial_gnss_ros.detection.search_config import ROI
from aerial_gnss_ros.resources import install_hint

_WORDS = {"f32": "32 bits", "bf16": "bfloat16"}
_USUAL = (1280, 720)  # what cameras on drones mostly send, or what is made of it


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
    core = _core()
    model = _read(core, path)
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
    precision = _precision(core, config.precision)
    words = _WORDS[precision]
    if metadata.get("precision") == "int8":
        words = f"8 bits, the rest in {words}"
    trial = _trial(config, size)
    compiled = _Compiler(core, path, config.threads, precision)
    requests = CompiledSizes(
        compiled,
        _with_preparation(model),
        (1, trial[1], trial[0], 3),
        others=config.search.mode == ROI,
    )
    network = Network(
        path=path,
        runtime=f"OpenVINO, processor, {words}",
        prepare=_as_batch,
        run=lambda values: _run(requests[values.shape], values),
        begin=(lambda values: _begin(requests, values)) if compiled.threads > 1 else None,
        size=size,
        metadata=metadata,
        trial=trial,
        close=requests.close,
    )
    return NetworkDetector(network, config)


def _as_batch(image: Image) -> Image:
    return np.ascontiguousarray(image)[None]


def _run(request: Any, values: Image) -> list[NDArray[Any]]:
    """Return the outputs for a batch of one image."""
    return list(request.infer({0: values}, share_inputs=True, share_outputs=True).to_tuple())


def _begin(requests: CompiledSizes, values: Image) -> Callable[[], list[NDArray[Any]]]:
    """Return what waits for the outputs of a batch of one image; others may be run meanwhile."""
    request = requests[values.shape]
    if not requests.has_own(values.shape):  # it runs other sizes too, the next one perhaps
        outputs = [output.copy() for output in _run(request, values)]
        return lambda: outputs
    request.start_async({0: values}, share_inputs=True)

    def wait() -> list[NDArray[Any]]:
        request.wait()
        return [tensor.data for tensor in request.output_tensors]

    return wait


def _trial(config: DetectorConfig, size: InputSize) -> tuple[int, int]:
    """Return the input's width and height for the images that cameras mostly make."""
    if size.fixed:
        return size.fixed
    longest = min(config.image_size, _USUAL[0])
    return Letterbox.flexible(_USUAL, longest).network


def _core() -> Any:
    try:
        import openvino
    except ImportError as error:
        raise ModelError(
            f"OpenVINO is not installed; install it with {install_hint('openvino')}, or choose the "
            "backend onnxruntime."
        ) from error
    return openvino.Core()


def _read(core: Any, path: Path) -> Any:
    try:
        return core.read_model(path)
    except RuntimeError as error:
        from openvino import __version__

        raise ModelError(f"{path} is not a model that OpenVINO {__version__} can read.") from error


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


def _precision(core: Any, asked: str) -> str:
    """Return f32 or bf16.

    Raises:
        ConfigError: bf16 on a processor without it, where it would be slower than f32.
    """
    able = "BF16" in core.get_property("CPU", "OPTIMIZATION_CAPABILITIES")
    if asked == "bf16" and not able:
        raise ConfigError(
            "this processor has no bf16 (AVX512-BF16 or AMX); set precision to f32 or auto."
        )
    return "bf16" if able and asked != "f32" else "f32"


class _Compiler:
    """Compiles a model for this processor.

    Args:
        core: OpenVINO's.
        path: the model's file, for the error.
        threads: 0: one for each core.
        precision: f32 or bf16.

    Attributes:
        threads: of the first model that was compiled. What is for windows has half of them, so that
            two windows are run side by side: threads that share one small window wait for one
            another at each of its layers.
    """

    def __init__(self, core: Any, path: Path, threads: int, precision: str) -> None:
        self._core, self._path = core, path
        self.threads = threads
        self._options = {
            "INFERENCE_PRECISION_HINT": precision,
            "PERFORMANCE_HINT": "LATENCY",
            # Bound to a core, a thread waits for whatever else runs on it, such as ROS.
            "ENABLE_CPU_PINNING": False,
        }

    def __call__(self, model: Any, beside: bool) -> Any:
        """Return what runs a model.

        Raises:
            ModelError: it cannot be compiled, such as for want of memory.
        """
        options: dict[str, Any] = dict(self._options)
        if self.threads:
            options["INFERENCE_NUM_THREADS"] = -(-self.threads // 2) if beside else self.threads
        try:
            compiled = self._core.compile_model(model, "CPU", options)
            self.threads = self.threads or compiled.get_property("INFERENCE_NUM_THREADS")
            return compiled.create_infer_request()
        except RuntimeError as error:
            raise ModelError(
                f"{self._path} cannot be compiled by OpenVINO for this processor."
            ) from error


def _metadata(model: Any) -> dict[str, str]:
    """Return what ONNX calls metadata_props; OpenVINO keeps it as run-time info `framework`."""
    found = {}
    for key in ("names", "task", "precision", "quantized_for"):
        if model.has_rt_info(["framework", key]):
            found[key] = str(model.get_rt_info(["framework", key]).astype(str))
    return found
