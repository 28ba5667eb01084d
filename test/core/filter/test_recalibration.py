# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Another calibration in flight: robots keep their names and are where they would have been."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.linearization import CameraView, by_platform, relinearize
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange, likelier, recalibrate
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.measurement_model import state_jacobian
from aerial_gnss_ros.core.models.platform_model import COUNT, HEADING, PLATFORM, PlatformModel

CHANGED_S, END_S = 15.0, 18.0
ROBOTS = {"a": (2.0, 16.0), "b": (-5.0, 19.0), "c": (5.0, 12.0)}


def _world(sea, late_s=0.0, **errors):
    class Late(sea.World):
        def frame(self, t, class_id="aqua"):
            return replace(super().frame(t - late_s, class_id), stamp_ns=sea.stamp(t))

    return Late(
        drone=lambda t: (6 * math.sin(0.5 * t), 5 * math.sin(0.3 * t), 30 + 2 * math.sin(0.1 * t)),
        rpy_deg=lambda t: (0.0, 60.0, 90.0 + 15.0 * math.sin(0.2 * t)),
        robots={name: lambda _t, place=place: place for name, place in ROBOTS.items()},
        pixel_sigma=1.0,
        seed=3,
        **errors,
    )


def _flown(sea, world, before, after, more=(), camera=None, images=5):
    """Return the last robots, where the calibration of the middle of the flight is another one."""
    given, camera = {"noise.gnss_offset_m": 0.02, **dict(more)}, camera or sea.camera
    engine = sea.estimator({**given, **before})
    play = partial(sea.play, engine, world, images=images, camera=camera)
    first = play(CHANGED_S, until_flush=False)
    engine.reconfigure(estimator_config({**sea.origin, **given, **after}))
    last = play(END_S - CHANGED_S, begin=CHANGED_S)
    names = [{one.robot_id for one in result.estimates} for result in (first[-1], last[-1])]
    assert names[0] == names[1] == {"aqua_1", "aqua_2", "aqua_3"}
    assert len({one.robot_id for result in last for one in result.estimates}) == 3
    return {one.robot_id: one for one in last[-1].estimates}


def _errors(robots):
    """Return how far each robot is from the nearest true one, m; no two from the same."""
    found = [
        min((math.dist(one.position[:2], place), name) for name, place in ROBOTS.items())
        for one in robots.values()
    ]
    assert len({name for _, name in found}) == 3
    return [away for away, _ in found]


@pytest.mark.flights
@pytest.mark.parametrize(
    ("values", "errors"),
    [
        ({"calibration.heading_deg": 6.0}, {"rpy_bias_deg": (0.0, 0.0, -6.0)}),
        ({"calibration.gimbal_pitch_deg": -2.0}, {"rpy_bias_deg": (0.0, 2.0, 0.0)}),
        ({"calibration.height_m": 2.0}, {}),
    ],
    ids=lambda one: next(iter(one), ""),
)
def test_robots_are_where_they_would_be_with_the_calibration_from_the_start(sea, values, errors):
    flown = [
        _flown(sea, _world(sea, **errors), before, after, {"noise.gnss_offset_m": 1.2})
        for before, after in ((values, values), ({}, values), ({}, {}))
    ]
    for name, one in flown[0].items():
        away = [math.dist(one.position[:2], other[name].position[:2]) for other in flown[1:]]
        assert away[0] < 0.1
        assert away[1] > 0.15  # what the calibration changes
        spread = [math.sqrt(other[name].covariance[0, 0]) for other in flown]
        assert spread[1] == pytest.approx(spread[0], rel=0.1)


@pytest.mark.flights
def test_a_latency_or_focal_length_that_was_wrong_leaves_no_trace(sea):
    fx = 900.0 / 1.05
    info = (1280, 720, "plumb_bob", [], [fx, 0, 640.0, 0, fx, 360.0, 0, 0, 1.0])
    wrong = type(sea.camera).from_camera_info(*info)
    focal = {"calibration.focal_scale": 1.05}
    assert max(_errors(_flown(sea, _world(sea), focal, focal, camera=wrong))) < 0.15
    assert max(_errors(_flown(sea, _world(sea), {}, focal, camera=wrong))) < 0.25
    assert max(_errors(_flown(sea, _world(sea), {}, {}, camera=wrong))) > 0.5
    late = {"camera.latency_s": 0.15}
    assert max(_errors(_flown(sea, _world(sea, late_s=0.15), {}, late))) < 0.2
    assert max(_errors(_flown(sea, _world(sea, late_s=0.15), {}, {}))) > 0.25


@pytest.mark.flights
def test_a_large_change_is_no_jump_of_the_camera_and_a_latency_none_of_time(sea):
    values = {"noise.heading_deg": 15.0, "noise.gnss_offset_m": 0.5}
    world = _world(sea, rpy_bias_deg=(0.0, 0.0, -15.0))
    engine = sea.estimator(values)
    sea.play(engine, world, CHANGED_S, images=10, until_flush=False)
    new = values | {"calibration.heading_deg": 15.0, "camera.latency_s": 0.05}
    engine.reconfigure(estimator_config({**sea.origin, **new}))
    joint = engine._tracks.pipeline.tracking.table.filter
    assert joint.trajectory._pose_ns == sea.stamp(CHANGED_S - 0.05)
    last = sea.play(engine, world, END_S - CHANGED_S, begin=CHANGED_S, images=10)[-1]
    assert {one.robot_id for one in last.estimates} == {"aqua_1", "aqua_2", "aqua_3"}
    assert "orientation_jumps" not in engine.happened


