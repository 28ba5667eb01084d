# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss demo`: what is compared is comparable; CI flies the whole demo."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.commands.demo import LIVE, METHODS, agreement, demo_experiment, keep_boxes
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.evaluation.errors import RobotErrors
from aerial_gnss_ros.simulation.bag import DETECTIONS_TYPE, write_bag


def test_live_and_replayed_positions_are_compared_in_words():
    def errors(*north):
        stamps, none = np.arange(len(north)), np.zeros(len(north))
        return [RobotErrors("aqua_1", "aqua_1", stamps, np.c_[none, north], none, none, 1.0)]

    sentence = agreement({LIVE: errors(0.0, 1.0, 2.0), METHODS["filter"]: errors(0.0, 0.98, 2.1)})
    assert "differ by 0.020 m (median; 95 %: 0.092 m)" in sentence
    assert "No image has both" in agreement({LIVE: errors(), METHODS["filter"]: errors(1.0)})


def test_a_replay_uses_the_live_boxes_of_the_first_image(tmp_path):
    """They arrive after the camera's first CameraInfo, as live."""
    live = pytest.importorskip(
        "aerial_gnss_ros.nodes.live", reason="ROS 2 is not installed", exc_type=ImportError
    )
    write_bag(tmp_path / "flight", demo_experiment(1.0, 15.0, 2, 1), None)
    with open_bag(tmp_path / "flight") as bag:
        sent = [(one.message(), one.raw) for one in bag.messages({"/detections"})]
    stamps_ns = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m, _ in sent]
    heard = live.Heard(detections=list(zip(stamps_ns, (raw for _, raw in sent), strict=True)))
    keep_boxes(tmp_path, heard)
    with open_bag(tmp_path / "detections") as bag:
        assert {*bag.topics} == {"/detections"}
        assert bag.topics["/detections"].msgtype == DETECTIONS_TYPE
        delays_s = [
            (one.log_ns - stamp_ns) * 1e-9
            for one, stamp_ns in zip(bag.messages(), stamps_ns, strict=True)
        ]
    assert {round(delay, 6) for delay in delays_s} == {0.08}
    with open_bag([tmp_path / "flight", tmp_path / "detections"]) as bag:
        replay = Replay(bag, estimator_config({}), DetectorConfig(), load_detector)
        results = list(replay.results())
    assert len(results) == 10
    assert not any(one.reason for result in results for one in result.rejections)
