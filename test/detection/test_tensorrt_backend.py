# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Engines are built, described, checked and run; with a stand-in for TensorRT: no GPU is needed."""

from __future__ import annotations

import json
import runpy
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.engine_card import card_path, read_card
from aerial_gnss_ros.detection.select import load_detector

pytest.importorskip("onnx", reason="onnx builds the test's models; pip install '.[test]'")
HERE = Path(__file__).parent
white_box_model = runpy.run_path(str(HERE / "synthetic_model.py"))["white_box_model"]
fake = runpy.run_path(str(HERE / "fake_tensorrt.py"))


@pytest.fixture
def device(tmp_path, monkeypatch):
    """A pretended Jetson with TensorRT, and the calls of its builder."""
    gpu, log = fake["Gpu"](), []
    monkeypatch.setitem(sys.modules, "cuda.bindings.runtime", fake["cuda_runtime"](gpu))
    folder = tmp_path / "device"
    folder.mkdir()
    module = fake["tensorrt"](folder, log)
    module.__spec__ = type(sys.__spec__)("tensorrt", None)
    monkeypatch.setitem(sys.modules, "tensorrt", module)
    return gpu, module, log


def build(tmp_path: Path, *arguments: str) -> Path:
    model = tmp_path / "m.onnx"
    if not model.exists():
        white_box_model(model)
    engine = tmp_path / "m.engine"
    assert cli.main(["export", str(model), "-o", str(engine), *arguments]) == 0
    return engine


def white_box() -> np.ndarray:
    image = np.zeros((200, 320, 3), np.uint8)
    image[20:40, 20:60] = 255
    return image


def test_an_engine_finds_what_its_model_finds_and_gives_memory_back(tmp_path, device):
    gpu, _, log = device
    engine = build(tmp_path, "--workspace", "512")
    assert log == [
        1 << 1,  # types as in the file
        ("workspace", 512 << 20),
        ("images", (1, 3, 32, 32), (1, 3, 736, 1280), (1, 3, 1280, 1280)),
    ]
    detector = load_detector(DetectorConfig(model=str(engine)))
    assert "TensorRT 10.3.0, Orin, fp32" in detector.name
    for _ in range(2):
        np.testing.assert_allclose(detector.detect(white_box()).xywh, [[39.5, 29.5, 40, 20]])
    assert len(gpu.memory) == 2
    detector.close()
    assert not gpu.memory


@pytest.mark.usefixtures("device")
def test_the_sidecar_tells_what_the_engine_was_built_for(tmp_path):
    card = read_card(build(tmp_path, "--size", "1280x736"))
    assert (card.tensorrt, card.gpu, card.compute_capability) == ("10.3.0", "Orin", "8.7")
    assert (card.input_shape, card.precision, card.source) == ((1, 3, 736, 1280), "fp32", "m.onnx")
    assert card.metadata["names"] == "{0: 'aqua'}"
    assert len(card.source_sha256) == len(card.engine_sha256) == 64


def test_an_engine_of_exactly_this_model_is_preferred(tmp_path, device):
    build(tmp_path)
    model = tmp_path / "m.onnx"
    assert "TensorRT" in load_detector(DetectorConfig(model=str(model))).name
    device[0].name = b"Thor"
    name = load_detector(DetectorConfig(model=str(model))).name
    assert "tensorrt not used" in name
    assert "built for the GPU Orin, but this device has Thor" in name
    assert "processor" in name
    white_box_model(model, names="{0: 'other'}")  # the engine is not of this one
    assert "tensorrt" not in load_detector(DetectorConfig(model=str(model))).name


def another_version(_gpu, module, _engine):
    module.__version__ = "10.4.0"


def another_gpu(gpu, _module, _engine):
    gpu.name = b"Thor"


def another_capability(gpu, _module, _engine):
    gpu.capability = (8, 9)


def cut_off(_gpu, _module, engine):
    engine.write_bytes(engine.read_bytes()[:-5])


def no_card(_gpu, _module, engine):
    card_path(engine).unlink()


def no_engine(_gpu, _module, engine):
    engine.unlink()


def bad_card(_gpu, _module, engine):
    card_path(engine).write_text(json.dumps({"tensorrt": "10.3.0"}))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (another_version, "built for TensorRT 10.3.0, but this device has 10.4.0"),
        (another_gpu, "built for the GPU Orin, but this device has Thor"),
        (another_capability, r"compute capability 8\.7, but this device has 8\.9"),
        (cut_off, "not copied completely"),
        (no_card, "has no m.engine.json beside it"),
        (bad_card, "cannot be read as an engine's sidecar"),
        (no_engine, r"does not exist; give the path of an \.engine file"),
    ],
)
def test_an_engine_that_does_not_fit_is_refused(tmp_path, device, change, words):
    engine = build(tmp_path)
    change(device[0], device[1], engine)
    with pytest.raises(ModelError, match=words):
        load_detector(DetectorConfig(model=str(engine)))


def test_want_of_memory_and_too_large_images_are_reported_and_survived(tmp_path, device):
    detector = load_detector(DetectorConfig(model=str(build(tmp_path))))
    device[0].room = 1000
    with pytest.raises(ModelError, match="ran out of memory"):
        detector.detect(white_box())
    device[0].room = 1 << 30
    assert len(detector.detect(white_box())) == 1
    detector._config = replace(detector._config, image_size=2560)
    with pytest.raises(ModelError, match="not built for an input of"):
        detector.detect(np.zeros((1440, 2560, 3), np.uint8))


def test_int8_engines_are_made_of_symmetric_models(tmp_path, device):
    from aerial_gnss_ros.training.engine import EnginePlan, build_engine

    model = white_box_model(tmp_path / "m.onnx")
    build_engine(model, tmp_path / "m.engine", EnginePlan(model, "int8"))
    assert device[2][0] == 1 << 0
    assert device[2][2:4] == ["int8", "fp16"]


def test_without_tensorrt_nothing_is_left(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "tensorrt", None)
    model, engine = white_box_model(tmp_path / "m.onnx"), tmp_path / "m.engine"
    assert cli.main(["export", str(model), "-o", str(engine)]) == 2
    assert "TensorRT is not installed" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["m.onnx"]


@pytest.mark.usefixtures("device")
def test_what_tensorrt_cannot_read_leaves_nothing(tmp_path, capsys):
    model, engine = tmp_path / "text.onnx", tmp_path / "text.engine"
    model.write_text("no model")
    assert cli.main(["export", str(model), "-o", str(engine)]) == 2
    assert "TensorRT 10.3.0 cannot read" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["device", "text.onnx"]
