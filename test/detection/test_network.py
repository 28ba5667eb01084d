# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several images at a time through one network."""

from __future__ import annotations

import runpy
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import detect_all
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector

pytest.importorskip("onnx", reason="onnx builds the test's models; pip install '.[test]'")
_HERE = Path(__file__)
white_box_model = runpy.run_path(str(_HERE.with_name("synthetic_model.py")))["white_box_model"]
SMALL, LARGE = (96, 64), (320, 288)


def picture(size, left):
    image = np.zeros((size[1], size[0], 3), np.uint8)
    image[20:40, left : left + 30] = 255
    return image


PICTURES = [picture(SMALL, 10), picture(LARGE, 100), picture(SMALL, 50), picture(LARGE, 7)]


def loaded(folder, backend, **values):
    path = white_box_model(folder / "m.onnx")
    return load_detector(DetectorConfig(model=str(path), backend=backend, **values))


def lefts(found):
    return [float(one.xyxy[0, 0]) + 0.5 for one in found]


class Runs:
    """What a network does, and with which image's width: begin (B), run (R), wait (W)."""

    def __init__(self, network):
        self.order, self._run = [], network.run

    def run(self, values):
        self.order.append(("R", values.shape[-1]))
        return self._run(values)

    def begin(self, values):
        self.order.append(("B", values.shape[-1]))

        def wait():
            self.order.append(("W", values.shape[-1]))
            return self._run(values)

        return wait


def test_the_largest_is_run_beside_those_of_other_sizes(tmp_path):
    detector = loaded(tmp_path, "onnxruntime")
    assert lefts(detect_all(detector, PICTURES)) == [10, 100, 50, 7]
    runs = Runs(detector._network)
    detector._network = replace(detector._network, run=runs.run, begin=runs.begin)
    began = time.perf_counter()
    found = detect_all(detector, PICTURES)
    passed_ms = 1e3 * (time.perf_counter() - began)
    assert lefts(found) == [10, 100, 50, 7]
    assert runs.order == [("B", 320), ("R", 96), ("R", 96), ("W", 320), ("R", 320)]
    assert sum(sum(one.timings_ms.values()) for one in found) < passed_ms
    runs.order.clear()
    assert lefts(detect_all(detector, PICTURES[::2])) == [10, 50]
    assert detect_all(detector, []) == []
    assert runs.order == [("R", 96)] * 2


def test_images_that_are_shrunk_to_one_size_are_run_in_turn(tmp_path):
    detector = loaded(tmp_path, "onnxruntime", image_size=320)
    runs = Runs(detector._network)
    detector._network = replace(detector._network, run=runs.run, begin=runs.begin)
    pictures = [picture((320, 320), 10), picture((640, 640), 100), picture(SMALL, 50)]
    assert len(detect_all(detector, pictures[:2])) == 2
    assert runs.order == [("R", 320)] * 2
    runs.order.clear()
    detect_all(detector, pictures)
    assert runs.order == [("B", 320), ("R", 96), ("W", 320), ("R", 320)]


def test_one_that_fails_leaves_none_running(tmp_path):
    detector = loaded(tmp_path, "onnxruntime")
    runs = Runs(detector._network)

    def fail(_):
        raise MemoryError

    detector._network = replace(detector._network, run=fail, begin=runs.begin)
    with pytest.raises(ModelError, match=r"ran out of memory on an image of 96"):
        detect_all(detector, PICTURES)
    assert runs.order == [("B", 320), ("W", 320)]


def test_on_openvino_images_side_by_side_give_the_same_boxes(tmp_path):
    pytest.importorskip("openvino", reason="openvino is not installed")
    detector = loaded(tmp_path, "openvino", precision="f32", threads=2)
    assert detector._network.begin is not None
    for _ in range(60):  # from any size on, models for these two sizes are compiled beside
        assert lefts(detect_all(detector, PICTURES)) == [10, 100, 50, 7]
    assert loaded(tmp_path, "openvino", threads=1)._network.begin is None
