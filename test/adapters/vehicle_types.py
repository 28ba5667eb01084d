# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Message types of autopilots that neither ROS nor rosbags brings: the fields that are read here.

The real definitions have more fields and comments; adapters read by name, so these stand for them.
"""

from __future__ import annotations

import functools

from aerial_gnss_ros.bags import typestore as bags_typestore

TEXTS = {
    "mavros_msgs/msg/GimbalDeviceAttitudeStatus": """
std_msgs/Header header
uint8 target_system
uint8 target_component
uint16 flags
geometry_msgs/Quaternion q
float32 angular_velocity_x
float32 angular_velocity_y
float32 angular_velocity_z
uint32 failure_flags
""",
    "px4_msgs/msg/VehicleGlobalPosition": """
uint64 timestamp
uint64 timestamp_sample
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
    # as v1.14 had it; a name of its own here, as one store holds one definition a name
    "px4_old_msgs/msg/SensorGps": """
uint64 timestamp
int32 lat
int32 lon
int32 alt
int32 alt_ellipsoid
uint8 fix_type
float32 eph
float32 epv
""",
    "px4_msgs/msg/VehicleAttitude": """
uint64 timestamp
uint64 timestamp_sample
float32[4] q
float32[4] delta_q_reset
uint8 quat_reset_counter
""",
    "px4_msgs/msg/VehicleLocalPosition": """
uint64 timestamp
uint64 timestamp_sample
bool xy_valid
bool z_valid
float32 x
float32 y
float32 z
float32 heading
float32 dist_bottom
bool dist_bottom_valid
""",
    "px4_msgs/msg/GimbalDeviceAttitudeStatus": """
uint64 timestamp
uint8 target_system
uint8 target_component
uint16 device_flags
float32[4] q
float32 delta_yaw
uint8 gimbal_device_id
bool received_from_mavlink
""",
}


@functools.cache
def extended():
    """Return the shipped types and those above in one store."""
    return bags_typestore.extended(TEXTS)
