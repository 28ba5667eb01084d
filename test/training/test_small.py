# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The small detector: its samples, a training that learns and goes on, and its exported file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import onnxruntime
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError, InputError, ModelError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.small import RESULT, STATE, SmallPlan, fit, main
from aerial_gnss_ros.training.small_samples import Crop, Pool, random_crop

SHIPPED = Path(__file__).parents[2] / "models/aqua_small.onnx"
needs_torch = pytest.mark.ultralytics
SIDE = 64


def picture(rng, count=1, size=(160, 128)):
    """Return an image of dark noise with bright robots, and their corners (edges of pixels)."""
    image = rng.integers(20, 70, (size[1], size[0], 3), np.uint8)
    corners = []
    for number in range(count):
        x, y = rng.integers(8, 30, 2) + 20 * number * np.array([3, 1])
        w, h = rng.integers(18, 34, 2)
        image[y : y + h, x : x + w] = (60, 200, 240)
        corners.append((x, y, x + w, y + h))
    return image, np.array(corners, dtype=np.float64)


@pytest.fixture
def pool():
    rng, made = np.random.default_rng(5), Pool()
    for number in range(24):
        image, corners = picture(rng, 1 + number % 2)
        count = len(corners)
        truth = Truth(
            corners - 0.5, np.ones(count, bool), np.ones(count), np.ones(count),
            np.zeros(count, np.int64),
        )  # fmt: skip
        made.add([LabelledImage(str(number), truth, lambda image=image: image)])
    return made


def crop_of(rng, image, corners, kinds):
    return random_crop(rng, (image.shape[1], image.shape[0]), corners, kinds, SIDE)


@needs_torch
def test_boxes_stay_on_robots_in_varied_crops(torch):
    from aerial_gnss_ros.training.small_batch import cut_out

    rng, seen = np.random.default_rng(1), 0
    for _ in range(60):
        image, corners = picture(rng)
        crop = crop_of(rng, image, corners, np.zeros(1, np.int64))
        levels = cut_out(torch.from_numpy(image), crop, SIDE).numpy()
        bright = (levels[0] > 0.6).astype(np.uint8)  # red
        if not len(crop.corners):
            assert bright.sum() == 0 or len(crop.partly)
            continue
        left, top, width, height = cv2.boundingRect(bright)
        wanted = (left, top, left + width, top + height)
        np.testing.assert_allclose(crop.corners[0], wanted, atol=1.6)
        assert crop.classes.tolist() == [0]
        seen += 1
    assert seen > 30


def test_a_robot_that_does_not_count_or_is_too_small_is_neither_a_robot_nor_none():
    rng = np.random.default_rng(2)
    image, corners = picture(rng)
    tiny = np.array([[40.0, 40.0, 44.0, 44.0]])
    for _ in range(30):
        for boxes, kind in ((corners, -1), (tiny, 0)):
            crop = crop_of(rng, image, boxes, np.array([kind]))
            assert not len(crop.corners)
            assert len(crop.partly) <= 1


@needs_torch
@pytest.mark.usefixtures("torch")
def test_the_map_is_1_at_the_centre_and_says_which_box_a_place_belongs_to():
    from aerial_gnss_ros.training.small_batch import Sampler, maps_of

    boxes = np.array([[8.0, 16.0, 24.0, 24.0], [40.0, 32.0, 60.0, 60.0]])
    partly = np.array([[0.0, 48.0, 20.0, 64.0]])
    crops = [
        Crop(0, 0, SIDE, 0, False, boxes, np.array([0, 1]), partly),
        Crop(0, 0, SIDE, 0, False, np.zeros((0, 4)), np.zeros(0, int), np.zeros((0, 4))),
    ]
    wanted, weight, truth = (one.numpy() for one in maps_of(crops, SIDE, 2, "cpu"))
    assert wanted.shape == (2, 2, 8, 8)
    assert np.argwhere(wanted[0, 0] == 1.0).tolist() == [[2, 2]]
    assert np.argwhere(wanted[0, 1] == 1.0).tolist() == [[5, 6]]
    assert truth[0, :, 2, 2].tolist() == [16.0, 20.0, 16.0, 8.0]
    assert truth[0, :, 5, 6].tolist() == [50.0, 46.0, 20.0, 28.0]
    assert np.argwhere(weight[0, 0] == 0.0).tolist() == [[r, c] for r in (6, 7) for c in (0, 1, 2)]
    assert wanted[1].max() == 0.0
    assert weight[1].min() == 1.0
    pool = Pool([np.zeros((SIDE, SIDE, 3), np.uint8)], [boxes], [np.array([0, 1])], [1.0])
    batch = Sampler(pool, SIDE, 2, "cpu").draw(np.random.default_rng(0), 3)
    assert batch.images.shape == (3, 3, SIDE, SIDE)
    assert batch.truth.shape == (3, 4, 8, 8)


