# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Builds a TensorRT engine of an ONNX model on the device that will fly, with its sidecar.

Written against NVIDIA's documentation of the Python interface (8.6 to 10); tested with a stand-in,
and not on a GPU by its developers: docs/howto/detection.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.cuda import Cuda
from aerial_gnss_ros.detection.engine_card import EngineCard, card_path, sha256
from aerial_gnss_ros.detection.onnx_model import input_size
from aerial_gnss_ros.detection.tensorrt_backend import tensorrt

_SMALLEST, _USUAL, _LARGEST = (32, 32), (1280, 736), (1280, 1280)


@dataclass(frozen=True)
class EnginePlan:
    """What to build.

    Attributes:
        source: the model that the reader named, for the sidecar; `model` may be made of it.
        precision: fp32, fp16 or int8: what `model` is in.
        size: width and height of the input, px; None: any up to 1280x1280, best at 1280x736.
        workspace_mb: memory for the builder's trials; a 4 GB Orin needs a low value.
    """

    source: Path
    precision: str
    size: tuple[int, int] | None = None
    workspace_mb: int = 1024


def build_engine(model: Path, output: Path, plan: EnginePlan) -> Path:
    """Write the engine of `model` (.onnx) and, beside it, its sidecar.

    Raises:
        ModelError: no TensorRT or GPU, or TensorRT cannot build it.
        OutputError: the engine or its sidecar exists, or cannot be written.
    """
    refuse_existing(output)
    refuse_existing(card_path(output))
    trt = tensorrt()
    cuda = Cuda()
    logger = trt.Logger(trt.Logger.ERROR)
    builder = trt.Builder(logger)
    network = builder.create_network(_network_flags(trt, plan.precision))
    parser = trt.OnnxParser(network, logger)
    if not parser.parse(model.read_bytes()):
        reasons = "; ".join(str(parser.get_error(i)) for i in range(parser.num_errors))
        raise ModelError(f"TensorRT {trt.__version__} cannot read {plan.source}: {reasons}")
    config = builder.create_builder_config()
    config.set_memory_pool_limit(trt.MemoryPoolType.WORKSPACE, plan.workspace_mb << 20)
    _set_precision(trt, config, plan.precision)
    shape = _set_sizes(builder, config, network.get_input(0), plan)
    built = builder.build_serialized_network(network, config)
    if built is None:
        raise ModelError(
            f"TensorRT {trt.__version__} could not build {plan.source} on this device; if its "
            "memory ran out, give a smaller --workspace or --size."
        )
    with partial(output) as file:
        file.write_bytes(bytes(built))
        card = EngineCard(
            tensorrt=trt.__version__,
            gpu=cuda.gpu.name,
            compute_capability=cuda.gpu.compute_capability,
            input_shape=shape,
            precision=plan.precision,
            source=plan.source.name,
            source_sha256=sha256(plan.source),
            engine_sha256=sha256(file),
            metadata=_metadata(model),
        )
        # Written before the engine gets its name: an engine without its sidecar is refused.
        with partial(card_path(output)) as sidecar:
            sidecar.write_text(card.text(), encoding="utf-8")
    return output


def _network_flags(trt: Any, precision: str) -> int:
    """Return flags for types: those of the file, or for int8 the builder's choice."""
    flags = trt.NetworkDefinitionCreationFlag
    wanted = "STRONGLY_TYPED" if precision != "int8" else "EXPLICIT_BATCH"
    for name in (wanted, "EXPLICIT_BATCH", "STRONGLY_TYPED"):
        if hasattr(flags, name):
            return 1 << int(getattr(flags, name))
    return 0


def _set_precision(trt: Any, config: Any, precision: str) -> None:
    """Allow what an int8 file leaves in 32 bits to be in 16, where the builder has flags for it."""
    if precision == "int8":
        for name in ("INT8", "FP16"):
            flag = getattr(trt.BuilderFlag, name, None)
            if flag is not None:
                config.set_flag(flag)
    elif precision == "fp16" and not hasattr(trt.NetworkDefinitionCreationFlag, "STRONGLY_TYPED"):
        config.set_flag(trt.BuilderFlag.FP16)


def _set_sizes(builder: Any, config: Any, item: Any, plan: EnginePlan) -> tuple[int, ...]:
    """Set the builder's range of sizes; return the input's shape, -1 for free sides."""
    own = input_size([side if side > 0 else None for side in item.shape], str(plan.source)).fixed
    if own is not None and plan.size not in (None, own):
        raise ModelError(
            f"{plan.source} takes {own[0]}x{own[1]} only; leave --size out, or give that."
        )
    if own is not None:
        return (1, 3, own[1], own[0])
    sizes = [plan.size] * 3 if plan.size else [_SMALLEST, _USUAL, _LARGEST]
    shapes = [(1, 3, height, width) for width, height in sizes if width and height]
    profile = builder.create_optimization_profile()
    profile.set_shape(item.name, *shapes)
    config.add_optimization_profile(profile)
    return shapes[1] if plan.size else (1, 3, -1, -1)


def _metadata(model: Path) -> dict[str, str]:
    """Return the class names and the task from an ONNX model's metadata."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4
    session = onnxruntime.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
    stored = session.get_modelmeta().custom_metadata_map
    return {key: stored[key] for key in ("names", "task") if key in stored}
