# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Models of every kind through the Detector protocol, and what is refused."""

from __future__ import annotations

import importlib.util
import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError, ModelError
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.select import load_detector, possible_backends

onnx = pytest.importorskip("onnx", reason="onnx builds the test's models; pip install '.[test]'")
white_box_model = runpy.run_path(str(Path(__file__).with_name("synthetic_model.py")))[
    "white_box_model"
]

BACKENDS = [
    "onnxruntime",
    pytest.param(
        "openvino",
        marks=pytest.mark.skipif(
            importlib.util.find_spec("openvino") is None, reason="openvino is not installed"
        ),
    ),
]


def white_box(width: int, height: int, left: int, top: int, right: int, bottom: int) -> np.ndarray:
    image = np.zeros((height, width, 3), np.uint8)
    image[top:bottom, left:right] = 255
    return image


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("end_to_end", [False, True])
@pytest.mark.parametrize("size", [None, (640, 640), (1280, 736)])
def test_boxes_come_back_in_source_pixels(tmp_path, backend, end_to_end, size):
    model = white_box_model(tmp_path / "m.onnx", size=size, end_to_end=end_to_end)
    detector = load_detector(DetectorConfig(model=str(model), backend=backend))
    for width, height in ((1280, 720), (640, 640), (720, 1280), (1920, 1080), (333, 257)):
        edges = (width // 4, height // 8, width // 2, height // 4)
        found = detector.detect(white_box(width, height, *edges))
        assert len(found) == 1
        assert found.names == ("aqua",)
        assert found.scores[0] == pytest.approx(0.75)
        # Pixels from left to right - 1 are white: their middle, as camera models count.
        left, top, right, bottom = edges
        wanted = [(left + right - 1) / 2, (top + bottom - 1) / 2, right - left, bottom - top]
        network = size or (1280, 1280)
        pixel = max(1.0, width / network[0], height / network[1])
        tolerance = 1e-4 if pixel == 1.0 else pixel
        np.testing.assert_allclose(found.xywh[0], wanted, atol=tolerance)


def test_border_boxes_and_empty_images(tmp_path):
    model = white_box_model(tmp_path / "m.onnx")
    detector = load_detector(DetectorConfig(model=str(model), backend="onnxruntime"))
    found = detector.detect(white_box(320, 200, 300, 0, 320, 200))
    np.testing.assert_allclose(found.xywh, [[309.5, 99.5, 20, 200]])
    assert len(detector.detect(np.zeros((200, 320, 3), np.uint8))) == 0
    assert set(found.timings_ms) == {"pre", "infer", "post"}


def test_thresholds_are_the_configuration_s(tmp_path):
    model = str(white_box_model(tmp_path / "m.onnx"))
    image = white_box(320, 200, 20, 20, 60, 40)
    for values, count in (
        ({"score_threshold": 0.6}, 1),
        ({"score_threshold": 0.8}, 0),
        ({"iou_threshold": 0.99}, 2),  # the model's second, slightly larger box is not suppressed
        ({"iou_threshold": 0.99, "max_detections": 1}, 1),
    ):
        config = DetectorConfig(model=model, backend="onnxruntime", **values)
        assert len(load_detector(config).detect(image)) == count


def test_class_names_from_the_configuration(tmp_path):
    nameless = str(white_box_model(tmp_path / "n.onnx", names=None))
    image = white_box(320, 200, 20, 20, 60, 40)

    def names(**values):
        config = DetectorConfig(backend="onnxruntime", **values)
        return load_detector(config).detect(image).names

    assert names(model=nameless) == ("class_0",)
    assert names(model=nameless, class_names=("leader",)) == ("leader",)
    named = str(white_box_model(tmp_path / "m.onnx"))
    with pytest.raises(ModelError, match=r"knows 1 class \(aqua\), but class_names has 2"):
        names(model=named, class_names=("a", "b"))


def test_float16_input(tmp_path):
    model = white_box_model(tmp_path / "m.onnx", dtype=onnx.TensorProto.FLOAT16)
    detector = load_detector(DetectorConfig(model=str(model), backend="onnxruntime"))
    found = detector.detect(white_box(320, 200, 20, 20, 60, 40))
    np.testing.assert_allclose(found.xywh, [[39.5, 29.5, 40, 20]])


@pytest.mark.parametrize("backend", BACKENDS)
def test_models_that_are_none_are_refused(tmp_path, backend):
    def refused(words: str, path: Path) -> None:
        with pytest.raises(ModelError, match=words) as caught:
            load_detector(DetectorConfig(model=str(path), backend=backend))
        assert path.name in str(caught.value)

    refused("does not exist", tmp_path / "missing.onnx")
    (tmp_path / "folder.onnx").mkdir()
    refused("not a file", tmp_path / "folder.onnx")
    (tmp_path / "empty.onnx").touch()
    refused("empty", tmp_path / "empty.onnx")
    (tmp_path / "text.onnx").write_text("this is no model")
    refused("not a model", tmp_path / "text.onnx")
    whole = white_box_model(tmp_path / "m.onnx").read_bytes()
    (tmp_path / "cut.onnx").write_bytes(whole[: len(whole) // 2])
    refused("not a model", tmp_path / "cut.onnx")
    refused("task segment", white_box_model(tmp_path / "seg.onnx", task="segment"))
    refused("cannot be read", white_box_model(tmp_path / "names.onnx", names="{0: aqua"))
    refused("2 classes", white_box_model(tmp_path / "two.onnx", names="{0: 'a', 1: 'b'}"))


def other_model(path: Path, shape: list[int | str], outputs: int = 1) -> Path:
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    nodes = [helper.make_node("Identity", ["x"], [f"y{i}"]) for i in range(outputs)]
    graph = helper.make_graph(
        nodes,
        "other",
        [helper.make_tensor_value_info("x", kind, shape)],
        [helper.make_tensor_value_info(f"y{i}", kind, shape) for i in range(outputs)],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 8
    onnx.save(model, path)
    return path


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("shape", "outputs", "words"),
    [
        ([1, 1, 64, 64], 1, "one colour image"),
        ([4, 3, 64, 64], 1, "one colour image"),
        ([1, 3, 64], 1, "one colour image"),
        ([1, 3, 64, "w"], 1, "both fixed or both free"),
        ([1, 3, 64, 64], 1, r"gives \[1, 3, 64, 64\]"),
        ([1, 3, 64, 64], 2, "2 outputs"),
    ],
)
def test_models_of_another_kind_are_refused(tmp_path, backend, shape, outputs, words):
    model = other_model(tmp_path / "other.onnx", shape, outputs)
    with pytest.raises(ModelError, match=words):
        load_detector(DetectorConfig(model=str(model), backend=backend))


def test_backend_follows_the_file_s_ending():
    present = ["openvino"] if importlib.util.find_spec("openvino") else []
    assert possible_backends(Path("a.onnx"), "auto") == [*present, "onnxruntime"]
    assert possible_backends(Path("a.ONNX"), "onnxruntime") == ["onnxruntime"]
    assert possible_backends(Path("a.pt"), "auto") == ["ultralytics"]
    assert possible_backends(Path("a.engine"), "auto") == ["tensorrt"]
    assert possible_backends(Path("a.engine"), "ultralytics") == ["ultralytics"]
    with pytest.raises(ConfigError, match=r"onnxruntime cannot read a\.pt"):
        possible_backends(Path("a.pt"), "onnxruntime")
    with pytest.raises(ModelError, match=r"ends in '\.tflite'"):
        possible_backends(Path("a.tflite"), "auto")
    with pytest.raises(ModelError, match="has no ending"):
        possible_backends(Path("model"), "auto")


def test_a_back_end_that_only_looks_present_is_passed_over_and_reported(tmp_path, monkeypatch):
    # Built for CUDA, but no GPU: ONNX Runtime then goes on on the processor without a word.
    import onnxruntime

    providers = ["CUDAExecutionProvider", "CPUExecutionProvider"]
    monkeypatch.setattr(onnxruntime, "get_available_providers", lambda: providers)
    model = str(white_box_model(tmp_path / "m.onnx"))
    detector = load_detector(DetectorConfig(model=model))
    assert "cuda not used: ONNX Runtime found no GPU" in detector.name
    assert "processor" in detector.name
    with pytest.raises(ModelError, match="found no GPU"):
        load_detector(DetectorConfig(model=model, backend="cuda"))


def test_precision_is_named_or_refused(tmp_path):
    model = str(white_box_model(tmp_path / "m.onnx"))
    with pytest.raises(ConfigError, match="has no precision bf16"):
        load_detector(DetectorConfig(model=model, backend="onnxruntime", precision="bf16"))
    if importlib.util.find_spec("openvino"):
        config = DetectorConfig(model=model, backend="openvino", precision="f32")
        assert "OpenVINO, processor, 32 bits" in load_detector(config).name


@pytest.mark.skipif(
    importlib.util.find_spec("openvino") is None, reason="openvino is not installed"
)
def test_openvino_refuses_what_it_computes_wrongly(tmp_path):
    path = white_box_model(tmp_path / "m.onnx")
    model = onnx.load(path)
    onnx.helper.set_model_props(model, {"names": "{0: 'aqua'}", "quantized_for": "tensorrt"})
    onnx.save(model, path)
    with pytest.raises(ModelError, match="computes wrongly"):
        load_detector(DetectorConfig(model=str(path), backend="openvino"))
    assert "openvino not used" in load_detector(DetectorConfig(model=str(path))).name


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (MemoryError(), "m.onnx ran out of memory on an image of 320 x 200; lower"),
        (RuntimeError("std::bad_alloc"), "ran out of memory"),
        (RuntimeError("shape mismatch\nat line 7"), "on an image of 320 x 200: shape mismatch$"),
    ],
)
def test_a_failing_runtime_is_one_sentence_and_the_next_image_may_do(tmp_path, error, words):
    model = str(white_box_model(tmp_path / "m.onnx"))
    detector = load_detector(DetectorConfig(model=model, backend="onnxruntime"))
    image, network = white_box(320, 200, 20, 20, 60, 40), detector._network

    def fail(_):
        raise error

    detector._network = replace(network, run=fail)
    with pytest.raises(ModelError, match=words):
        detector.detect(image)
    detector._network = network
    assert len(detector.detect(image)) == 1


def test_a_pickle_needs_consent_before_anything_is_read(tmp_path):
    (tmp_path / "a.pt").write_bytes(b"cos\nsystem\n")
    with pytest.raises(ConfigError, match="allow_pickle"):
        load_detector(DetectorConfig(model=str(tmp_path / "a.pt")))


def test_a_name_that_no_shipped_model_has():
    with pytest.raises(ModelError, match=r"no_such\.onnx does not exist"):
        load_detector(DetectorConfig(model="no_such.onnx"))
    with pytest.raises(ModelError, match="no model is given"):
        load_detector(DetectorConfig(model=""))


def test_neither_torch_nor_ultralytics_is_imported_for_onnx(tmp_path):
    model = white_box_model(tmp_path / "m.onnx")
    program = (
        "import sys\n"
        "from aerial_gnss_ros.detection.config import DetectorConfig\n"
        "from aerial_gnss_ros.detection.select import load_detector\n"
        f"load_detector(DetectorConfig(model={str(model)!r}, backend='onnxruntime'))\n"
        "print(sorted({'torch', 'ultralytics', 'rclpy', 'openvino'} & set(sys.modules)))\n"
    )
    root = Path(__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_configuration_refuses_what_it_does_not_know():
    config = detector_config({"image": {"transport": "compressed"}, "score_threshold": 1})
    assert config.image.full_topic == "camera/image_raw/compressed"
    assert config.score_threshold == 1.0
    with pytest.raises(ConfigError, match="did you mean score_threshold"):
        detector_config({"score_treshold": 0.3})
    with pytest.raises(ConfigError, match=r"0\.001 to 1"):
        detector_config({"score_threshold": 0.0})
    with pytest.raises(ConfigError, match="backend must be one of"):
        detector_config({"backend": "tensorflow"})
