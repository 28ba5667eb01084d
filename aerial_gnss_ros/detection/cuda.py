# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The few calls of the CUDA runtime that an engine needs, through NVIDIA's own cuda-python."""

from __future__ import annotations

import contextlib
import importlib
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.resources import install_hint


class CudaError(RuntimeError):
    """A CUDA call failed, for example out of memory."""


@dataclass(frozen=True)
class Gpu:
    """The GPU of this device.

    Attributes:
        name: such as Orin.
        compute_capability: such as 8.7.
    """

    name: str
    compute_capability: str


class Cuda:
    """The CUDA runtime, with errors as exceptions.

    Raises:
        ModelError: cuda-python is not installed, or there is no GPU.
    """

    def __init__(self) -> None:
        self._runtime = _runtime()
        try:
            found = self._call("cudaGetDeviceProperties", 0)
        except CudaError as error:
            raise ModelError(f"there is no GPU that CUDA can use here: {error}.") from error
        name = found.name.decode() if isinstance(found.name, bytes) else str(found.name)
        self.gpu = Gpu(name.rstrip("\0"), f"{found.major}.{found.minor}")
        self.stream = self._call("cudaStreamCreate")

    def allocate(self, size: int) -> int:
        """Return the address of `size` bytes of the GPU's memory."""
        return int(self._call("cudaMalloc", size))

    def free(self, address: int) -> None:
        """Free memory."""
        self._call("cudaFree", address)

    def to_gpu(self, address: int, values: NDArray[Any]) -> None:
        """Queue a copy of a contiguous array, which must stay until `wait`."""
        self._copy(address, values.ctypes.data, values.nbytes, "cudaMemcpyHostToDevice")

    def from_gpu(self, values: NDArray[Any], address: int) -> None:
        """Queue a copy into a contiguous array; it is filled after `wait`."""
        self._copy(values.ctypes.data, address, values.nbytes, "cudaMemcpyDeviceToHost")

    def wait(self) -> None:
        """Wait until all queued work is done."""
        self._call("cudaStreamSynchronize", self.stream)

    def _copy(self, to: int, source: int, size: int, kind: str) -> None:
        direction = getattr(self._runtime.cudaMemcpyKind, kind)
        self._call("cudaMemcpyAsync", to, source, size, direction, self.stream)

    def _call(self, name: str, *arguments: Any) -> Any:
        status, *results = getattr(self._runtime, name)(*arguments)
        if int(status) != 0:
            word = getattr(status, "name", str(status))
            memory = "out of memory: " if "MemoryAllocation" in word else ""
            raise CudaError(f"{memory}{name} gave {word}")
        return results[0] if results else None


def _runtime() -> Any:
    names = ("cuda.bindings.runtime", "cuda.cudart")  # new and old name of one module
    for name in names:
        with contextlib.suppress(ImportError):
            return importlib.import_module(name)
    raise ModelError(f"TensorRT needs cuda-python; install it with {install_hint('tensorrt')}.")
