# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Selects the topics of a recording for live nodes, and their names. Independent of ROS."""

from __future__ import annotations

import re
from collections.abc import Mapping

IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
DETECTIONS = "vision_msgs/msg/Detection2DArray"
GLOBAL = ("/tf", "/tf_static", "/clock", "/diagnostics", "/rosout", "/parameter_events")
"""Absolute by convention: namespaces do not apply."""

_LIVE = ("/clock", "/diagnostics", "/rosout", "/parameter_events")
"""Topics that player and live nodes publish themselves."""
_RESULT = re.compile(
    r"(/.*)?/(robots/[^/]+(/(geo_pose|fix|odom|position_update|covariance_(shared|white)))?"
    r"|map_datum|current|overview|sightings(/(parameters|request))?)"
)
_TRUTH = re.compile(r"(/.*)?/truth/.*")


def inputs(types: Mapping[str, str]) -> list[str]:
    """Return the topics of a recording to play into nodes.

    Topics that the nodes publish themselves are left out: results, and boxes if the recording has
    their images.

    Args:
        types: message types by absolute topic.
    """
    pictures = any(kind in IMAGES for kind in types.values())
    return [
        name
        for name, kind in types.items()
        if name not in _LIVE
        and (not _RESULT.fullmatch(name) or _TRUTH.fullmatch(name))
        and not (pictures and kind == DETECTIONS)
    ]


def moved(name: str, namespace: str) -> str:
    """Return a topic's name with a namespace prepended unless it has it already."""
    inner = namespace.strip("/")
    if not inner or name in GLOBAL or name.startswith(f"/{inner}/"):
        return name
    return f"/{inner}{name}"
