# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each kind of vehicle sends: the reverse of `adapters`, one kind of message at a time.

It is made of the simulation's samples, by the program's own conversions: damage is looked for, not
wrong conversions. Those are for `test/adapters/encodings.py`, which uses nothing of the program.

Between them the vehicles use every shipped profile and every kind of message in `adapters.kinds`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import telemetry_fields as canonical
from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.psdk import NORTH_TO_EAST
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.adapters.vehicles import vehicle_file
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    quaternion_product,
    rpy_from_matrix,
)
from aerial_gnss_ros.core.values.samples import Array, Fix, Orientation, Scalar
from aerial_gnss_ros.nodes.schemas import ESTIMATOR, SCHEMAS
from aerial_gnss_ros.simulation.flight import HOLETOWN

_HALF = math.sqrt(0.5)
_FROM_ENU = {"ned": (_HALF, _HALF, 0.0, 0.0), "nwu": (0.0, 0.0, -_HALF, _HALF)}
_FRD = (1.0, 0.0, 0.0, 0.0)
_YAW_IN_EARTH_FRAME = 64
_LEVEL_MOUNT = (0.0, _HALF, 0.0, _HALF)  # mount_rpy_deg [0, 90, 0] of the profile


@dataclass(frozen=True)
class Moment:
    """What a vehicle's sensors measure at one time: those that sample then."""

    fix: Fix | None = None
    attitude: Orientation | None = None
    gimbal: Orientation | None = None
    height: Scalar | None = None


@dataclass(frozen=True)
class Vehicle:
    """One vehicle.

    Attributes:
        profile: name of a shipped one.
        values: parameters that differ from the profile's.
        flight: orbit or hover.
        judged: whether its positions must be right: not where each image stands alone.
    """

    profile: str
    values: Mapping[str, object] = field(default_factory=dict)
    flight: str = "orbit"
    judged: bool = True

    def config(self, more: Mapping[str, object] | None = None) -> EstimatorConfig:
        """Return the estimator's parameters; `more` of them that the flight tells."""
        values = read([vehicle_file(self.profile)], SCHEMAS)[ESTIMATOR]
        return estimator_config(values | dict(self.values) | dict(more or {}))


_WATER_M = HOLETOWN.altitude
_STATED = {"fix.altitude_datum": "ellipsoid"}
VEHICLES = {
    "generic": Vehicle("generic", _STATED),
    "generic on its body": Vehicle(
        "generic",
        {
            "attitude.type": "quaternion", "gimbal.reference": "body", "height.type": "range",
            "height.stamp": "header", "camera.offset_m": [0.1, 0.0, -0.1],
            "depth.topics": ["depth"],
        },
    ),
    "generic by angles": Vehicle(
        "generic",
        {"attitude.type": "vector3", "gimbal.type": "vector3", "gimbal.unit": "deg",
         "gimbal.reference": "body"},
    ),
    "generic, attitude of poses": Vehicle(
        "generic", {"attitude.type": "pose", "fix.type": "geo_pose", "fix.altitude_datum": "amsl"}
    ),
    "generic, height from the fix": Vehicle(
        "generic", _STATED | {"height.source": "none", "surface.altitude": _WATER_M}
    ),
    "generic, latency in doubt": Vehicle("generic", {"noise.latency_s": 0.2}),
    "generic, each image alone": Vehicle("generic", {"method": "single"}, judged=False),
    "generic, as published": Vehicle("generic", {"method": "paper"}, judged=False),
    "mavros_px4, told where": Vehicle(
        "mavros_px4",
        {
            "map.latitude_deg": math.degrees(HOLETOWN.latitude),
            "map.longitude_deg": math.degrees(HOLETOWN.longitude),
            "robots.leader.class": "aqua",
            "robots.leader.start": [math.degrees(HOLETOWN.latitude) + 1e-5,
                                    math.degrees(HOLETOWN.longitude)],
            "detections.classes": ["aqua"],
        },
    ),
    "mavros_ardupilot": Vehicle(
        "mavros_ardupilot",
        {"gimbal.type": "mavros_mount", "gimbal.stamp": "arrival", "gimbal.reference": "earth"},
    ),
    "px4_uxrce": Vehicle("px4_uxrce"),
    "px4_uxrce, raw": Vehicle(
        "px4_uxrce", {"fix.type": "px4_sensor_gps", "height.type": "px4_dist_bottom"}
    ),
    "ardupilot_dds": Vehicle("ardupilot_dds"),
    "dji_psdk": Vehicle("dji_psdk"),
    "anafi": Vehicle("anafi"),
    "fixed_camera": Vehicle("fixed_camera", flight="hover"),
}  # fmt: skip
"""By name."""


