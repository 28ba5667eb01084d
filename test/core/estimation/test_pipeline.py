# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What one image gives, over robots that only note what they are asked."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.georeferencing import localization, paper
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason

CENTERS = [[640.0, 360.0], [600.0, 400.0], [700.0, 300.0], [5000.0, 0.0]]


class Robots:
    """Stands in for the tracker: of the boxes it is given the first is gated, the second fast."""

    def __init__(self):
        self.asked = []

    def update(self, frame, points, local):
        """Take in an image."""
        self.asked.append(("update", frame, points, local))
        row = np.arange(len(frame.detections))
        return TrackUpdate((), {}, row == 0, row == 1)

    def coast(self, stamp_ns, boxes=None):
        """Predict."""
        self.asked.append(("coast", stamp_ns, boxes))
        return ()

    def settled(self):
        """Return what was decided."""
        return Settled(3, ())

    def misfit(self, *_):
        """Return how badly boxes fit."""
        return 0.0


class Line:
    """A pipeline with what it acts on."""

    def __init__(self, sea, values=None):
        self.config = estimator_config(
            {**sea.origin, "fix.altitude_datum": "ellipsoid", **(values or {})}
        )
        inputs, self.robots, self.log = TelemetryBuffers(self.config), Robots(), Events()
        self.origin = MapOrigin(self.config, None, self.log)
        inputs.cameras.add(0, sea.camera)
        self.pipeline = Pipeline(self.config, inputs, self.robots, self.origin, self.log)
        self.log.drain()

    def result(self, sea, telemetry=None, t=1.0, centers=CENTERS):
        """Return what an image gives; without telemetry that of a hover."""
        world = sea.World()
        telemetry = telemetry or SceneTelemetry(
            sea.stamp(t), world.fix(t), None, world.gimbal(t), 30.0, 0.0, 0.05
        )
        return self.pipeline.result(sea.boxes(t, centers), telemetry)


def test_each_box_has_the_first_reason_that_it_was_not_used_for(sea):
    line = Line(sea)
    boxes = sea.boxes(1.0, CENTERS)
    boxes.scores[2] = 0.01
    world = sea.World()
    scene = SceneTelemetry(sea.stamp(1.0), world.fix(1.0), None, world.gimbal(1.0), 30.0, 0.0, 0.05)
    result = line.pipeline.result(boxes, scene)
    ((_, frame, points, local),) = line.robots.asked
    assert frame.detections.centers.tolist() == [CENTERS[i] for i in (0, 1, 3)]
    assert local is line.origin.local
    assert points.east_north[0] == pytest.approx([0.0, 17.3205], abs=1e-3)
    reported = {round(one.u_px): one.reason for one in result.rejections}
    assert reported == {
        640: Reason.GATED, 600: Reason.TOO_FAST, 700: Reason.LOW_SCORE,
        5000: Reason.OUTSIDE_CALIBRATED_IMAGE,
    }  # fmt: skip
    assert (result.boxes, result.used) == (4, 3)
    assert result.pose.height == pytest.approx(30.0)
    assert set(result.timings_ms) == {"pose", "locate", "track"}
    assert all(0.0 <= one < 60_000.0 for one in result.timings_ms.values())


def test_without_telemetry_robots_coast_with_the_boxes_in_view(sea):
    line = Line(sea)
    result = line.result(sea, MissingTelemetry(Reason.STALE_GIMBAL, can_arrive=True))
    ((what, stamp_ns, boxes),) = line.robots.asked
    assert (what, stamp_ns, len(boxes)) == ("coast", sea.stamp(1.0), 4)
    assert {one.reason for one in result.rejections} == {Reason.STALE_GIMBAL}
    assert result.pose is None
    assert line.log.drain() == []


