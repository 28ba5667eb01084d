# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exports an ONNX model to 8 bits (int8) by calibration on images, without training.

The file keeps ONNX's own operators and says in QuantizeLinear and DequantizeLinear where values are
in 8 bits; so every runtime reads it, but each is fast with a different arrangement of those.
"""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import AerialGnssError, ModelError
from aerial_gnss_ros.detection.network import first_line
from aerial_gnss_ros.detection.onnx_model import input_size
from aerial_gnss_ros.training.calibration_images import CalibrationImages
from aerial_gnss_ros.training.onnx_graph import keep_metadata, last_nodes, read_float_model


@dataclass(frozen=True)
class Arrangement:
    """Where a runtime needs values in 8 bits.

    Attributes:
        symmetric: signed, zero is 0 (TensorRT knows nothing else); else unsigned with an offset,
            which uses all 256 steps for values that are mostly positive.
        outputs: also after each convolution. ONNX Runtime computes in 8 bits only then; OpenVINO
            and TensorRT join the activation to the convolution, and round once less without.
        operators: those computed in 8 bits.
    """

    symmetric: bool
    outputs: bool
    operators: tuple[str, ...] = ("Conv",)


_ALL = ("Conv", "Mul", "Sigmoid", "Concat", "Add", "MaxPool", "Resize", "Split")
ARRANGEMENTS = {
    "openvino": Arrangement(symmetric=False, outputs=False),
    "onnxruntime": Arrangement(symmetric=False, outputs=True, operators=_ALL),
    "tensorrt": Arrangement(symmetric=True, outputs=False),
}


@dataclass(frozen=True)
class Quantization:
    """Settings of a calibration.

    Attributes:
        images: to calibrate on; as the camera takes them.
        runtime: key of `ARRANGEMENTS`: the runtime to optimise for.
        longest: longest side of the images given to the network, px.
        reduce_range: weights in 7 bits: processors without VNNI (before 2019, say) overflow in 8
            with ONNX Runtime.
    """

    images: tuple[Path, ...]
    runtime: str = "openvino"
    longest: int = 1280
    reduce_range: bool = False


def export_int8(
    source: Path, output: Path, how: Quantization, report: Any = lambda _: None
) -> Path:
    """Write `source` with convolutions in 8 bits, weights for each channel by itself.

    The last convolutions, which give the logits of sides and scores, and all nodes after them stay
    in 32 bits: docs/results/detection.md has cost and benefit.

    Args:
        source: .onnx in fp32.
        output: .onnx to write; must not exist.
        how: images and runtime.
        report: called with the number of images processed.

    Raises:
        InputError: a damaged image.
        ModelError: `source` is unusable, or onnx is not installed.
        OutputError: `output` exists or cannot be written.
    """
    model = read_float_model(source)
    import onnx

    with tempfile.TemporaryDirectory() as folder:
        named, made = Path(folder) / "named.onnx", Path(folder) / "made.onnx"
        onnx.save(model, named)
        try:
            _quantize(model, named, made, how, report)
        except AerialGnssError:
            raise
        except Exception as error:  # ONNX Runtime has no common error
            raise ModelError(
                f"{source} cannot be converted to int8: {first_line(error)}"
            ) from error
        result = onnx.load(made)
    keep_metadata(model, result, precision="int8", quantized_for=how.runtime)
    with partial(output) as file:
        onnx.save(result, file)
    return output


def _quantize(model: Any, named: Path, made: Path, how: Quantization, report: Any) -> None:
    from onnxruntime.quantization import QuantFormat, QuantType, quantize_static

    arrangement = ARRANGEMENTS[how.runtime]
    last, behind = last_nodes(model)
    item = model.graph.input[0]
    sides = [side.dim_value or None for side in item.type.tensor_type.shape.dim]
    size = input_size(sides, named.name)
    options: dict[str, Any] = {"ActivationSymmetric": arrangement.symmetric}
    if arrangement.symmetric:
        options["QuantizeBias"] = False  # TensorRT adds the bias in floating point
    if not arrangement.outputs:
        options["OpTypesToExcludeOutputQuantization"] = ["Conv"]
    with _silence():
        quantize_static(
            named,
            made,
            CalibrationImages(how.images, item.name, size, how.longest, report),
            quant_format=QuantFormat.QDQ,
            op_types_to_quantize=list(arrangement.operators),
            nodes_to_exclude=last + behind,
            per_channel=True,
            reduce_range=how.reduce_range,
            activation_type=QuantType.QInt8 if arrangement.symmetric else QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            extra_options=options,
        )


@contextmanager
def _silence() -> Iterator[None]:
    """Suppress advice about other models (to pre-process, to optimise)."""
    logger = logging.getLogger()
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(before)
