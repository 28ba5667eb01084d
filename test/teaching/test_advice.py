# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters that labels and scores support: lengths of robots, least mean scores, as YAML."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from aerial_gnss_ros.commands.configuration import values_of
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.georeferencing.apparent_size import SizeCheck
from aerial_gnss_ros.nodes.schemas import ESTIMATOR
from aerial_gnss_ros.teaching.advice import least_score, lengths, parameters
from aerial_gnss_ros.teaching.geometry import View
from aerial_gnss_ros.teaching.tracks import Sight, started

SIZE = (640, 480)
DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])


def _session(count, long_px, height=10.0, sight=Sight.SURE, x=320.0):
    """Two robots under a camera that looks straight down: 500 px of focal length."""
    K = np.array([[500.0, 0.0, 319.5], [0.0, 500.0, 239.5], [0.0, 0.0, 1.0]])
    camera = CameraModel(*SIZE, "plumb_bob", K, np.zeros(5), False, np.eye(3))
    views = [View(camera, np.array([0.0, 0.0, height]), DOWN)] * count
    tracks = {
        robot: {
            frame: replace(
                started(frame, np.array([x, 240.0, long, 9.0]), np.zeros(1), np.eye(2)), sight=sight
            )
            for frame in range(count)
        }
        for robot, long in long_px.items()
    }
    recording = SimpleNamespace(views=views, size=SIZE)
    classes = {robot: robot.split("_")[0] for robot in long_px}
    return SimpleNamespace(
        recording=recording, tracks=tracks, project=SimpleNamespace(classes=classes)
    )


def test_the_length_of_a_class_is_that_of_its_robots_with_room_for_others():
    """50 and 75 px of 500 px focal length at 10 m are 1.0 and 1.5 m; the fish has too few boxes."""
    found = lengths(_session(12, {"sub_1": 50.0, "sub_2": 75.0}))
    assert found == {"sub": pytest.approx((1.0 / 1.25, 1.5 * 1.25), abs=0.01)}
    assert lengths(_session(9, {"fish_1": 50.0})) == {}
    assert lengths(_session(12, {"sub_1": 50.0}, sight=Sight.UNSURE)) == {}
    assert lengths(_session(12, {"sub_1": 50.0}, x=24.0)) == {}  # cut by the edge
    blind = _session(12, {"sub_1": 50.0})
    blind.recording.views = [None] * 12
    assert lengths(blind) == {}


def test_nearly_all_boxes_on_robots_exceed_the_least_score():
    scores = np.concatenate([np.full(10, 0.805), np.full(90, 0.95)])
    assert least_score(np.append(scores, 0.805), 0.5) == pytest.approx(0.80)
    assert least_score(scores, 0.85) == pytest.approx(0.93, abs=0.02)
    assert least_score(np.full(100, 0.6), 0.7) == 0.0  # not above the threshold: nothing gained
    assert least_score(np.full(19, 0.9), 0.5) == 0.0  # too few


def test_what_is_known_is_advised_and_scores_are_left_to_the_reader():
    whole = parameters(Path("mine.onnx"), 0.6, 0.8, {"sub": (0.8, 1.9)})
    lengths_only = {"classes": {"sub": {"length_m": [0.8, 1.9]}}}
    assert yaml.safe_load(whole)["/**/estimator"]["ros__parameters"] == lengths_only
    for known, estimator in (({}, {}), ({"sub": (0.8, 1.9)}, lengths_only)):
        text = parameters(Path("mine.onnx"), 0.6, 0.8, known)
        lines = [line for line in text.splitlines() if "# Where" not in line]
        taken = yaml.safe_load("\n".join(line.removeprefix("# ") for line in lines))
        values = taken["/**/estimator"]["ros__parameters"]
        assert values == {**estimator, "tracks": {"confirm_score": 0.8}}
        assert estimator_config(values).tracks.confirm_score == 0.8
    assert list(yaml.safe_load(parameters(Path("mine.onnx"), 0.6, 0.0, {}))) == ["/**/detector"]


@pytest.mark.parametrize("name", ["fin", "no", "1", "null", "a b", "x: y", "#a", '"', "ü"])
def test_lengths_reach_the_size_check_whatever_the_class_is_called(tmp_path, name):
    file = tmp_path / "detector.yaml"
    file.write_text(parameters(Path("mine.onnx"), 0.6, 0.0, {name: (0.8, 1.9)}), encoding="utf-8")
    config = estimator_config(values_of([file])[ESTIMATOR])
    assert config.robot_class(name).length_m == (0.8, 1.9)
    assert SizeCheck(config).used
