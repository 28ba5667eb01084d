# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each vehicle would send in a scene, as its documentation says; written without the package.

An encoding is a function of (scene, stamp in ns) that returns the fields of a message. Quaternions
and angles come from scipy; undulation and declination are handed in.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
NWU_FROM_ENU = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
FRD_TO_FLU = np.diag([1.0, -1.0, -1.0])
OPTICAL_TO_FLU = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
HIGH = 30.0
EARTH, VEHICLE, YAW_LOCK, LEVEL = 64, 32, 16, 4 | 8


@dataclass(frozen=True)
class Vehicle:
    """A profile with overrides, and the messages of each input.

    Attributes:
        profile: name of a shipped profile.
        messages: message type and encoding, by input.
        values: parameters that differ from the profile's: fixed ones, or made of the scene.
        stamped: False where the arrival is the only stamp.
        altitude: whether the published altitude is known.
    """

    profile: str
    messages: dict[str, tuple[str, Callable]]
    values: dict | Callable = field(default_factory=dict)
    altitude: bool = True


def enu(ned_frd):
    return NED_TO_ENU @ ned_frd @ FRD_TO_FLU


def xyzw(matrix):
    return dict(zip("xyzw", map(float, Rotation.from_matrix(matrix).as_quat()), strict=True))


def wxyz(matrix):
    x, y, z, w = Rotation.from_matrix(matrix).as_quat()
    return np.array([w, x, y, z], dtype=np.float32)


def header(stamp_ns, frame_id=""):
    sec, nanosec = divmod(stamp_ns, 10**9)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame_id}


# --- canonical and standard messages ---------------------------------------------------------


def navsatfix(datum="ellipsoid"):
    def encode(scene, stamp_ns):
        altitude = {
            "ellipsoid": scene.altitude_m,
            "amsl": scene.altitude_m - scene.undulation_m,
            "nan": math.nan,
        }[datum]
        return {
            "header": header(stamp_ns),
            "latitude": scene.latitude_deg,
            "longitude": scene.longitude_deg,
            "altitude": altitude,
        }

    return "sensor_msgs/msg/NavSatFix", encode


def imu(turn_deg=lambda _scene: 0.0):
    def encode(scene, stamp_ns):
        turn = Rotation.from_euler("Z", turn_deg(scene), degrees=True).as_matrix()
        return {"header": header(stamp_ns), "orientation": xyzw(enu(turn @ scene.ned_body))}

    return "sensor_msgs/msg/Imu", encode


def quaternion(matrix):
    def encode(scene, stamp_ns):
        return {"header": header(stamp_ns), "quaternion": xyzw(matrix(scene))}

    return "geometry_msgs/msg/QuaternionStamped", encode


def vector(angles):
    def encode(scene, stamp_ns):
        values = dict(zip("xyz", map(float, angles(scene)), strict=True))
        return {"header": header(stamp_ns), "vector": values}

    return "geometry_msgs/msg/Vector3Stamped", encode


def number(msgtype, value=lambda _scene: HIGH):
    return f"std_msgs/msg/{msgtype}", lambda scene, _stamp: {"data": value(scene)}


def slant_range(scene, stamp_ns):
    """A laser along the body's down axis."""
    return {
        "header": header(stamp_ns),
        "range": HIGH / scene.ned_body[2, 2],
        "min_range": 0.1,
        "max_range": 100.0,
    }


# --- TF --------------------------------------------------------------------------------------


def transforms(*links):
    """A tf2_msgs/TFMessage of (parent, child, rotation of the child in the parent by scene)."""

    def encode(scene, stamp_ns):
        return {
            "transforms": [
                {
                    "header": header(stamp_ns, parent),
                    "child_frame_id": child,
                    "transform": {"translation": {"x": 0.1}, "rotation": xyzw(matrix(scene))},
                }
                for parent, child, matrix in links
            ]
        }

    return "tf2_msgs/msg/TFMessage", encode


def by_scipy(sequence, *degrees):
    return Rotation.from_euler(sequence, degrees, degrees=True).as_matrix()


def joint(_scene):
    """The gimbal's arm hangs below the base, turned about its vertical axis."""
    return by_scipy("zy", 17.0, 30.0)