def messages(config: EstimatorConfig, moment: Moment) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return message type and fields by input, of what is sampled at a moment."""
    found: dict[str, tuple[str, dict[str, Any]]] = {}
    fix, attitude, gimbal, height = moment.fix, moment.attitude, moment.gimbal, moment.height
    if attitude is not None and gimbal is not None:
        if config.gimbal.reference == "fixed":  # the body is where the camera says that it is
            turn = quaternion_product(gimbal.quaternion, _inverse(np.array(_LEVEL_MOUNT)))
            attitude = Orientation(attitude.stamp_ns, turn)
        elif config.gimbal.reference == "body":
            turn = quaternion_product(_inverse(attitude.quaternion), gimbal.quaternion)
            gimbal = Orientation(gimbal.stamp_ns, turn)
    if fix is not None and config.fix.source == "topic":
        found["fix"] = FIX[config.fix.type].msgtype, _FIXES[config.fix.type](fix)
    if attitude is not None:
        kind, at = ATTITUDE[config.attitude.type], config.attitude
        own = _turned(attitude.quaternion, at.world, at.body)
        found["attitude"] = kind.msgtype, _ORIENTATIONS[at.type](attitude.stamp_ns, own, at.unit)
    on_topic = config.gimbal.source == "topic" and config.gimbal.reference != "fixed"
    if gimbal is not None and on_topic:
        on = config.gimbal
        world = "enu" if on.reference == "body" else on.world
        own = _turned(gimbal.quaternion, world, on.body)
        found["gimbal"] = (
            GIMBAL[on.type].msgtype,
            _ORIENTATIONS[on.type](gimbal.stamp_ns, own, on.unit),
        )
    if height is not None and config.height.source == "topic":
        found["height"] = HEIGHT[config.height.type].msgtype, _HEIGHTS[config.height.type](height)
        if config.height.home_topic:
            found["home"] = found["height"][0], {"data": 0.0}
    return found


def _inverse(quaternion: Array) -> Array:
    return np.asarray(quaternion * np.array([-1.0, -1.0, -1.0, 1.0]))


def _turned(quaternion: Array, world: str, body: str) -> Array:
    """Return an orientation of FLU axes in ENU in a message's own axes."""
    turned = quaternion
    if world in _FROM_ENU:
        turned = quaternion_product(_FROM_ENU[world], turned)
    return quaternion_product(turned, _FRD) if body == "frd" else turned


# --- positions -------------------------------------------------------------------------------


def _anafi_fix(fix: Fix) -> dict[str, Any]:
    return canonical.fix_fields(fix)  # its horizontal variances are alike here


def _geo_pose_fix(fix: Fix) -> dict[str, Any]:
    place = {
        "latitude": math.degrees(fix.latitude),
        "longitude": math.degrees(fix.longitude),
        "altitude": fix.altitude,
    }
    return {"header": header_fields(fix.stamp_ns, ""), "pose": {"position": place}}


def _px4_position(fix: Fix) -> dict[str, Any]:
    return {
        "timestamp": fix.stamp_ns // 1000,
        "lat": math.degrees(fix.latitude),
        "lon": math.degrees(fix.longitude),
        "alt": fix.altitude,
        "alt_ellipsoid": fix.altitude,
        "lat_lon_valid": True,
        "alt_valid": True,
        "eph": 1.2,
        "epv": 2.0,
    }


