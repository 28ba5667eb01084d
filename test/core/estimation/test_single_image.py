# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Methods that use each image by itself: a measured robot is where its own box is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.single_image import at_own_points, exact_points
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing import paper
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.tracker.protocol import TrackUpdate
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State
from aerial_gnss_ros.core.values.rejection import Reason

pytestmark = pytest.mark.flights

CONFIG = EstimatorConfig()


def test_single_publishes_each_point_by_itself(sea):
    world = {"robots": {"a": lambda _t: (3.0, 22.0)}, "pixel_sigma": 2.0, "seed": 5}
    spread, sigma = {}, {}
    for method in ("filter", "single", "paper"):
        results = sea.play(sea.estimator({"method": method}), sea.World(**world), 20.0)
        found = [r.estimates[0] for r in results[50:] if r.estimates[0].state is State.CONFIRMED]
        spread[method] = np.std([e.position for e in found], axis=0).max()
        sigma[method] = np.sqrt(found[-1].covariance[0, 0])
        assert all(np.linalg.eigvalsh(e.covariance).min() > 0.0 for e in found)
        assert {e.robot_id for e in found} == {"aqua_1"}
    assert spread["filter"] < 0.7 * spread["single"]
    assert spread["paper"] == pytest.approx(spread["single"], rel=0.1)
    # A hover tells nothing of compass and tilt, which the filter takes for larger than stated.
    assert 1.2 < sigma["filter"] < math.sqrt(5.0 / 3.0) * sigma["single"]


def _located(sea, centers):
    """Return an image's boxes under a level camera, and where the exact method puts them."""
    world = sea.World()
    pose = world.pose(0.0)
    in_map = MapPose.of(pose, world.local)
    frame = PosedFrame(sea.boxes(0.0, centers), sea.camera, pose, in_map)
    return frame, locate(frame.pose, frame.camera, frame.detections.centers, CONFIG.noise, CONFIG)


def test_a_robot_that_is_measured_is_at_its_own_box_and_another_where_it_was(sea):
    _, points = _located(sea, [[100.0, 400.0], sea.middle])
    robots = [
        RobotEstimate(
            7, name, "aqua", State.CONFIRMED, 0.1, -1.0, 2.0, np.array([5.0, 6.0]),
            np.array([0.3, 0.4]), np.full((4, 4), 0.1) + np.eye(4), 7,
        )
        for name in ("aqua_1", "aqua_2")
    ]  # fmt: skip
    none = np.zeros(2, bool)
    local = sea.World().local
    seen, coasting = at_own_points(
        TrackUpdate(tuple(robots), {"aqua_1": 1}, none, none), points, local
    )
    assert coasting is robots[1]
    # 30 m up, 60 deg below the horizon: 30 / tan 60 deg = 17.3205 m ahead (north).
    assert seen.position == pytest.approx([0.0, 17.3205], abs=1e-3)
    assert (seen.latitude, seen.longitude) == (points.latitude[1], points.longitude[1])
    assert seen.covariance[:2, :2] == pytest.approx(points.covariance[1])
    assert not seen.covariance[:2, 2:].any()
    assert not seen.covariance[2:, :2].any()
    assert seen.covariance[2:, 2:] == pytest.approx(robots[0].covariance[2:, 2:])
    assert seen.velocity.tolist() == [0.3, 0.4]
    assert robots[0].covariance[0, 2] == 0.1  # the filter's own is left as it is


def test_names_are_kept_by_exact_points_of_what_the_paper_does_not_refuse(sea):
    frame, exact = _located(sea, [[100.0, 400.0], sea.middle, [5000.0, 0.0]])
    assert [one is None for one in exact.reasons] == [True, True, False]
    published = paper.locate(
        frame.pose, frame.camera, frame.detections.centers, CONFIG.noise, CONFIG
    )
    published = replace(published, reasons=(Reason.OUT_OF_RANGE, None, None))
    found = exact_points(frame, published, CONFIG)
    assert found.reasons == (Reason.OUT_OF_RANGE, None, exact.reasons[2])
    assert found.east_north[:2].tolist() == exact.east_north[:2].tolist()


def test_parts_of_the_covariance_are_given_where_asked_for_and_change_nothing_else(sea):
    world = {"robots": {"a": lambda _t: (3.0, 22.0)}, "pixel_sigma": 2.0, "seed": 5}
    for method in ("filter", "single"):
        asked = {"method": method, "updates.covariance_parts": True}
        plain, parted = (
            [r.estimates[0] for r in sea.play(sea.estimator(given), sea.World(**world), 8.0)[20:]]
            for given in ({"method": method}, asked)
        )
        assert all(one.white is None for one in plain)
        assert [one.position.tolist() for one in plain] == [one.position.tolist() for one in parted]
        for one in parted:
            whole, white = one.covariance[:2, :2], one.white
            assert np.linalg.eigvalsh(white).min() > 0.0
            assert np.linalg.eigvalsh(whole - white).min() > 0.0
            assert np.trace(white) < 0.05 * np.trace(whole)  # a consumer receiver's offset lasts
