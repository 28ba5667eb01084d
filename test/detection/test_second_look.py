# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The second look: what it sees, whom it judges, and how it is found."""

from __future__ import annotations

import runpy
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.search import searching
from aerial_gnss_ros.detection.second_look import LookingTwice, SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.views import views

pytest.importorskip("onnx", reason="onnx builds the test's models; pip install '.[test]'")
_HERE = Path(__file__)
_BLOBS = runpy.run_path(str(_HERE.with_name("blobs.py")))
BlobDetector, boxes, sea = (_BLOBS[name] for name in ("BlobDetector", "boxes", "sea"))
white_box_model = runpy.run_path(str(_HERE.with_name("synthetic_model.py")))["white_box_model"]
brightness_look = runpy.run_path(str(_HERE.with_name("brightness_look.py")))["brightness_look"]


@pytest.fixture
def picture():
    return np.random.default_rng(1).integers(0, 256, (400, 600, 3), dtype=np.uint8)


def test_the_near_view_is_the_image_and_the_wide_one_its_mean(picture):
    # A box 32 px long: the near view is 64 px wide, one to one; the wide one 256, four to one.
    box = np.array([[299.5, 199.5, 32.0, 20.0]])
    (seen,) = views(picture, box, Terms(wide=8.0))
    np.testing.assert_array_equal(seen[..., :3], picture[168:232, 268:332])
    wide = picture[72:328, 172:428].reshape(64, 4, 64, 4, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(seen[..., 3:], wide, atol=1.01)  # rounded twice


@pytest.mark.parametrize("long", [11.0, 47.0, 130.0, 333.0])
def test_a_place_is_in_the_middle_of_both_views_whatever_the_size(long):
    image = np.zeros((400, 600, 3), np.uint8)
    cv2.circle(image, (310, 170), round(long / 4), (255, 255, 255), -1)
    (seen,) = views(image, np.array([[310.0, 170.0, long, long / 2]]), Terms())
    near = max(2.0 * long, 30.0)
    for view, side in ((seen[..., 0], near), (seen[..., 3], 3 * near)):
        weight = view / view.sum(dtype=float)
        x, y = (float((weight.sum(axis=axis) * np.arange(64)).sum()) for axis in (0, 1))
        assert (x, y) == pytest.approx((31.5, 31.5), abs=0.5)
        area = np.pi * (long / 4) ** 2 / side**2
        assert view.mean() / 255 == pytest.approx(area, rel=0.35)


def test_more_room_shows_the_same_in_the_middle(picture):
    box = np.array([[299.5, 199.5, 20.0, 32.0]])
    (seen,), (larger,) = views(picture, box, Terms()), views(picture, box, Terms(), room=1.25)
    assert larger.shape == (80, 80, 6)
    np.testing.assert_array_equal(larger[8:72, 8:72], seen)


def test_small_boxes_are_enlarged_and_beyond_the_edge_the_edge_goes_on(picture):
    picture[:2, :2] = (10, 20, 30)
    (seen,) = views(picture, np.array([[0.0, 0.0, 6.0, 4.0]]), Terms())
    # 30 px round the corner: half of them beyond it.
    np.testing.assert_array_equal(seen[:32, :32, :3], np.broadcast_to([10, 20, 30], (32, 32, 3)))
    (far,) = views(picture, np.array([[599.0, 399.0, 900.0, 700.0]]), Terms())
    assert far.shape == (64, 64, 6)


def test_traits_are_log_odds_size_and_shape():
    found = traits(np.array([[0, 0, 40.0, 20.0], [0, 0, 10.0, 80.0]]), np.array([0.5, 0.8]))
    wanted = [[0.0, 0.0, np.log(2)], [np.log(4) / 3, np.log(2), -np.log(8)]]
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


class Given:
    """A detector that returns the given boxes."""

    name, class_names = "given", ("aqua", "other")

    def __init__(self, *rows):
        self.rows = rows

    def detect(self, _):
        table = np.array(self.rows, dtype=float).reshape(-1, 6)
        return Detections(
            table[:, :4], table[:, 4], table[:, 5].astype(np.int64), self.class_names, {"post": 1.0}
        )


def test_doubtful_boxes_get_its_score_and_sure_ones_keep_theirs(tmp_path):
    image = np.zeros((100, 400, 3), np.uint8)
    image[:, 100:200] = 255  # white: brightness 1
    image[:, 200:300] = 128
    second = SecondLook(brightness_look(tmp_path / "look.onnx", Terms()), 1)
    inner = Given(
        (50, 50, 20, 20, 0.9, 0),  # dark, but sure
        (350, 50, 20, 20, 0.7, 0),  # dark and doubtful
        (250, 50, 20, 20, 0.4, 1),
        (150, 50, 20, 20, 0.05, 0),
        (150, 50, 20, 20, 0.02, 0),  # too little to be looked at
    )
    found = LookingTwice(inner, second, 0.3).detect(image)
    np.testing.assert_allclose(found.scores, [1.0, 0.9, 128 / 255], atol=1e-6)
    np.testing.assert_array_equal(found.xywh[:, 0], [150, 50, 250])
    assert found.names == ("aqua", "aqua", "other")
    assert found.timings_ms["post"] > 1.0
    assert len(LookingTwice(Given(), second, 0.3).detect(image)) == 0


class Corner(SecondLook):
    """A look whose score is the brightness of the views' left upper corner, and who counts."""

    def __init__(self, path, **terms):
        super().__init__(brightness_look(path, Terms(**terms)), 1)
        self.counts = []

    def run(self, shown, _):
        self.counts = [*getattr(self, "counts", []), len(shown)]
        return shown[:, 0, 0, 0] / 255.0


def cornered(*values):
    """Return views whose four corners have these scores, clockwise from the left upper one."""
    shown = np.zeros((1, 64, 64, 6), np.uint8)
    for (y, x), value in zip(((0, 0), (0, -1), (-1, -1), (-1, 0)), values, strict=True):
        shown[0, y, x] = round(255 * value)
    return shown


def test_what_the_first_look_is_sure_of_is_not_turned(tmp_path):
    shown = np.concatenate([cornered(1.0, 0.2, 0.2, 0.2), cornered(0.6, 0.2, 0.2, 0.2)])
    second = Corner(tmp_path / "look.onnx", ways=4, again_to=0.9)
    second.counts = []
    odds = np.log([1.5, 0.25, 0.25, 0.25]).mean()
    found = second.judged(shown, np.zeros((2, 3), np.float32))
    np.testing.assert_allclose(found, [1.0, 1 / (1 + np.exp(-odds))])
    assert second.counts == [2, 3]


def test_log_odds_of_all_ways_are_averaged_where_the_first_is_high_enough(tmp_path):
    shown = np.concatenate([cornered(0.8, 0.4, 0.2, 0.4), cornered(0.04, 0.8, 0.8, 0.8)])
    inputs = np.zeros((2, 3), np.float32)
    second = Corner(tmp_path / "look.onnx", ways=8)
    second.counts = []
    odds = np.log([4.0, 2 / 3, 0.25, 2 / 3]).mean()  # each corner comes twice
    found = second.judged(shown, inputs)
    np.testing.assert_allclose(found, [1 / (1 + np.exp(-odds)), 10 / 255])
    assert second.counts == [2, 7]
    four = Corner(tmp_path / "look.onnx", ways=4, again_from=0.01)
    four.counts = []
    later = np.log([10 / 245, 4.0, 4.0, 4.0]).mean()
    np.testing.assert_allclose(
        four.judged(shown, inputs), [1 / (1 + np.exp(-odds)), 1 / (1 + np.exp(-later))]
    )
    assert four.counts == [2, 6]
    once = Corner(tmp_path / "look.onnx")
    np.testing.assert_allclose(once.judged(shown, inputs), [0.8, 10 / 255])
    assert Corner(tmp_path / "look.onnx", ways=8).judged(shown[:0], inputs[:0]).shape == (0,)


@pytest.mark.parametrize("mode", ["tiles", "roi"])
def test_with_windows_it_sees_the_whole_image(tmp_path, mode):
    terms = Terms(near=1.0, least=1.0, to_score=0.95)  # blobs have 0.9
    second = SecondLook(brightness_look(tmp_path / "look.onnx", terms), 1)
    config = detector_config({
        "score_threshold": 0.9, "search": {"mode": mode, "tile": 256, "overlap": 64},
    })  # fmt: skip
    detector = searching(BlobDetector(), config, second)
    assert "second look look.onnx" in detector.name
    square, long = (250, 170, 12, 12), (400, 40, 60, 10)  # over a tile's edge; dark for the most
    for _ in range(3):
        assert boxes(detector.detect(sea((640, 360), square, long))) == [square]


def test_it_is_found_beside_the_model(tmp_path):
    model = white_box_model(tmp_path / "m.onnx")
    eight_bits = white_box_model(tmp_path / "m_int8.onnx")
    image = np.zeros((128, 128, 3), np.uint8)
    image[40:60, 30:60] = 255
    alone = DetectorConfig(model=str(model), backend="onnxruntime")
    assert load_detector(alone).detect(image).scores == pytest.approx([0.75])
    # The white box of 30 x 20 px fills a sixth of its near view of 60 px.
    look = brightness_look(tmp_path / "m_second_look.onnx", Terms())
    assert len(load_detector(alone).detect(image)) == 0
    low = {"backend": "onnxruntime", "score_threshold": 0.1}
    for path in (model, eight_bits):
        found = load_detector(DetectorConfig(model=str(path), **low)).detect(image)
        assert found.scores == pytest.approx([600 / 3600], abs=0.01)
    off = DetectorConfig(model=str(model), backend="onnxruntime", second_look="off")
    assert load_detector(off).detect(image).scores == pytest.approx([0.75])
    elsewhere = look.rename(tmp_path / "another.onnx")
    assert load_detector(alone).detect(image).scores == pytest.approx([0.75])
    given = DetectorConfig(model=str(model), second_look=str(elsewhere), **low)
    assert "second look another.onnx" in load_detector(given).name


def test_what_is_no_second_look_is_refused(tmp_path):
    model = white_box_model(tmp_path / "m.onnx")
    for name, words in (
        (str(model), "not a network for the second look"),
        ("/no/look.onnx", "the second look /no/look.onnx does not exist"),
        ("none.onnx", "the second look none.onnx does not exist"),
    ):
        with pytest.raises(ModelError, match=words):
            load_detector(DetectorConfig(model=str(model), second_look=name))
