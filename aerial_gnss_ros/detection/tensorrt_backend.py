# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""TensorRT engines, as `aerial-gnss export` builds them on the device; TensorRT 8.6 and later.

Written against NVIDIA's documentation of the Python interface; tested with a stand-in, and not on a
GPU by its developers: docs/howto/detection.md.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.cuda import Cuda
from aerial_gnss_ros.detection.engine_card import check_fits, read_card
from aerial_gnss_ros.detection.network import Network, NetworkDetector
from aerial_gnss_ros.detection.onnx_model import check_file, input_size, tensor
from aerial_gnss_ros.resources import install_hint


def load(path: Path, config: DetectorConfig) -> NetworkDetector:
    """Return the detector of an .engine file.

    Args:
        path: the .engine file, with its sidecar.
        config: thresholds and size.

    Raises:
        ModelError: missing, no sidecar, built for another device or version, no TensorRT or GPU.
    """
    check_file(path, kind="an .engine file, which `aerial-gnss export` builds on this device")
    card = read_card(path)
    trt = tensorrt()
    cuda = Cuda()
    check_fits(path, card, trt.__version__, cuda.gpu.name, cuda.gpu.compute_capability)
    engine = Engine(trt, cuda, path)
    network = Network(
        path=path,
        runtime=f"TensorRT {trt.__version__}, {cuda.gpu.name}, {card.precision}",
        prepare=lambda image: tensor(image, engine.dtype),
        run=engine.run,
        size=input_size([side if side > 0 else None for side in card.input_shape], str(path)),
        metadata=card.metadata,
        close=engine.close,
    )
    return NetworkDetector(network, config)


def tensorrt() -> Any:
    """Return the module tensorrt.

    Raises:
        ModelError: not installed.
    """
    try:
        import tensorrt as trt
    except ImportError as error:
        raise ModelError(
            "TensorRT is not installed; on a Jetson it comes with JetPack (python3-libnvinfer), "
            f"elsewhere with {install_hint('tensorrt')}; or give the .onnx file."
        ) from error
    return trt


class Engine:
    """An engine with memory for its input and output on the GPU.

    Args:
        trt: the module tensorrt.
        cuda: the CUDA runtime.
        path: the .engine file.

    Raises:
        ModelError: TensorRT cannot load it, or it has not one input and one output.
    """

    def __init__(self, trt: Any, cuda: Cuda, path: Path) -> None:
        self._cuda = cuda
        self._logger = trt.Logger(trt.Logger.ERROR)
        self._runtime = trt.Runtime(self._logger)
        self._engine = self._runtime.deserialize_cuda_engine(path.read_bytes())
        if self._engine is None:
            raise ModelError(f"TensorRT {trt.__version__} cannot load {path}; rebuild it.")
        self._context = self._engine.create_execution_context()
        names = [self._engine.get_tensor_name(i) for i in range(self._engine.num_io_tensors)]
        taken = trt.TensorIOMode.INPUT
        inputs = [name for name in names if self._engine.get_tensor_mode(name) == taken]
        outputs = [name for name in names if name not in inputs]
        if len(inputs) != 1 or len(outputs) != 1:
            raise ModelError(
                f"{path} has {len(inputs)} inputs and {len(outputs)} outputs; a detection model "
                "has one of each."
            )
        self._input, self._output = inputs[0], outputs[0]
        self.dtype = np.dtype(trt.nptype(self._engine.get_tensor_dtype(self._input))).type
        self._out_type = trt.nptype(self._engine.get_tensor_dtype(self._output))
        self._memory: dict[str, tuple[int, int]] = {}  # tensor -> address and bytes

    def run(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Return the output for one input (1, 3, height, width)."""
        if not self._context.set_input_shape(self._input, values.shape):
            raise ModelError(f"the engine was not built for an input of {values.shape}.")
        shape = tuple(self._context.get_tensor_shape(self._output))
        result = np.empty(shape, dtype=self._out_type)
        values = np.ascontiguousarray(values)
        source = self._room(self._input, values.nbytes)
        target = self._room(self._output, result.nbytes)
        self._cuda.to_gpu(source, values)
        if not self._context.execute_async_v3(int(self._cuda.stream)):
            raise RuntimeError("TensorRT could not start the inference")
        self._cuda.from_gpu(result, target)
        self._cuda.wait()
        return [result]

    def _room(self, name: str, size: int) -> int:
        """Return memory for a tensor, the same as before if it is large enough."""
        address, owned = self._memory.get(name, (0, 0))
        if owned < size:
            if owned:
                self._cuda.free(address)
                del self._memory[name]
            address = self._cuda.allocate(size)
            self._memory[name] = (address, size)
            self._context.set_tensor_address(name, address)
        return address

    def close(self) -> None:
        """Release the GPU's memory."""
        for address, _ in self._memory.values():
            self._cuda.free(address)
        self._memory = {}
        self._context = self._engine = None
