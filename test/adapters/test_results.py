# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results in messages: orders of covariances, frames and states, through CDR and back."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.map_frame import WAVES_M2, Frames
from aerial_gnss_ros.adapters.results import (
    ALTITUDE_M2,
    COURSE_KNOWN,
    UNKNOWN_ANGLE_RAD2,
    UNKNOWN_LENGTH_M2,
    course,
    covariance_parts,
    detection_array,
    position_update,
    result_messages,
)
from aerial_gnss_ros.adapters.results import odometry as adapters_odometry
from aerial_gnss_ros.bags.typestore import serialize, typestore
from aerial_gnss_ros.core.values.estimates import Current, State
from aerial_gnss_ros.detection.base import Detections

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import DATUM, RESULT, ROBOT

ESTIMATE = replace(ROBOT, altitude=-40.0)
RESULT = replace(RESULT, estimates=(ESTIMATE,), datum=replace(DATUM, altitude=-42.0))


def published(result):
    """Return messages by topic, as a subscriber gets them."""
    return {
        m.topic: typestore().deserialize_cdr(serialize(m.msgtype, m.fields), m.msgtype)
        for m in result_messages(result)
    }


def with_estimate(**changes):
    return replace(RESULT, estimates=(replace(ESTIMATE, **changes),))


def test_a_sample_for_other_filters_states_the_position_alone():
    sample = position_update(RESULT.estimates[0], RESULT.datum)
    assert sample.topic == "robots/aqua_1/position_update"
    pose = sample.fields["pose"]["pose"]["position"]
    assert [pose["x"], pose["y"]] == RESULT.estimates[0].position.tolist()
    covariance = np.reshape(sample.fields["pose"]["covariance"], (6, 6))
    assert covariance[:2, :2].tolist() == RESULT.estimates[0].covariance[:2, :2].tolist()
    assert min(covariance.diagonal()[3:]) == UNKNOWN_ANGLE_RAD2
    assert sample.fields["header"]["frame_id"] == "map"


def test_topics_types_and_order():
    assert [(m.topic, m.msgtype) for m in result_messages(RESULT)] == [
        ("map_datum", "geographic_msgs/msg/GeoPoseStamped"),
        ("robots/aqua_1/geo_pose", "geographic_msgs/msg/GeoPoseWithCovarianceStamped"),
        ("robots/aqua_1/fix", "sensor_msgs/msg/NavSatFix"),
        ("robots/aqua_1/odom", "nav_msgs/msg/Odometry"),
        ("robots/markers", "visualization_msgs/msg/MarkerArray"),
    ]
    before_the_first_fix = replace(RESULT, estimates=(), datum=None)
    assert [m.topic for m in result_messages(before_the_first_fix)] == ["robots/markers"]


def test_the_current_is_a_twist_east_and_north_of_which_no_more_is_known():
    known = Current(np.array([0.3, -0.1]), np.array([[0.04, 0.01], [0.01, 0.09]]))
    sent = published(replace(RESULT, current=known))["current"]
    assert (sent.twist.twist.linear.x, sent.twist.twist.linear.y) == (0.3, -0.1)
    covariance = np.reshape(sent.twist.covariance, (6, 6))
    assert covariance[:2, :2].tolist() == known.covariance.tolist()
    assert covariance.diagonal()[2:].tolist() == [UNKNOWN_LENGTH_M2, *3 * [UNKNOWN_ANGLE_RAD2]]
    assert sent.header.frame_id == "map"
    assert "current" not in published(RESULT)


def test_every_header_carries_the_image_s_stamp_and_its_frame():
    messages = published(RESULT)
    frames = {topic: m.header.frame_id for topic, m in messages.items() if topic[-1] != "s"}
    assert frames == {
        "map_datum": "map",
        "robots/aqua_1/geo_pose": "map",
        "robots/aqua_1/fix": "aqua_1/course",
        "robots/aqua_1/odom": "map",
    }
    for topic, message in messages.items():
        header = message.markers[0].header if topic == "robots/markers" else message.header
        assert (header.stamp.sec, header.stamp.nanosec) == (5, 7)


