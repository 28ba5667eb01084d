# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The same message, read by rosbags and by rclpy, gives the same value."""

from __future__ import annotations

import importlib
import math

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.stamps import copied_header, nanoseconds, stamp_fields
from aerial_gnss_ros.bags.typestore import serialize, typestore
from aerial_gnss_ros.core.telemetry.validity import validate
from aerial_gnss_ros.core.values.errors import CameraError

NOW = 12


def by_rosbags(msgtype, fields):
    return typestore().deserialize_cdr(serialize(msgtype, fields), msgtype)


def by_rclpy(msgtype, fields):
    package, _, name = msgtype.split("/")
    serialization = pytest.importorskip("rclpy.serialization")
    try:
        module = importlib.import_module(f"{package}.msg")
    except ImportError:
        pytest.skip(f"{package} is not installed")
    return serialization.deserialize_message(serialize(msgtype, fields), getattr(module, name))


@pytest.fixture(params=[by_rosbags, by_rclpy])
def message(request):
    return request.param


FIX = "sensor_msgs/msg/NavSatFix"
COVARIANCE = [4.0, 0.5, 0.0, 0.5, 9.0, 0.0, 0.0, 0.0, 25.0]


def test_a_fix_comes_in_radians_with_its_covariance(message):
    fields = {
        "latitude": 45.0,
        "longitude": -90.0,
        "altitude": 12.5,
        "position_covariance": COVARIANCE,
        "position_covariance_type": 3,
    }
    fix = canonical.fix(message(FIX, fields), NOW)
    assert (fix.stamp_ns, fix.altitude, fix.valid) == (NOW, 12.5, True)
    assert fix.latitude == pytest.approx(math.pi / 4, abs=1e-15)
    assert fix.longitude == pytest.approx(-math.pi / 2, abs=1e-15)
    np.testing.assert_array_equal(fix.covariance, np.reshape(COVARIANCE, (3, 3)))


@pytest.mark.parametrize(
    ("covariance", "kind", "given"),
    [
        (COVARIANCE, 1, True),
        (COVARIANCE, 0, False),  # type: unknown
        ([0.0] * 9, 2, False),  # simulators: a type but no variance
        ([0.0] * 8 + [4.0], 2, False),
        ([math.nan, *COVARIANCE[1:]], 3, True),  # the core says that it is none
        ([*COVARIANCE[:8], math.nan], 3, True),
    ],
)
def test_a_covariance_counts_where_it_says_something(message, covariance, kind, given):
    fields = {"position_covariance": covariance, "position_covariance_type": kind}
    assert (canonical.fix(message(FIX, fields), NOW).covariance is not None) == given


@pytest.mark.parametrize("variance", [math.inf, math.nan, -1.0, 1e9])
@pytest.mark.parametrize("kind", [1, 2, 3])
def test_a_stated_covariance_that_is_none_makes_no_fix(message, variance, kind):
    covariance = np.diag([variance] * 3).ravel().tolist()
    fields = {"latitude": 45.0, "position_covariance": covariance}
    stated = canonical.fix(message(FIX, fields | {"position_covariance_type": kind}), NOW)
    assert validate(stated)[0]
    unknown = canonical.fix(message(FIX, fields | {"position_covariance_type": 0}), NOW)
    assert validate(unknown) == ("", unknown)


@pytest.mark.parametrize(("status", "valid"), [(-2, True), (-1, False), (0, True), (2, True)])
def test_status_minus_one_is_no_fix(message, status, valid):
    assert canonical.fix(message(FIX, {"status": {"status": status}}), NOW).valid is valid


def test_orientations_of_all_types_agree(message):
    half = math.sqrt(0.5)
    down = {"x": 0.0, "y": half, "z": 0.0, "w": half}  # pitch +90 deg
    read = [
        canonical.orientation(message("sensor_msgs/msg/Imu", {"orientation": down}), NOW, "imu"),
        canonical.orientation(
            message("geometry_msgs/msg/QuaternionStamped", {"quaternion": down}), NOW, "quaternion"
        ),
        canonical.orientation(
            message("geometry_msgs/msg/Vector3Stamped", {"vector": {"y": math.pi / 2}}),
            NOW,
            "vector3",
        ),
    ]
    for orientation in read:
        assert orientation.stamp_ns == NOW
        np.testing.assert_allclose(orientation.quaternion, [0.0, half, 0.0, half], atol=1e-15)


@pytest.mark.parametrize(("first", "given"), [(-1.0, False), (0.0, True), (0.01, True)])
def test_an_imu_that_measures_no_orientation_is_not_taken_for_level_and_east(message, first, given):
    fields = {"orientation": {"w": 1.0}, "orientation_covariance": [first] + 8 * [0.0]}
    read = canonical.orientation(message("sensor_msgs/msg/Imu", fields), NOW, "imu")
    trouble, _ = validate(read)
    assert ("orientation_covariance[0] is -1" in trouble) != given


@pytest.mark.parametrize(
    ("msgtype", "fields"),
    [
        ("std_msgs/msg/Float64", {"data": 7.5}),
        ("std_msgs/msg/Float32", {"data": 7.5}),
        ("sensor_msgs/msg/Range", {"range": 7.5, "max_range": 40.0}),
    ],
)
def test_heights_of_all_types_agree(message, msgtype, fields):
    height = canonical.scalar(message(msgtype, fields), NOW)
    assert (height.stamp_ns, height.value) == (NOW, 7.5)


