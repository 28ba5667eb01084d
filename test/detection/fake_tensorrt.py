# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A stand-in for TensorRT and the CUDA runtime, by NVIDIA's documentation of their interfaces.

It shows that names, order and arguments of the calls are as documented, and that nothing is left
behind; not that a GPU accepts them. "Memory of the GPU" is memory of this process, and an "engine"
is the text of an ONNX model's path, which ONNX Runtime runs.
"""

from __future__ import annotations

import ctypes
from enum import IntEnum
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import onnxruntime


class Status(IntEnum):
    cudaSuccess = 0  # noqa: N815 - CUDA's names
    cudaErrorMemoryAllocation = 2  # noqa: N815


class Gpu:
    """State of the pretended GPU: change it to be another device."""

    def __init__(self):
        self.name, self.capability, self.room = b"Orin", (8, 7), 1 << 30
        self.memory: dict[int, ctypes.Array] = {}


def cuda_runtime(gpu: Gpu) -> ModuleType:
    module = ModuleType("cuda.bindings.runtime")
    ok = Status.cudaSuccess

    def malloc(size):
        if size > gpu.room:
            return Status.cudaErrorMemoryAllocation, 0
        block = ctypes.create_string_buffer(size)
        gpu.memory[ctypes.addressof(block)] = block
        return ok, ctypes.addressof(block)

    def copy(to, source, size, _kind, stream):
        assert stream == 7
        ctypes.memmove(to, source, size)
        return (ok,)

    def free(address):
        del gpu.memory[address]
        return (ok,)

    module.cudaGetDeviceProperties = lambda _number: (
        ok,
        SimpleNamespace(name=gpu.name, major=gpu.capability[0], minor=gpu.capability[1]),
    )
    module.cudaStreamCreate = lambda: (ok, 7)
    module.cudaStreamSynchronize = lambda _stream: (ok,)
    module.cudaMalloc, module.cudaFree, module.cudaMemcpyAsync = malloc, free, copy
    module.cudaMemcpyKind = SimpleNamespace(cudaMemcpyHostToDevice=1, cudaMemcpyDeviceToHost=2)
    return module


class Context:
    def __init__(self, session):
        self._session, self._addresses, self._shape = session, {}, None

    def set_input_shape(self, _name, shape):
        self._shape = tuple(shape)
        return max(shape) <= 1280

    def get_tensor_shape(self, _name):
        return self._run(np.zeros(self._shape, np.float32)).shape

    def set_tensor_address(self, name, address):
        self._addresses[name] = address

    def execute_async_v3(self, stream):
        assert stream == 7
        count = int(np.prod(self._shape))
        pointer = ctypes.cast(self._addresses["images"], ctypes.POINTER(ctypes.c_float))
        result = self._run(np.ctypeslib.as_array(pointer, (count,)).reshape(self._shape))
        ctypes.memmove(self._addresses["output0"], result.ctypes.data, result.nbytes)
        return True

    def _run(self, values):
        return self._session.run(None, {"images": values})[0]


class Engine:
    num_io_tensors = 2

    def __init__(self, path):
        self._session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])

    def get_tensor_name(self, index):
        return ("images", "output0")[index]

    def get_tensor_mode(self, name):
        return "input" if name == "images" else "output"

    def get_tensor_dtype(self, _name):
        return "float"

    def create_execution_context(self):
        return Context(self._session)


class Config:
    def __init__(self, log):
        self._log = log

    def set_memory_pool_limit(self, pool, size):
        self._log.append((pool, size))

    def set_flag(self, flag):
        self._log.append(flag)

    def add_optimization_profile(self, profile):
        self._log.append(profile.shapes)


class Profile:
    def set_shape(self, name, low, usual, high):
        self.shapes = (name, low, usual, high)


def tensorrt(folder: Path, log: list) -> ModuleType:
    """Return the module; calls of the builder are appended to `log`."""
    module = ModuleType("tensorrt")
    module.__version__ = "10.3.0"
    module.Logger = type("Logger", (), {"ERROR": 1, "__init__": lambda _self, _level: None})
    module.TensorIOMode = SimpleNamespace(INPUT="input", OUTPUT="output")
    module.nptype = lambda _type: np.float32
    module.MemoryPoolType = SimpleNamespace(WORKSPACE="workspace")
    module.BuilderFlag = SimpleNamespace(INT8="int8", FP16="fp16")
    module.NetworkDefinitionCreationFlag = SimpleNamespace(EXPLICIT_BATCH=0, STRONGLY_TYPED=1)

    class Parser:
        num_errors = 1

        def __init__(self, network, _logger):
            self._network = network

        def parse(self, data):
            if b"images" not in data:
                return False
            self._network.path = folder / f"parsed_{len(log)}.onnx"
            self._network.path.write_bytes(data)
            return True

        def get_error(self, _index):
            return "no ModelProto"

    class Builder:
        def __init__(self, _logger):
            pass

        def create_network(self, flags):
            log.append(flags)
            item = SimpleNamespace(name="images", shape=(1, 3, -1, -1))
            return SimpleNamespace(get_input=lambda _index: item)

        def create_builder_config(self):
            return Config(log)

        def create_optimization_profile(self):
            return Profile()

        def build_serialized_network(self, network, _config):
            return str(network.path).encode()

    class Runtime:
        def __init__(self, _logger):
            pass

        def deserialize_cuda_engine(self, data):
            return Engine(data.decode())

    module.Builder, module.OnnxParser, module.Runtime = Builder, Parser, Runtime
    return module