def test_geo_pose_has_north_first_and_the_course_as_yaw():
    message = published(RESULT)["robots/aqua_1/geo_pose"]
    position = message.pose.pose.position
    assert (position.latitude, position.longitude) == (pytest.approx(13.0), pytest.approx(-59.0))
    assert position.altitude == -40.0
    yaw = 2.0 * math.atan2(message.pose.pose.orientation.z, message.pose.pose.orientation.w)
    assert yaw == pytest.approx(math.pi / 2)  # northward; yaw 0 is east
    covariance = message.pose.covariance.reshape(6, 6)
    expected = np.diag([9.0, 4.0, ALTITUDE_M2, UNKNOWN_ANGLE_RAD2, UNKNOWN_ANGLE_RAD2, 0.01 / 4.0])
    expected[0, 1] = expected[1, 0] = 0.5
    np.testing.assert_allclose(covariance, expected, atol=1e-12)


def test_fix_has_east_first_and_says_when_it_coasts():
    message = published(RESULT)["robots/aqua_1/fix"]
    assert (message.latitude, message.longitude) == (pytest.approx(13.0), pytest.approx(-59.0))
    np.testing.assert_allclose(
        message.position_covariance, [4.0, 0.5, 0.0, 0.5, 9.0, 0.0, 0.0, 0.0, ALTITUDE_M2]
    )
    assert (message.status.status, message.position_covariance_type) == (0, 1)
    coasting = published(with_estimate(state=State.COASTING))["robots/aqua_1/fix"]
    assert coasting.status.status == -1


def test_odom_is_in_map_with_the_twist_along_the_course():
    message = published(RESULT)["robots/aqua_1/odom"]
    position, twist = message.pose.pose.position, message.twist.twist.linear
    assert (position.x, position.y, position.z) == (30.0, 20.0, 0.0)
    assert message.child_frame_id == "aqua_1/course"
    assert (twist.x, twist.y) == (pytest.approx(2.0), pytest.approx(0.0, abs=1e-12))
    pose_covariance = message.pose.covariance.reshape(6, 6)
    np.testing.assert_allclose(pose_covariance[:2, :2], [[4.0, 0.5], [0.5, 9.0]])
    twist_covariance = message.twist.covariance.reshape(6, 6)
    np.testing.assert_allclose(twist_covariance[:2, :2], np.diag([0.04, 0.01]), atol=1e-12)
    assert twist_covariance[2, 2] == UNKNOWN_LENGTH_M2


@pytest.mark.parametrize(
    ("velocity", "known"),
    [([0.0, 0.0], False), ([0.25, 0.0], False), ([0.31, 0.0], True), ([math.nan, 0.0], False)],
)
def test_a_course_is_known_when_it_is_three_times_its_own_uncertainty(velocity, known):
    assert (course(replace(ESTIMATE, velocity=np.array(velocity))) is not None) == known


def test_a_course_is_judged_by_the_pseudo_inverse_of_any_covariance():
    rng = np.random.default_rng(4)
    known = 0
    for rank in (1, 2) * 100:
        root = rng.normal(0.0, 0.1, (2, rank))
        velocity, covariance = rng.normal(0.0, 0.3, 2), root @ root.T
        whole = ESTIMATE.covariance.copy()
        whole[2:, 2:] = covariance
        squared = velocity @ np.linalg.pinv(covariance, rcond=1e-9) @ velocity
        found = course(replace(ESTIMATE, velocity=velocity, covariance=whole)) is not None
        assert found == (squared >= COURSE_KNOWN)
        known += found
    assert 40 < known < 160


def test_an_unknown_course_is_identity_with_a_large_variance_and_an_enu_twist():
    messages = published(with_estimate(velocity=np.array([0.1, -0.2])))
    for name in ("geo_pose", "odom"):
        pose = messages[f"robots/aqua_1/{name}"].pose
        assert pose.pose.orientation.w == 1.0
        assert pose.covariance[35] == UNKNOWN_ANGLE_RAD2
    twist = messages["robots/aqua_1/odom"].twist.twist.linear
    assert (twist.x, twist.y) == (0.1, -0.2)


