# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Message types of autopilots that neither ROS nor rosbags brings: the fields that are read."""

from __future__ import annotations

import functools

from aerial_gnss_ros.bags import typestore as bags_typestore
from fuzz.types import TEXTS as OF_TODAY

TEXTS = OF_TODAY | {
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
}


@functools.cache
def extended():
    """Return the shipped types and those above in one store."""
    return bags_typestore.extended(TEXTS)