@pytest.mark.flights
def test_a_latency_that_was_estimated_stays_the_same_sum(sea):
    more, late = {"noise.latency_s": 0.2}, {"camera.latency_s": 0.2}
    kept = _flown(sea, _world(sea, late_s=0.3), {}, {}, more, images=10)
    changed = _flown(sea, _world(sea, late_s=0.3), {}, late, more, images=10)
    for name, one in kept.items():
        assert math.dist(one.position[:2], changed[name].position[:2]) < 0.06
    assert max(_errors(changed)) < 0.15


def _joint(config, by_heading=1.0):
    """Return a state with a robot 20 m ahead of a camera 30 m up, and its view."""
    model = PlatformModel(config.noise, "earth")
    prior = model.nominal.copy()
    now = prior.copy()
    now[HEADING, HEADING] *= by_heading
    joint = JointState(now)
    pose = MapPose(np.array([0.0, 0.0, 30.0]), matrix_from_rpy(0.0, 0.9, math.pi / 2))
    view = CameraView.of(None, pose, np.zeros(6), 0.0)
    relinearize(joint, view)
    place = np.array([[0.0, 20.0]])
    by_errors = by_platform(joint, place)
    assert by_errors[0, :, HEADING] == pytest.approx([-20.0, 0.0])
    joint.add(np.array([0]), place, by_errors, 0.01 * np.eye(2)[None], 0.5)
    return joint, prior, view


def test_what_links_a_robot_to_the_platform_turns_and_grows_with_it():
    config = estimator_config({})
    joint, prior, view = _joint(config)
    before = joint.covariance[COUNT : COUNT + 2, :COUNT].copy()
    turned = estimator_config({"calibration.heading_deg": 30.0, "calibration.height_m": 3.0})
    recalibrate(joint, CalibrationChange.between(config, turned), prior, view, searched=False)
    c, s = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    rotation = np.array([[c, -s], [s, c]])
    for name, growth in (("roll", 1.1), ("pitch", 1.1), ("height", 1.0)):
        k = PLATFORM.index(name)
        expected = growth * rotation @ before[:, k]
        assert joint.covariance[COUNT : COUNT + 2, k] == pytest.approx(expected, rel=0.02), name
    points = on_water_surface(joint.robots[:, :2])
    points[:, 2] -= joint.mean[PLATFORM.index("height")]
    by_pose = state_jacobian(np.hstack([points - joint.camera, joint.robots[:, 2:]]))
    assert joint.by_pose == pytest.approx(by_pose)  # so that the next image carries nothing


@pytest.mark.parametrize(("known", "moves"), [(1.0, True), (1e-12, False)])
def test_what_is_known_of_an_error_decides_who_moves(known, moves):
    config = estimator_config({})
    turned = estimator_config({"calibration.heading_deg": 30.0})
    joint, prior, view = _joint(config, known)
    spread = joint.covariance[:COUNT, :COUNT].copy()
    recalibrate(joint, CalibrationChange.between(config, turned), prior, view, searched=False)
    angle = math.radians(30.0)
    expected = (-20.0 * math.sin(angle), 20.0 * math.cos(angle)) if moves else (0.0, 20.0)
    assert joint.robots[0, :2] == pytest.approx(expected, abs=0.15)
    assert joint.mean[HEADING] == pytest.approx(0.0 if moves else -angle, abs=1e-6)
    assert joint.covariance[:COUNT, :COUNT] == pytest.approx(spread, abs=1e-12)


def test_a_law_is_likelier_by_what_its_images_say_of_the_new_prior():
    """Against one measurement z of the heading with variance R: N(z; d, C + R) / N(z; 0, C + R)."""
    config = estimator_config({})
    joint, prior, _ = _joint(config)
    stated, z, d = prior[HEADING, HEADING], 0.03, math.radians(1.0)
    noise = 0.5 * stated
    gain = stated / (stated + noise)
    joint.mean[HEADING] = gain * z
    joint.covariance[HEADING, HEADING] = (1.0 - gain) * stated
    change = CalibrationChange.between(config, estimator_config({"calibration.heading_deg": 1.0}))
    expected = 0.5 * (z**2 - (z - d) ** 2) / (stated + noise)
    assert likelier(joint, change, prior) == pytest.approx(expected)


def test_what_the_filter_takes_to_be_exact_widens_robots_out_of_view():
    config = estimator_config({})
    for seconds, widened in ((0.0, False), (1.0, True)):
        joint, prior, view = _joint(config)
        joint.unseen[:] = seconds
        before = joint.covariance.diagonal()[COUNT : COUNT + 2].copy()
        change = CalibrationChange.between(config, estimator_config({"camera.latency_s": 0.1}))
        recalibrate(joint, change, prior, view, searched=False)
        more = joint.covariance.diagonal()[COUNT : COUNT + 2] - before
        assert more == pytest.approx([1.0, 1.0] if widened else [0.0, 0.0])  # 0.1 s at 10 m/s


def test_only_the_shorter_way_round_counts():
    at = [estimator_config({"calibration.heading_deg": angle}) for angle in (-170.0, 170.0, 175.0)]
    turns = [CalibrationChange.between(*two).errors[HEADING] for two in pairwise(at)]
    assert turns == pytest.approx([math.radians(-20.0), math.radians(5.0)])
    assert not CalibrationChange.between(at[0], at[0])
