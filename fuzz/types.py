# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Message types: those that the program ships with, and the autopilots' that it reads by name."""

from __future__ import annotations

import functools

from rosbags.typesys.store import Typestore

from aerial_gnss_ros.bags.typestore import extended

TEXTS = {
    "mavros_msgs/msg/GimbalDeviceAttitudeStatus": """
std_msgs/Header header
uint16 flags
geometry_msgs/Quaternion q
""",
    "px4_msgs/msg/VehicleGlobalPosition": """
uint64 timestamp
float64 lat
float64 lon
float32 alt
float32 alt_ellipsoid
bool lat_lon_valid
bool alt_valid
float32 eph
float32 epv
""",
    "px4_msgs/msg/SensorGps": """
uint64 timestamp
float64 latitude_deg
float64 longitude_deg
float64 altitude_msl_m
float64 altitude_ellipsoid_m
uint8 fix_type
float32 eph
float32 epv
""",
    "px4_msgs/msg/VehicleAttitude": """
uint64 timestamp
float32[4] q
""",
    "px4_msgs/msg/VehicleLocalPosition": """
uint64 timestamp
bool z_valid
float32 z
float32 dist_bottom
bool dist_bottom_valid
""",
    "px4_msgs/msg/GimbalDeviceAttitudeStatus": """
uint64 timestamp
uint16 device_flags
float32[4] q
""",
}
"""The fields that are read, by type; adapters read by name, so these stand for the definitions of
MAVROS and PX4. What they are tested with, too; a case is known by its fields: add none."""


@functools.cache
def typestore() -> Typestore:
    """Return the program's types and the autopilots' in a store of their own."""
    return extended(TEXTS)
