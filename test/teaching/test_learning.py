# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From labels to a detector: what it then finds, what is done once, what is too little."""

from __future__ import annotations

import importlib.util
from contextlib import contextmanager

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.bags.pictures import open_pictures
from aerial_gnss_ros.core.values.errors import InputError, ModelError
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.teaching import learning
from aerial_gnss_ros.teaching.clicks import Click
from aerial_gnss_ros.teaching.dataset import write_dataset
from aerial_gnss_ros.teaching.learning import NETWORK, Plan, learn
from aerial_gnss_ros.teaching.recording import extract
from aerial_gnss_ros.teaching.session import Session

ROBOT, BUOY = (40, 210, 230), (40, 40, 220)


@contextmanager
def _quiet(_what, _total, _unit=""):
    yield lambda _done: None


def _film(folder, count):
    """Noisy water with a yellow robot and a red buoy that drift."""
    folder.mkdir()
    rng = np.random.default_rng(2)
    for i in range(count):
        noise = cv2.GaussianBlur(rng.normal(0.0, 12.0, (240, 320)), (0, 0), 1.5)[..., None]
        image = np.clip(np.array([110.0, 120.0, 70.0]) + noise, 0, 255).astype(np.uint8)
        for left, top, colour in ((60 + 3 * i, 100, ROBOT), (240 - 2 * i, 180, BUOY)):
            cv2.rectangle(image, (left, top), (left + 29, top + 17), colour, -1)
        cv2.imwrite(str(folder / f"{i:02d}.png"), image)
    return folder


@pytest.fixture(name="work")
def _work(tmp_path):
    """Return a maker of a project with labels of a film of so many images."""

    def make(count):
        film, folder = _film(tmp_path / "film", count), tmp_path / "mine"
        folder.mkdir()
        extract(open_pictures(film), folder, 100, lambda s: [None] * len(s), lambda _done: None)
        session = Session(folder)
        session.add([Click("fin_1", "fin", 0, point=np.array([75.0, 109.0]))])
        write_dataset(session, folder)
        return folder

    return make


@pytest.mark.ultralytics
def test_it_finds_the_robot_and_not_the_buoy(work, monkeypatch):
    pytest.importorskip("torch", reason="needs the extra [training]")
    from aerial_gnss_ros.training import second_look_network_taught as taught

    monkeypatch.setattr(taught, "STEPS", 100)  # two colours are told apart soon
    monkeypatch.setattr(learning, "_VARIANTS", 20)
    folder = work(20)
    learnt = learn(folder, Plan(threads=1), _quiet)
    assert learnt.classes == ("fin",)
    assert (learnt.images, learnt.robots) == (4, 4)
    assert (learnt.precision, learnt.recall) == (1.0, 1.0)
    assert not list(folder.glob(".training*"))
    config = detector_config({
        "model": "anomaly", "second_look": str(folder / NETWORK),
        "score_threshold": learnt.threshold,
    })  # fmt: skip
    found = load_detector(config).detect(read_image(folder / "frames" / "000000.jpg"))
    assert found.names == ("fin",)
    np.testing.assert_allclose(found.xywh[0], [74.5, 108.5, 30, 18], atol=3.0)
    monkeypatch.setattr(learning, "_examples", lambda *_args: pytest.fail("trained again"))
    assert learn(folder, Plan(threads=1), _quiet) == learnt
    with pytest.raises(pytest.fail.Exception):
        learn(folder, Plan(seed=1, threads=1), _quiet)
    label = next((folder / "dataset/labels/train").iterdir())
    label.write_text("")
    with pytest.raises(pytest.fail.Exception):
        learn(folder, Plan(threads=1), _quiet)


@pytest.fixture(name="with_torch")
def _with_torch(monkeypatch):
    """As if torch and onnx were installed, up to where they are needed."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: object())


@pytest.mark.usefixtures("with_torch")
def test_too_few_labels_are_said_before_anything_is_computed(work, monkeypatch):
    monkeypatch.setattr(learning, "_examples", lambda *_args: pytest.fail("computed"))
    folder = work(14)  # 11 to train on, 2 of them to decide when to stop
    with pytest.raises(InputError, match=r"fin has 9 boxes in the part .* until there are 10"):
        learn(folder, Plan(), _quiet)


@pytest.mark.usefixtures("with_torch")
def test_robots_that_do_not_stand_out_are_said(tmp_path, monkeypatch):
    """Labels on plain water: what is no proposal cannot be learnt."""
    rng = np.random.default_rng(1)
    for kind in ("images", "labels"):
        (tmp_path / "dataset" / kind / "train").mkdir(parents=True)
    for i in range(20):
        image = rng.normal(90.0, 3.0, (240, 320, 3)).astype(np.uint8)
        cv2.imwrite(str(tmp_path / f"dataset/images/train/{i:02d}.png"), image)
        (tmp_path / f"dataset/labels/train/{i:02d}.txt").write_text("0 0.5 0.5 0.1 0.1\n")
    (tmp_path / "dataset/data.yaml").write_text("train: images/train\nnames: {0: fin}\n")
    monkeypatch.setattr(learning, "_train", lambda *_args: pytest.fail("trained"))
    with pytest.raises(InputError, match=r"only 0 boxes of fin found: its colours are too much"):
        learn(tmp_path, Plan(), _quiet)


@pytest.mark.usefixtures("with_torch")
def test_a_folder_without_water_is_refused(work, tmp_path):
    (tmp_path / "dry").mkdir()
    with pytest.raises(InputError, match="dry has no images"):
        learn(work(20), Plan(water=tmp_path / "dry"), _quiet)


def test_without_torch_it_says_what_to_install(work, monkeypatch):
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "torch" else object()
    )
    with pytest.raises(ModelError, match=r"needs torch; install it with .*\[training\]"):
        learn(work(6), Plan(), _quiet)
