# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tracks of a robot whose boxes have another class in some images.

Detectors confuse classes, so a robot's boxes form two tracks at one place, one of each class. Two
robots are in one image now and then; these two never are. The one with fewer boxes is no robot.
"""

from __future__ import annotations

from itertools import product

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis
from aerial_gnss_ros.core.tracker.track_table import TrackTable


def misclassified(
    table: TrackTable, ready: list[int], threshold: float, window_ns: int
) -> set[int]:
    """Return which tracks without a label are robots of another class.

    Each is inside the gate of a robot that the last images have shown at least as often, and never
    together with it.

    Args:
        table: all tracks.
        ready: rows of those without a label that could get one.
        threshold: squared Mahalanobis distance at the edge of a gate.
        window_ns: how long the last images are, ns.
    """
    tracks = table.tracks
    robots = [row for row, track in enumerate(tracks) if track.robot_id]
    pairs = [
        (robot, row)
        for robot, row in product(robots, ready)
        if tracks[robot].class_id != tracks[row].class_id
        and _alternate(tracks[robot], tracks[row], window_ns)
    ]
    if not pairs:
        return set()
    known, new = (sorted({*rows}) for rows in zip(*pairs, strict=True))
    squared, _ = mahalanobis(*table.separations(known, new))
    place = {row: i for rows in (known, new) for i, row in enumerate(rows)}
    return {row for robot, row in pairs if squared[place[robot], place[row]] <= threshold}


def _alternate(robot: Track, new: Track, window_ns: int) -> bool:
    """Return whether images have shown a robot at least as often as a track, and never both."""
    lately = [stamp for stamp in robot.hits if stamp > new.last_seen_ns - window_ns]
    return len(lately) >= len(new.hits) and not new.coexisted(robot)