@pytest.mark.parametrize(
    ("value", "limits", "kept"),
    [
        (7.5, (0.2, 40.0), True),
        (math.inf, (0.2, 40.0), False),  # REP 117: nothing within reach
        (-math.inf, (0.2, 40.0), False),
        (41.0, (0.2, 40.0), False),
        (0.2, (0.2, 40.0), False),  # at its stop: nothing within reach, or too near
        (40.0, (0.2, 40.0), False),
        (7.5, (0.0, 0.0), True),  # limits that say nothing
    ],
)
def test_a_range_outside_the_sensor_s_limits_is_none(message, value, limits, kept):
    fields = {"range": value, "min_range": limits[0], "max_range": limits[1]}
    height = canonical.scalar(message("sensor_msgs/msg/Range", fields), NOW)
    assert math.isfinite(height.value) == kept


def test_angles_in_degrees_are_those_in_radians(message):
    degrees = message(
        "geometry_msgs/msg/Vector3Stamped", {"vector": {"x": 5.0, "y": 90.0, "z": -30.0}}
    )
    angles = {"x": math.radians(5.0), "y": math.pi / 2, "z": math.radians(-30.0)}
    radians = message("geometry_msgs/msg/Vector3Stamped", {"vector": angles})
    np.testing.assert_allclose(
        canonical.orientation(degrees, NOW, "vector3", "deg").quaternion,
        canonical.orientation(radians, NOW, "vector3").quaternion,
        atol=1e-15,
    )


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize(
    ("angle", "given"),
    [(6283.0, True), (-6283.0, True), (6284.0, False), (-1e18, False), (math.inf, False)],
)
def test_an_angle_beyond_a_thousand_turns_is_none(message, axis, angle, given):
    read = message("geometry_msgs/msg/Vector3Stamped", {"vector": {axis: angle}})
    orientation = canonical.orientation(read, NOW, "vector3")
    trouble, _ = validate(orientation)
    assert ("1,000 turns" in trouble) != given


CAMERA = {
    "width": 640,
    "height": 480,
    "distortion_model": "plumb_bob",
    "d": [0.1, -0.05, 0.001, 0.002, 0.01],
    "k": [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0],
    "r": np.eye(3).ravel(),
    "p": [400.0, 0.0, 310.0, 0.0, 0.0, 410.0, 230.0, 0.0, 0.0, 0.0, 1.0, 0.0],
}


@pytest.mark.parametrize(("rectified", "focal"), [(False, 500.0), (True, 400.0)])
def test_a_camera_comes_from_k_or_where_rectified_from_p(message, rectified, focal):
    msg = message("sensor_msgs/msg/CameraInfo", CAMERA)
    camera = canonical.camera(msg, rectified)
    assert (camera.width, camera.height) == (640, 480)
    assert camera.K[0, 0] == focal
    assert canonical.camera_key(msg) == canonical.camera_key(msg)
    zoomed = message("sensor_msgs/msg/CameraInfo", CAMERA | {"k": [600.0, *CAMERA["k"][1:]]})
    assert canonical.camera_key(msg) != canonical.camera_key(zoomed)


def test_a_camera_of_ros_1_has_capital_fields():
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    fields = {name.upper() if len(name) == 1 else name: value for name, value in CAMERA.items()}
    msg = types["sensor_msgs/msg/CameraInfo"](
        header=types["std_msgs/msg/Header"](0, types["builtin_interfaces/msg/Time"](0, 0), ""),
        roi=types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False),
        binning_x=0,
        binning_y=0,
        **fields,
    )
    assert canonical.camera(msg, rectified=False).K[1, 1] == 510.0


def test_a_binned_camera_is_refused(message):
    with pytest.raises(CameraError):
        canonical.camera(message("sensor_msgs/msg/CameraInfo", CAMERA | {"binning_x": 2}), False)


def test_a_camera_of_zeros_is_refused(message):
    with pytest.raises(CameraError):
        canonical.camera(message("sensor_msgs/msg/CameraInfo", {}), rectified=False)


def test_detections_take_the_best_hypothesis_and_keep_boxes_without_one(message):
    def hypothesis(name, score):
        return {"hypothesis": {"class_id": name, "score": score}}

    fields = {
        "header": {"stamp": stamp_fields(1_500_000_002), "frame_id": "camera"},
        "detections": [
            {
                "results": [hypothesis("boat", 0.25), hypothesis("aqua", 0.5)],
                "bbox": {
                    "center": {"position": {"x": 3.5, "y": 4.5}},
                    "size_x": 10.0,
                    "size_y": 20.0,
                },
            },
            {},
        ],
    }
    msg = message("vision_msgs/msg/Detection2DArray", fields)
    frame = canonical.detection_frame(msg)
    assert (frame.stamp_ns, frame.frame_id) == (1_500_000_002, "camera")
    np.testing.assert_array_equal(frame.centers, [[3.5, 4.5], [0.0, 0.0]])
    np.testing.assert_array_equal(frame.sizes, [[10.0, 20.0], [0.0, 0.0]])
    np.testing.assert_array_equal(frame.scores, [0.5, 0.0])
    assert frame.class_ids == ("aqua", "")
    assert nanoseconds(msg.header.stamp) == 1_500_000_002
    assert copied_header(msg.header) == fields["header"]


def test_an_image_without_detections_is_a_frame_too(message):
    frame = canonical.detection_frame(message("vision_msgs/msg/Detection2DArray", {}))
    assert len(frame) == 0
    assert frame.centers.shape == frame.sizes.shape == (0, 2)
    assert frame.scores.shape == (0,)
