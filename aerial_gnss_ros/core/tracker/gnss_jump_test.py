# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests by robots whether the GNSS position of an image has jumped.

A step that a drone could have flown (`gnss_jump`) is a jump of the receiver or a motion. Two
copies of the tracks process the image, one for each: boxes fit robots with the right one. Where an
image shows none of the robots, the position is taken to have jumped, since no drone flies so: the
covariances of the robots, which are all out of sight, then contain the jump.
"""

from __future__ import annotations

import copy
from functools import partial

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.tracker.track_table import TrackTable


def robots_tell_jump(
    table: TrackTable, frame: PosedFrame, seen: Measurements, threshold: float
) -> bool:
    """Return whether an image's position has jumped, as robots tell, or as nobody sees.

    Args:
        table: the tracks, predicted to the image; not changed.
        frame: the image.
        seen: its measurements.
        threshold: squared Mahalanobis distance at the edge of a gate.
    """
    if not len(seen.index) or not table.in_view(frame.detections.stamp_ns):
        return any(track.robot_id for track in table.tracks)
    fit: list[float] = []
    for jumped in (False, True):
        alternative = copy.deepcopy(table)
        alternative.filter.update_camera(frame, partial(bool, jumped))
        there = seen.moved(-alternative.filter.trajectory.jumps.offset)
        fit.append(alternative.misfit(there, frame.detections.stamp_ns, threshold))
    return fit[0] - fit[1] > CLEAR_NATS
