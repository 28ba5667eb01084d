# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Overviews as the estimator publishes them, for tests of what shows them."""

from __future__ import annotations

SECOND = 1_000_000_000
BEGIN = 1_700_000_000 * SECOND


def robot(name, seconds, state="confirmed", pixel=(100.0, 50.0)):
    """Return a robot that swims north by a millionth of a degree a second."""
    return {
        "id": name,
        "class": "aqua",
        "state": state,
        "place": [13.0 + 1e-6 * seconds, -59.0],
        "covariance_m2": [0.04, 0.0, 0.01],
        "velocity_mps": [0.0, 0.1],
        "last_seen_ns": BEGIN + round(seconds * SECOND),
        "depth_m": 0.0,
        "pixel": pixel,
    }


def overview(seconds, *robots, **other):
    """Return an overview some seconds after `BEGIN`."""
    stamp = BEGIN + round(seconds * SECOND)
    return {
        "stamp_ns": stamp,
        "now_ns": stamp,
        "drone": {
            "place": [13.0, -59.0 + 1e-6 * seconds],
            "height_m": 20.0,
            "camera_heading_deg": 90.0,
            "camera_below_horizon_deg": 60.0,
        },
        "footprint": [[13.0, -59.0], [13.0, -58.9999], [13.0001, -59.0]],
        "image_size": [640, 480],
        "robots": list(robots),
        "references": [],
        "area": [],
        "lights": [],
        **other,
    }
