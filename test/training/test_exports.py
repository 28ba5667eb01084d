# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The shipped model in 16 and 8 bits finds what it finds in 32; what cannot be exported is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError, ModelError, OutputError
from aerial_gnss_ros.resources import model_path

onnx = pytest.importorskip("onnx", reason="pip install '.[export]'")
ort = pytest.importorskip("onnxruntime")

from aerial_gnss_ros.training.calibration_images import choose_images  # noqa: E402
from aerial_gnss_ros.training.half import export_half  # noqa: E402
from aerial_gnss_ros.training.onnx_graph import last_nodes, read_float_model  # noqa: E402
from aerial_gnss_ros.training.quantize import Quantization, export_int8  # noqa: E402


@pytest.fixture(scope="module")
def pictures(tmp_path_factory) -> Path:
    """Three rendered crops: enough to see that ranges are taken, not to score."""
    from aerial_gnss_ros.simulation.dataset import DatasetConfig, generate

    folder = tmp_path_factory.mktemp("pictures") / "crops"
    generate(folder, DatasetConfig({"test": 3}, size=(320, 320), seed=2024))
    return folder / "images"


def output(model: Path, image: np.ndarray) -> np.ndarray:
    options = ort.SessionOptions()
    options.intra_op_num_threads = 1
    options.log_severity_level = 3
    session = ort.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
    return session.run(None, {session.get_inputs()[0].name: image})[0]


def sample(pictures: Path) -> np.ndarray:
    from aerial_gnss_ros.detection.images import read_image
    from aerial_gnss_ros.detection.onnx_model import tensor

    return tensor(read_image(choose_images(pictures)[0]), np.float32)


def types(path: Path) -> tuple[set[int], dict[str, str]]:
    model = onnx.load(path)
    ends = [*model.graph.input, *model.graph.output]
    metadata = {item.key: item.value for item in model.metadata_props}
    return {item.type.tensor_type.elem_type for item in ends}, metadata


def test_last_nodes_of_the_shipped_model():
    last, behind = last_nodes(read_float_model(model_path("aqua_yolo11n.onnx")))
    # Three scales, each with sides and scores: the heads of YOLO11.
    assert sorted(name.split("/")[2] for name in last) == [
        "cv2.0", "cv2.1", "cv2.2", "cv3.0", "cv3.1", "cv3.2",
    ]  # fmt: skip
    assert "/model.23/dfl/conv/Conv" in behind
    assert not any("/model.22/" in name for name in behind)


def test_half_keeps_boxes_ends_and_names(tmp_path, pictures):
    source = model_path("aqua_yolo11n.onnx")
    made = export_half(source, tmp_path / "half.onnx")
    kinds, metadata = types(made)
    assert kinds == {onnx.TensorProto.FLOAT}
    assert metadata["names"] == "{0: 'aqua'}"
    assert metadata["precision"] == "fp16"
    assert made.stat().st_size < 0.55 * source.stat().st_size
    image = sample(pictures)
    exact, half = output(source, image), output(made, image)
    likely = exact[0, 4] > 0.05
    assert likely.any()
    assert np.abs(half[0, :4, likely] - exact[0, :4, likely]).max() < 0.5  # px
    assert np.abs(half[0, 4] - exact[0, 4]).max() < 0.02


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


def test_calibration_images_are_spread_over_the_folder(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        choose_images(tmp_path / "none")
    with pytest.raises(InputError, match="no calibration images"):
        choose_images(tmp_path)
    for number in range(10):
        (tmp_path / f"{number}.png").touch()
    (tmp_path / "notes.txt").touch()
    assert [path.name for path in choose_images(tmp_path, 4)] == [
        "0.png", "3.png", "6.png", "9.png",
    ]  # fmt: skip
    (tmp_path / "contact_sheet.png").touch()  # of `augment`: no camera takes that
    assert len(choose_images(tmp_path, 100)) == 10