def gimbal_on_joint(scene):
    return joint(scene).T @ FRD_TO_FLU @ scene.body_camera @ FRD_TO_FLU


# --- MAVLink's gimbal ------------------------------------------------------------------------


def mavros_gimbal(matrix, flags):
    def encode(scene, stamp_ns):
        return {
            "header": header(stamp_ns, "base_link_frd"),
            "flags": flags,
            "q": xyzw(matrix(scene)),
        }

    return "mavros_msgs/msg/GimbalDeviceAttitudeStatus", encode


def mavros_mount(scene, _stamp_ns):
    return xyzw(scene.level_camera)


def px4_gimbal(matrix, flags):
    def encode(scene, stamp_ns):
        return {"timestamp": stamp_ns // 1000, "device_flags": flags, "q": wxyz(matrix(scene))}

    return "px4_msgs/msg/GimbalDeviceAttitudeStatus", encode


def px4_position(scene, stamp_ns):
    return {
        "timestamp": stamp_ns // 1000,
        "lat": scene.latitude_deg,
        "lon": scene.longitude_deg,
        "alt": scene.altitude_m - scene.undulation_m,
        "alt_ellipsoid": scene.altitude_m,
        "lat_lon_valid": True,
        "alt_valid": True,
        "eph": 1.5,
        "epv": 2.0,
    }


def px4_gps(scene, stamp_ns):
    return {
        "timestamp": stamp_ns // 1000,
        "latitude_deg": scene.latitude_deg,
        "longitude_deg": scene.longitude_deg,
        "altitude_msl_m": scene.altitude_m - scene.undulation_m,
        "altitude_ellipsoid_m": scene.altitude_m,
        "fix_type": 3,
        "eph": 1.5,
        "epv": 2.0,
    }


def px4_old_gps(scene, stamp_ns):
    return {
        "timestamp": stamp_ns // 1000,
        "lat": round(scene.latitude_deg * 1e7),
        "lon": round(scene.longitude_deg * 1e7),
        "alt": round(1000 * (scene.altitude_m - scene.undulation_m)),
        "alt_ellipsoid": round(1000 * scene.altitude_m),
        "fix_type": 3,
        "eph": 1.5,
        "epv": 2.0,
    }


def px4_attitude(scene, stamp_ns):
    return {"timestamp": stamp_ns // 1000, "q": wxyz(scene.ned_body)}


def px4_local(_scene, stamp_ns):
    return {
        "timestamp": stamp_ns // 1000,
        "z_valid": True,
        "z": -HIGH,
        "dist_bottom": HIGH,
        "dist_bottom_valid": True,
    }


# --- DJI, ArduPilot, ANAFI -------------------------------------------------------------------


def dji_angles(scene):
    """As psdk_ros2 makes them of DJI's pitch (down is negative), roll and yaw (NED), in deg."""
    roll, pitch, yaw = np.radians(
        [scene.camera_roll_deg, -scene.down_deg, scene.camera_heading_deg]
    )
    shifted = 1.571 - yaw
    return roll, -pitch, (shifted + math.pi) % (2 * math.pi) - math.pi


def geo_pose(scene, stamp_ns):
    position = {
        "latitude": scene.latitude_deg,
        "longitude": scene.longitude_deg,
        "altitude": scene.altitude_m - scene.undulation_m,
    }
    pose = {"position": position, "orientation": xyzw(enu(scene.ned_body))}
    return {"header": header(stamp_ns), "pose": pose}


def local_pose(scene, stamp_ns):
    pose = {"position": {"z": HIGH}, "orientation": xyzw(enu(scene.ned_body))}
    return {"header": header(stamp_ns, "base_link"), "pose": pose}


def mount_rpy_deg(scene):
    flu = FRD_TO_FLU @ scene.body_camera @ FRD_TO_FLU
    yaw, pitch, roll = Rotation.from_matrix(flu).as_euler("ZYX", degrees=True)
    return {"gimbal.mount_rpy_deg": [float(roll), float(pitch), float(yaw)]}


def mast(scene):
    yaw = 90.0 - scene.camera_heading_deg
    return {
        "fix.latitude_deg": scene.latitude_deg,
        "fix.longitude_deg": scene.longitude_deg,
        "fix.altitude_m": scene.altitude_m,
        "gimbal.rpy_deg": [scene.camera_roll_deg, scene.down_deg, yaw],
        "height.value_m": HIGH,
    }


def anafi_degrees(scene):
    """Roll, pitch, yaw in deg, FLU in NWU: yaw 0 is north, counter-clockwise."""
    return scene.camera_roll_deg, scene.down_deg, -scene.camera_heading_deg


CANONICAL = {
    "fix": navsatfix(),
    "attitude": imu(),
    "gimbal": quaternion(lambda s: enu(s.ned_camera)),
    "height": number("Float64"),
}
MAVROS = CANONICAL | {"gimbal": mavros_gimbal(lambda s: s.level_camera, LEVEL | VEHICLE)}
PX4 = {
    "fix": ("px4_msgs/msg/VehicleGlobalPosition", px4_position),
    "attitude": ("px4_msgs/msg/VehicleAttitude", px4_attitude),
    "gimbal": px4_gimbal(lambda s: s.level_camera, LEVEL | VEHICLE),
    "height": ("px4_msgs/msg/VehicleLocalPosition", px4_local),
}
PSDK = {
    "fix": navsatfix(),
    "attitude": quaternion(lambda s: enu(s.ned_body)),
    "gimbal": vector(dji_angles),
    "home": number("Float32", lambda s: s.water_m),
    "height": number("Float32", lambda s: s.altitude_m),
}
ANAFI = {
    "fix": navsatfix(),
    "attitude": quaternion(lambda s: NWU_FROM_ENU @ enu(s.ned_body)),
    "gimbal": quaternion(lambda s: NWU_FROM_ENU @ enu(s.ned_camera)),
    "height": number("Float32"),
}
ELLIPSOID = {"fix.altitude_datum": "ellipsoid"}
MAGNETIC = imu(lambda s: -s.declination_deg)  # magnetic heading is true heading less declination

VEHICLES = {
    "generic": Vehicle("generic", CANONICAL, ELLIPSOID),
    "generic, TF below the body": Vehicle(
        "generic",
        CANONICAL
        | {
            "gimbal": transforms(
                ("odom", "base_link", lambda s: enu(s.ned_body)),
                ("base_link", "arm", joint),
                ("arm", "gimbal", gimbal_on_joint),
            ),
            "tf_static": transforms(
                ("gimbal", "camera_optical_frame", lambda _s: OPTICAL_TO_FLU),
            ),
        },
        ELLIPSOID | {"gimbal.source": "tf", "gimbal.reference": "body"},
    ),
    "generic, TF in the world": Vehicle(
        "generic",
        CANONICAL
        | {
            "gimbal": transforms(
                ("base_link", "map", lambda s: enu(s.ned_body).T),  # the world hangs on the base
                ("base_link", "gimbal", lambda s: FRD_TO_FLU @ s.body_camera @ FRD_TO_FLU),
            ),
        },
        ELLIPSOID
        | {"gimbal.source": "tf", "gimbal.base_frame": "map", "gimbal.camera_frame": "gimbal"},
    ),
    "generic, no datum": Vehicle("generic", CANONICAL, altitude=False),
    "generic, heights from amsl": Vehicle(
        "generic",
        CANONICAL | {"fix": navsatfix("amsl")},
        lambda s: {
            "fix.altitude_datum": "amsl",
            "height.source": "none",
            "surface.altitude": s.water_m - s.undulation_m,
        },
    ),
    "generic, range finder on the body": Vehicle(
        "generic",
        CANONICAL | {"height": ("sensor_msgs/msg/Range", slant_range)},
        ELLIPSOID | {"height.type": "range", "height.stamp": "header", "height.along": "body"},
    ),
    "generic, magnetic body": Vehicle(
        "generic",
        CANONICAL
        | {
            "attitude": MAGNETIC,
            "gimbal": quaternion(lambda s: FRD_TO_FLU @ s.body_camera @ FRD_TO_FLU),
        },
        ELLIPSOID | {"gimbal.reference": "body", "attitude.north": "magnetic"},
    ),
    "generic, magnetic gimbal": Vehicle(
        "generic",
        CANONICAL
        | {
            "gimbal": quaternion(
                lambda s: enu(
                    Rotation.from_euler("Z", -s.declination_deg, degrees=True).as_matrix()
                    @ s.ned_camera
                )
            )
        },
        ELLIPSOID | {"gimbal.north": "magnetic"},
    ),
    "mavros_px4, flags heading": Vehicle("mavros_px4", MAVROS),
    "mavros_px4, flags earth": Vehicle(
        "mavros_px4", MAVROS | {"gimbal": mavros_gimbal(lambda s: s.ned_camera, LEVEL | EARTH)}
    ),
    "mavros_px4, older device, yaw locked": Vehicle(
        "mavros_px4", MAVROS | {"gimbal": mavros_gimbal(lambda s: s.ned_camera, LEVEL | YAW_LOCK)}
    ),
    "mavros_px4, older device, yaw follows": Vehicle(
        "mavros_px4", MAVROS | {"gimbal": mavros_gimbal(lambda s: s.level_camera, LEVEL)}
    ),
    "mavros_px4, wrong flags overridden": Vehicle(
        "mavros_px4",
        MAVROS | {"gimbal": mavros_gimbal(lambda s: s.ned_camera, LEVEL | VEHICLE)},
        {"gimbal.reference": "earth"},
    ),
    "mavros_px4, servo mount": Vehicle(
        "mavros_px4",
        MAVROS | {"gimbal": mavros_gimbal(lambda s: s.body_camera, LEVEL | YAW_LOCK)},
        {"gimbal.reference": "body"},
    ),
    "mavros_px4, protocol 1": Vehicle(
        "mavros_px4",
        MAVROS | {"gimbal": ("geometry_msgs/msg/Quaternion", mavros_mount)},
        {
            "gimbal.type": "mavros_mount",
            "gimbal.stamp": "arrival",
            "gimbal.reference": "heading",
        },
    ),
    "mavros_ardupilot": Vehicle("mavros_ardupilot", MAVROS),
    "mavros_ardupilot, magnetic": Vehicle(
        "mavros_ardupilot", MAVROS | {"attitude": MAGNETIC}, {"attitude.north": "magnetic"}
    ),
    "mavros_ardupilot, servo mount": Vehicle(
        "mavros_ardupilot",
        MAVROS | {"gimbal": mavros_gimbal(lambda s: s.body_camera, LEVEL | VEHICLE)},
        {"gimbal.reference": "body"},
    ),
    "px4_uxrce, flags heading": Vehicle("px4_uxrce", PX4),
    "px4_uxrce, flags earth, amsl": Vehicle(
        "px4_uxrce",
        PX4 | {"gimbal": px4_gimbal(lambda s: s.ned_camera, LEVEL | EARTH)},
        {"fix.altitude_datum": "amsl"},
    ),
    "px4_uxrce, raw GNSS, bottom": Vehicle(
        "px4_uxrce",
        PX4 | {"fix": ("px4_msgs/msg/SensorGps", px4_gps)},
        {"fix.type": "px4_sensor_gps", "height.type": "px4_dist_bottom"},
    ),
    "px4_uxrce, raw GNSS of v1.14": Vehicle(
        "px4_uxrce",
        PX4 | {"fix": ("px4_old_msgs/msg/SensorGps", px4_old_gps)},
        {"fix.type": "px4_sensor_gps"},
    ),
    "px4_uxrce, servo mount": Vehicle(
        "px4_uxrce",
        PX4 | {"gimbal": px4_gimbal(lambda s: s.body_camera, LEVEL | YAW_LOCK)},
        {"gimbal.reference": "body"},
    ),
    "ardupilot_dds": Vehicle(
        "ardupilot_dds",
        {
            "fix": ("geographic_msgs/msg/GeoPoseStamped", geo_pose),
            "attitude": ("geographic_msgs/msg/GeoPoseStamped", geo_pose),
            "height": ("geometry_msgs/msg/PoseStamped", local_pose),
        },
        mount_rpy_deg,
    ),
    "dji_psdk": Vehicle("dji_psdk", PSDK),
    "anafi": Vehicle("anafi", ANAFI, altitude=False),
    "anafi, degrees": Vehicle(
        "anafi",
        ANAFI | {"gimbal": vector(anafi_degrees)},
        ELLIPSOID | {"gimbal.type": "vector3", "gimbal.unit": "deg"},
    ),
    "fixed_camera": Vehicle("fixed_camera", {}, mast),
}
