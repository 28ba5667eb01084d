# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Quality of service of every topic."""

from __future__ import annotations

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
)


def sensor(depth: int) -> QoSProfile:
    """Best effort: matches best-effort and reliable publishers alike. Images have depth 1."""
    return _profile(depth, ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)


def sent_before(depth: int) -> QoSProfile:
    """Return the profile that also receives earlier latched messages; it must be reliable."""
    return _profile(depth, ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL)


def detections() -> QoSProfile:
    """Reliable and volatile on both sides: a lost array is a lost measurement."""
    return _profile(10, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)


def sightings() -> QoSProfile:
    """Reliable on both sides, and deep enough for what is sent again after an outage."""
    return _profile(100, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)


def latched() -> QoSProfile:
    """Return the profile of results: a late subscriber receives the last one at once.

    The subscriber must request reliable and transient local.
    """
    return _profile(1, ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL)


def sent_once() -> QoSProfile:
    """Return what samples for other filters are published with: none of them comes twice."""
    return _profile(10, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)


def pictures() -> QoSProfile:
    """Return what images for viewers are published with; these ask for reliable ones or not."""
    return _profile(1, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)


def transforms() -> QoSProfile:
    """Return the customary profile of /tf."""
    return _profile(100, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)


def diagnostics() -> QoSProfile:
    """Return the customary profile of /diagnostics."""
    return _profile(10, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)


def _profile(
    depth: int, reliability: ReliabilityPolicy, durability: DurabilityPolicy
) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=reliability,
        durability=durability,
    )