def _px4_gps(fix: Fix) -> dict[str, Any]:
    return {
        "timestamp": fix.stamp_ns // 1000,
        "latitude_deg": math.degrees(fix.latitude),
        "longitude_deg": math.degrees(fix.longitude),
        "altitude_msl_m": fix.altitude,
        "altitude_ellipsoid_m": fix.altitude,
        "fix_type": 3,
        "eph": 1.2,
        "epv": 2.0,
    }


_FIXES: dict[str, Callable[[Fix], dict[str, Any]]] = {
    "navsatfix": canonical.fix_fields,
    "anafi_fix": _anafi_fix,
    "geo_pose": _geo_pose_fix,
    "px4_global_position": _px4_position,
    "px4_sensor_gps": _px4_gps,
}

# --- orientations ----------------------------------------------------------------------------

_Encoder = Callable[[int, Array, str], dict[str, Any]]


def _xyzw(q: Array) -> dict[str, float]:
    return dict(zip("xyzw", map(float, q), strict=True))


def _headed(name: str) -> _Encoder:
    return lambda stamp_ns, q, _unit: {"header": header_fields(stamp_ns, ""), name: _xyzw(q)}


def _posed(stamp_ns: int, q: Array, _unit: str) -> dict[str, Any]:
    return {"header": header_fields(stamp_ns, ""), "pose": {"orientation": _xyzw(q)}}


def _angles(stamp_ns: int, q: Array, unit: str) -> dict[str, Any]:
    rpy = rpy_from_matrix(matrix_from_quaternion(q))
    values = np.degrees(rpy) if unit == "deg" else rpy
    vector = dict(zip("xyz", map(float, values), strict=True))
    return {"header": header_fields(stamp_ns, ""), "vector": vector}


def _psdk(stamp_ns: int, q: Array, _unit: str) -> dict[str, Any]:
    fields = _angles(stamp_ns, q, "rad")
    fields["vector"]["z"] += NORTH_TO_EAST - 0.5 * math.pi
    return fields


def _px4(**more: int) -> _Encoder:
    def encode(stamp_ns: int, q: Array, _unit: str) -> dict[str, Any]:
        return {"timestamp": stamp_ns // 1000, "q": q[[3, 0, 1, 2]], **more}

    return encode


def _mavros(stamp_ns: int, q: Array, _unit: str) -> dict[str, Any]:
    header = header_fields(stamp_ns, "base_link_frd")
    return {"header": header, "flags": _YAW_IN_EARTH_FRAME, "q": _xyzw(q)}


_ORIENTATIONS: dict[str, _Encoder] = {
    "imu": _headed("orientation"),
    "quaternion": _headed("quaternion"),
    "vector3": _angles,
    "pose": _posed,
    "geo_pose": _posed,
    "px4_attitude": _px4(),
    "mavros_gimbal": _mavros,
    "mavros_mount": lambda _stamp_ns, q, _unit: _xyzw(q),
    "px4_gimbal": _px4(device_flags=_YAW_IN_EARTH_FRAME),
    "psdk_gimbal": _psdk,
}

# --- heights ---------------------------------------------------------------------------------


def _range(height: Scalar) -> dict[str, Any]:
    header = header_fields(height.stamp_ns, "")
    return {"header": header, "min_range": 0.1, "max_range": 100.0, "range": height.value}


def _px4_local(height: Scalar) -> dict[str, Any]:
    return {
        "timestamp": height.stamp_ns // 1000,
        "z_valid": True,
        "z": -height.value,
        "dist_bottom": height.value,
        "dist_bottom_valid": True,
    }


_HEIGHTS: dict[str, Callable[[Scalar], dict[str, Any]]] = {
    "float64": canonical.float_fields,
    "float32": canonical.float_fields,
    "range": _range,
    "pose": lambda height: {
        "header": header_fields(height.stamp_ns, ""),
        "pose": {"position": {"z": height.value}},
    },
    "px4_local_position": _px4_local,
    "px4_dist_bottom": _px4_local,
}