def test_no_velocity_is_a_twist_of_zero_about_which_nothing_is_known():
    nothing = with_estimate(velocity=np.array([math.nan, math.nan]))
    odometry = published(nothing)["robots/aqua_1/odom"]
    assert (odometry.twist.twist.linear.x, odometry.twist.twist.linear.y) == (0.0, 0.0)
    assert odometry.twist.covariance[0] == odometry.twist.covariance[7] == UNKNOWN_LENGTH_M2


def test_an_unknown_altitude_is_nan_on_earth_and_zero_in_the_map():
    messages = published(with_estimate(altitude=math.nan))
    assert math.isnan(messages["robots/aqua_1/fix"].altitude)
    assert math.isnan(messages["robots/aqua_1/geo_pose"].pose.pose.position.altitude)
    assert messages["robots/aqua_1/fix"].position_covariance[8] == UNKNOWN_LENGTH_M2
    odometry = messages["robots/aqua_1/odom"]
    assert odometry.pose.pose.position.z == 0.0
    assert odometry.pose.covariance[14] == WAVES_M2
    (above,) = with_estimate(altitude=math.nan).estimates
    fields = adapters_odometry(above, DATUM, Frames(on_water=False))
    assert fields["pose"]["pose"]["position"]["z"] == 0.0  # viewers draw nothing at NaN
    assert fields["pose"]["covariance"][14] == UNKNOWN_LENGTH_M2


def test_the_datum_is_the_origin_of_the_map():
    position = published(RESULT)["map_datum"].pose.position
    assert (position.latitude, position.longitude) == (pytest.approx(13.0), pytest.approx(-59.0))
    assert position.altitude == -42.0


def test_detections_copy_the_header_and_name_the_class():
    header = {"stamp": {"sec": 3, "nanosec": 4}, "frame_id": "camera"}
    detections = Detections(
        xywh=np.array([[10.5, 20.0, 30.0, 40.0]]),
        scores=np.array([0.75]),
        class_ids=np.array([1]),
        class_names=("boat", "aqua"),
    )
    msgtype = "vision_msgs/msg/Detection2DArray"
    fields = detection_array(detections, header)
    array = typestore().deserialize_cdr(serialize(msgtype, fields), msgtype)
    [box] = array.detections
    assert array.header == box.header
    assert (array.header.stamp.sec, array.header.frame_id) == (3, "camera")
    assert (box.bbox.center.position.x, box.bbox.center.position.y) == (10.5, 20.0)
    assert (box.bbox.size_x, box.bbox.size_y) == (30.0, 40.0)
    [result] = box.results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ("aqua", 0.75)


def test_both_parts_of_a_covariance_add_up_to_the_published_one():
    white = np.array([[0.3, 0.1], [0.1, 0.2]])
    measured = replace(ESTIMATE, white=white)
    shared, alone = covariance_parts(measured, RESULT.datum)
    assert [shared.topic, alone.topic] == [
        "robots/aqua_1/covariance_shared", "robots/aqua_1/covariance_white",
    ]  # fmt: skip
    parts = [
        np.reshape(one.fields["pose"]["covariance"], (6, 6))[:2, :2] for one in (shared, alone)
    ]
    assert parts[1].tolist() == white.tolist()
    fix = published(replace(RESULT, estimates=(measured,)))["robots/aqua_1/fix"]
    assert (parts[0] + parts[1]).ravel() == pytest.approx(fix.position_covariance[[0, 1, 3, 4]])
    assert shared.fields["pose"]["pose"] == alone.fields["pose"]["pose"]
    assert covariance_parts(ESTIMATE, RESULT.datum) == ()
    assert covariance_parts(replace(measured, state=State.COASTING), RESULT.datum) == ()