def test_images_are_drawn_by_weight_and_size():
    pool, rng = Pool(), np.random.default_rng(3)
    for side, weight in ((32, 2.0), (64, 1.0)):
        one = Pool()
        image = np.zeros((side, side, 3), np.uint8)
        none = Truth(np.zeros((0, 4)), np.zeros(0, bool), *(np.zeros(0),) * 2, np.zeros(0, int))
        one.add([LabelledImage("one", none, lambda image=image: image)], weight)
        pool.extend(one)
    assert np.mean(pool.drawn(rng, 6000)) == pytest.approx(4096 / (4096 + 2048), abs=0.03)


@pytest.fixture
def torch():
    return pytest.importorskip("torch", reason="needs torch, of the extra [ultralytics]")


@needs_torch
def test_it_learns_goes_on_and_is_read_as_any_other_detector(tmp_path, pool, torch):
    plan = SmallPlan(steps=30, side=SIDE, batch=8, learning_rate=0.001, seed=3, threads=1)
    told, others = [], {"start": SHIPPED, "report": lambda *seen: told.append(seen)}
    fit(pool, plan, tmp_path, ("aqua",), **others)
    file = fit(pool, replace(plan, steps=60), tmp_path, ("aqua",), **others)
    assert [step for step, _, _ in told] == [50]  # the second went on from 30
    assert torch.load(tmp_path / STATE, weights_only=True)["step"] == 60
    detector = load_detector(
        DetectorConfig(model=str(file), backend="onnxruntime", threads=1, score_threshold=0.2)
    )
    assert detector.class_names == ("aqua",)
    rng = np.random.default_rng(9)
    image, corners = picture(rng, 2, (192, 160))
    found = detector.detect(image)
    for left, top, right, bottom in corners - 0.5:
        middle = (left + right) / 2, (top + bottom) / 2
        best = np.hypot(*(found.xywh[:, :2] - middle).T).argmin()
        np.testing.assert_allclose(found.xywh[best, :2], middle, atol=3.0)
        np.testing.assert_allclose(found.xywh[best, 2:], (right - left, bottom - top), rtol=0.35)


@needs_torch
def test_a_file_is_read_back_and_begins_another_training(tmp_path, torch):
    from aerial_gnss_ros.training.small import started
    from aerial_gnss_ros.training.small_network import SmallDetector, boxes, write

    torch.manual_seed(1)
    network, image = SmallDetector().eval(), torch.rand((1, 3, 64, 96))
    write(network, ("aqua",), tmp_path / RESULT, shift=1.0)
    with torch.no_grad():
        again = started(tmp_path / RESULT, 1).eval()
        torch.testing.assert_close(again(image), network(image))
        wanted = torch.cat([*boxes(network(image)), (network(image)[:, 4:] + 1.0).sigmoid()], 1)
    session = onnxruntime.InferenceSession(str(tmp_path / RESULT))
    (found,) = session.run(None, {"images": image.numpy()})
    np.testing.assert_allclose(found, wanted.flatten(2).numpy(), atol=1e-4)
    other = started(tmp_path / RESULT, 2)  # of two classes: all is kept but the last layer
    torch.testing.assert_close(other.backbone.stem.weight, network.backbone.stem.weight)
    assert other.last.weight.shape[0] == 6
    for name in ("x.onnx", "x.json", "x.pt"):
        (tmp_path / name).write_text("nothing")
        with pytest.raises((ModelError, InputError)):
            started(tmp_path / name, 1)


@needs_torch
def test_weights_of_coco_see_the_same_in_red_green_blue_from_0_to_1(monkeypatch, torch):
    from aerial_gnss_ros.training import small_network
    from aerial_gnss_ros.training.backbone import DEVIATION, MEAN, Backbone

    torch.manual_seed(2)
    known = Backbone()
    monkeypatch.setattr(
        small_network, "load_coco", lambda one, _path: one.load_state_dict(known.state_dict())
    )
    network = small_network.from_coco(None)
    image = torch.rand((1, 3, 64, 64))
    scaled = (255.0 * image.flip(1) - torch.tensor(MEAN).reshape(1, 3, 1, 1)) / torch.tensor(
        DEVIATION
    ).reshape(1, 3, 1, 1)
    inner = (slice(None), slice(None), slice(1, None), slice(1, None))  # the border is black
    torch.testing.assert_close(
        network.backbone.stem(image)[inner], known.stem(scaled)[inner], atol=1e-4, rtol=1e-4
    )


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({}, "--time or --steps"), ({"hours": 1.0, "steps": 5}, "--time or --steps"),
        ({"steps": 5, "side": 100}, "multiple of 32"), ({"steps": 5, "batch": 0}, "--batch"),
    ],
)  # fmt: skip
def test_a_wrong_plan_is_refused(wrong, words):
    with pytest.raises(ConfigError, match=words):
        SmallPlan(**wrong)


def test_wrong_arguments_end_with_a_sentence(tmp_path, capsys):
    folder = str(tmp_path / "none")
    assert main([folder, "-o", str(tmp_path / "run")]) == 2
    assert "--time or --steps" in capsys.readouterr().err