def test_boxes_of_a_picture_that_stands_still_are_no_evidence_of_robots(sea):
    line = Line(sea)
    line.pipeline._frozen.image_frozen = lambda *_: True
    result = line.result(sea)
    assert {one.reason for one in result.rejections} == {Reason.BAD_DETECTIONS}
    assert line.robots.asked == [("coast", sea.stamp(1.0), None)]
    assert result.pose is None
    (words,) = line.log.drain()
    assert "(bad_detections)" in words


def test_telemetry_that_stands_still_is_refused_and_its_boxes_keep_names(sea):
    line = Line(sea)
    line.pipeline._frozen.telemetry_frozen = lambda *_: True
    assert {one.reason for one in line.result(sea).rejections} == {Reason.STALE_FIX}
    assert [len(boxes) for _, _, boxes in line.robots.asked] == [4]


@pytest.mark.parametrize(
    ("datum", "words"),
    [("unknown", "fix.altitude_datum is unknown"), ("home", "fix.altitude_datum is home")],
)
def test_altitudes_that_are_not_known_are_explained_once(sea, datum, words):
    line = Line(sea, {"fix.altitude_datum": datum})
    for t in (1.0, 1.1):
        assert math.isnan(line.result(sea, t=t).pose.altitude)
    (reported,) = line.log.drain()
    assert words in reported


def test_a_climb_beyond_the_limits_is_reported_once_and_counted(sea):
    line, world = Line(sea), sea.World()
    for t in range(10):
        height = 10_001.0 + t
        scene = SceneTelemetry(sea.stamp(t), world.fix(t), None, world.gimbal(t), height, 0.0, 0.05)
        refused = {one.reason for one in line.result(sea, scene, t).rejections}
        assert refused == {Reason.BAD_HEIGHT}
    (words,) = line.log.drain()
    assert words.startswith("A camera 10001.0 m above the water")
    assert line.log.counts == {"images_bad_height": 10}


def test_a_place_that_map_does_not_cover_is_a_bad_fix(sea):
    line = Line(sea, {"map.latitude_deg": 14.9})
    assert {one.reason for one in line.result(sea).rejections} == {Reason.BAD_FIX}


@pytest.mark.parametrize("method", ["filter", "single", "paper"])
def test_a_robot_is_published_by_the_method_that_is_configured(sea, monkeypatch, method):
    """Names are kept by exact points; where each image stands by itself a robot is at its box."""
    line, robot = Line(sea, {"method": method}), np.array([5.0, 6.0])
    one = RobotEstimate(
        7, "aqua_1", "aqua", State.CONFIRMED, 0.2, -1.0, 0.0, robot, np.zeros(2), np.eye(4), 7
    )
    none = np.zeros(1, bool)
    monkeypatch.setattr(
        line.robots, "update", lambda _, points, __: (
            line.robots.asked.append(points) or TrackUpdate((one,), {"aqua_1": 0}, none, none)
        )
    )  # fmt: skip
    # Off the axis the paper's equations and the exact ones differ.
    result = line.result(sea, centers=[[200.0, 600.0]])
    world = sea.World()
    pixels = np.array([[200.0, 600.0]])
    exact, published = (
        locate(world.pose(1.0), sea.camera, pixels, line.config.noise, line.config)
        for locate in (localization.locate, paper.locate)
    )
    assert exact.latitude[0] != published.latitude[0]
    assert line.robots.asked[0].latitude[0] == pytest.approx(exact.latitude[0], abs=1e-12)
    expected = {"filter": 0.2, "single": exact.latitude[0], "paper": published.latitude[0]}
    assert result.estimates[0].latitude == pytest.approx(expected[method], abs=1e-12)


def test_errors_that_are_stated_to_be_zero_are_named(sea):
    engine = sea.estimator({"noise.heading_deg": 0.0, "noise.height_m": 0.0})
    (sentence,) = [one for one in engine.events if "Stated to be 0" in one]
    assert "noise.heading_deg, noise.height_m." in sentence
    assert not [one for one in sea.estimator().events if "Stated to be 0" in one]
