# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A network in 8 bits finds what it finds in 32; what cannot be exported is refused."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError, ModelError, OutputError
from aerial_gnss_ros.resources import model_path

onnx = pytest.importorskip("onnx", reason="pip install '.[export]'")
pytest.importorskip("onnxruntime")

sys.path.insert(0, str(Path(__file__).parent))

from networks import output, sample, types  # noqa: E402

from aerial_gnss_ros.training.calibration_images import choose_images  # noqa: E402
from aerial_gnss_ros.training.half import export_half  # noqa: E402
from aerial_gnss_ros.training.quantize import Quantization, export_int8  # noqa: E402


@pytest.mark.parametrize("runtime", ["openvino", "tensorrt"])
def test_int8_keeps_boxes_ends_and_names(tmp_path, pictures, runtime):
    source = model_path("aqua_yolo11n.onnx")
    how = Quantization(tuple(choose_images(pictures)), runtime)
    made = export_int8(source, tmp_path / "int8.onnx", how)
    kinds, metadata = types(made)
    assert kinds == {onnx.TensorProto.FLOAT}
    assert (metadata["names"], metadata["quantized_for"]) == ("{0: 'aqua'}", runtime)
    assert made.stat().st_size < 0.4 * source.stat().st_size
    image = sample(pictures)
    exact, rough = output(source, image), output(made, image)
    likely = exact[0, 4] > 0.3
    assert likely.any()
    assert np.median(np.abs(rough[0, :4, likely] - exact[0, :4, likely])) < 2.0  # px
    assert np.median(np.abs(rough[0, 4, likely] - exact[0, 4, likely])) < 0.1
    zeros = {
        onnx.numpy_helper.to_array(value).dtype.name
        for value in onnx.load(made).graph.initializer
        if value.name.endswith("_zero_point") and "weight" not in value.name
    }
    # TensorRT takes signed values only; the others are faster with unsigned ones.
    assert ("uint8" in zeros) == (runtime != "tensorrt")


def test_what_cannot_be_exported_leaves_nothing(tmp_path):
    source = model_path("aqua_yolo11n.onnx")
    made = tmp_path / "made.onnx"
    half = export_half(source, tmp_path / "half.onnx")
    text = tmp_path / "text.onnx"
    text.write_text("no model")
    cut = tmp_path / "cut.onnx"
    cut.write_bytes(source.read_bytes()[:100_000])
    for bad, words in (
        (tmp_path / "none.onnx", "does not exist"),
        (tmp_path / "weights.pt", "not an .onnx file"),
        (text, "not an ONNX model"),
        (cut, "not an ONNX model"),
        (half, "16 bits already"),
    ):
        with pytest.raises(ModelError, match=words):
            export_half(bad, made)
        with pytest.raises(ModelError, match=words):
            export_int8(bad, made, Quantization(()))
    with pytest.raises(OutputError, match="exists already"):
        export_half(source, half)
    damaged = tmp_path / "pictures" / "a.jpg"
    damaged.parent.mkdir()
    damaged.write_bytes(b"\xff\xd8 no picture")
    with pytest.raises(InputError, match=r"a\.jpg"):
        export_int8(source, made, Quantization((damaged,)))
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "cut.onnx", "half.onnx", "pictures", "text.onnx",
    ]  # fmt: skip
