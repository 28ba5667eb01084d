# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The ultralytics back end: its contract with a stand-in, and with the real one where it is."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector


class Tensor:
    """As much of a torch tensor as the back end may use."""

    def __init__(self, values):
        self._values = np.asarray(values, np.float32)

    def cpu(self):
        return self

    def numpy(self):
        return self._values


class Yolo:
    """As much of ultralytics.YOLO as the back end may use."""

    names = {1: "buoy", 0: "aqua"}  # noqa: RUF012 - as ultralytics has it
    task = "detect"
    calls: list = []  # noqa: RUF012 - shared, for the test to look at

    def __init__(self, path, task=None):
        type(self).calls.append((path, task))

    def predict(self, image, **options):
        type(self).calls.append((image.shape, options))
        boxes = SimpleNamespace(
            xyxy=Tensor([[10, 20, 30, 40], [0, 0, 64, 48]]),
            conf=Tensor([0.4, 0.9]),
            cls=Tensor([1, 0]),
        )
        return [SimpleNamespace(boxes=boxes)]


@pytest.fixture
def stand_in(monkeypatch):
    module = ModuleType("ultralytics")
    module.YOLO = Yolo
    monkeypatch.setitem(sys.modules, "ultralytics", module)
    monkeypatch.setattr(Yolo, "calls", [])
    return Yolo


def model(tmp_path, suffix=".pt"):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"weights")
    return str(path)


def test_results_become_detections(tmp_path, stand_in):
    config = DetectorConfig(
        model=model(tmp_path), allow_pickle=True, score_threshold=0.3, iou_threshold=0.4,
        max_detections=7, image_size=1280, device="cpu",
    )  # fmt: skip
    detector = load_detector(config)
    found = detector.detect(np.zeros((48, 64, 3), np.uint8))
    assert detector.class_names == ("aqua", "buoy")
    assert found.names == ("aqua", "buoy")  # the surer one first
    np.testing.assert_allclose(found.xywh, [[31.5, 23.5, 64, 48], [19.5, 29.5, 20, 20]])
    shape, options = stand_in.calls[-1]
    assert shape == (48, 64, 3)
    assert options == {
        "imgsz": 64, "conf": 0.3, "iou": 0.4, "max_det": 7, "verbose": False, "device": "cpu",
    }  # fmt: skip


def test_an_engine_needs_no_consent_and_says_its_task(tmp_path, stand_in):
    load_detector(DetectorConfig(model=model(tmp_path, ".engine"), backend="ultralytics"))
    assert stand_in.calls[0][1] == "detect"


@pytest.mark.usefixtures("stand_in")
def test_its_settings_are_the_users_or_a_folder_that_goes_with_the_process(tmp_path, monkeypatch):
    monkeypatch.setenv("YOLO_CONFIG_DIR", str(tmp_path))
    config = DetectorConfig(model=model(tmp_path), allow_pickle=True)
    load_detector(config)
    assert os.environ["YOLO_CONFIG_DIR"] == str(tmp_path)
    monkeypatch.setenv("YOLO_CONFIG_DIR", "")
    load_detector(config)
    made = Path(os.environ["YOLO_CONFIG_DIR"])
    assert made.is_dir()
    assert not list(made.iterdir())
    assert made.parent == Path(tempfile.gettempdir())


def test_other_tasks_and_numbers_of_classes_are_refused(tmp_path, stand_in, monkeypatch):
    config = DetectorConfig(model=model(tmp_path), allow_pickle=True, class_names=("aqua",))
    with pytest.raises(ModelError, match="knows 2 classes"):
        load_detector(config)
    monkeypatch.setattr(stand_in, "task", "segment")
    with pytest.raises(ModelError, match="task segment"):
        load_detector(config)


def test_absent_ultralytics_is_said(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ultralytics", None)
    with pytest.raises(ModelError, match="needs ultralytics; install it"):
        load_detector(DetectorConfig(model=model(tmp_path), allow_pickle=True))


@pytest.mark.ultralytics
def test_weights_and_their_export_find_the_same_boxes(tmp_path):
    torch = pytest.importorskip("torch", reason="needs the extra [ultralytics]")
    ultralytics = pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
    from aerial_gnss_ros.training.export import export

    torch.manual_seed(0)
    network = ultralytics.YOLO("yolo11n.yaml")
    for layer in network.model.modules():  # without statistics, signals die out on their way
        if isinstance(layer, torch.nn.BatchNorm2d):
            layer.momentum = 1.0
    network.model.train()
    network.model(torch.rand(4, 3, 96, 160))
    head = network.model.model[-1]
    for branch in head.cv3:  # scores near a half instead of near nothing: there are boxes
        torch.nn.init.normal_(branch[-1].weight, std=0.05)
        torch.nn.init.constant_(branch[-1].bias, 0.0)
    network.save(tmp_path / "random.pt")
    onnx = export(tmp_path / "random.pt", tmp_path / "random.onnx")
    image = np.random.default_rng(0).integers(0, 255, (96, 160, 3), dtype=np.uint8)

    def boxes(path, backend):
        config = DetectorConfig(
            model=str(path), backend=backend, allow_pickle=True, score_threshold=0.01,
            iou_threshold=1.0, max_detections=1000,
        )  # fmt: skip
        found = load_detector(config).detect(image)
        return np.hstack([found.xywh, found.scores[:, None]])

    # Nothing is suppressed, as the order of equal scores is nobody's promise.
    theirs, ours = boxes(tmp_path / "random.pt", "ultralytics"), boxes(onnx, "onnxruntime")
    assert len(theirs) == len(ours) == 12 * 20 + 6 * 10 + 3 * 5
    apart = np.abs(theirs[:, None] - ours[None]) / [0.1, 0.1, 0.1, 0.1, 1e-3]
    assert apart.max(axis=2).min(axis=1).max() < 1.0
    assert apart.max(axis=2).min(axis=0).max() < 1.0
    assert np.ptp(theirs[:, 4]) > 0.01


@pytest.mark.ultralytics
def test_damaged_weights_are_refused(tmp_path):
    pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
    with pytest.raises(ModelError, match="not a model that ultralytics can read"):
        load_detector(DetectorConfig(model=model(tmp_path), allow_pickle=True))
