# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Associates boxes with robots at assumed delays, without the tracker.

Boxes are placed on the water and assigned to tracks from image to image, by least distance from the
predicted positions. A wrong latency shifts consecutive images almost equally, so the association is
valid far from the true latency; it is repeated for each candidate.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment

Array = NDArray[np.float64]
Index = NDArray[np.intp]

LONGEST_GAP_S = 5.0
LEAST_BOXES = 6
MOST_TRACKS = 10
SLACK_M, SLACK = 0.8, 0.02
"""Gate around the predicted position, in addition to a robot's motion: constant, and as a share of
the distance from the camera (1 deg)."""
FAR = 1e6


@dataclass
class _Track:
    """A track: rows of its boxes, position and time of the last one, and velocity."""

    kind: int
    place: Array
    time: float
    velocity: Array = field(default_factory=lambda: np.zeros(2))
    rows: list[int] = field(default_factory=list)


def link(
    t: Array, images: Index, places: Array, ranges: Array, kinds: Index, max_speed: float
) -> Index:
    """Return the track of each box (n,): 0 is the one with most boxes, -1 none.

    Args:
        t: times of the images, s, increasing.
        images: (n,) image of each box, not decreasing.
        places: (n, 2) East, North on the water, m; NaN if a box is not on the water.
        ranges: (n,) distances from the camera, m.
        kinds: (n,) number of each box's class.
        max_speed: of robots, m/s.
    """
    ended: list[_Track] = []
    active: list[_Track] = []
    bounds = np.searchsorted(images, np.arange(len(t) + 1))
    good: NDArray[np.bool_] = np.asarray(np.isfinite(places).all(axis=1))
    for image, now in enumerate(t):
        rows = np.arange(bounds[image], bounds[image + 1])
        rows = rows[good[rows]]
        if not len(rows):
            continue
        ended += [one for one in active if now - one.time > LONGEST_GAP_S]
        active = [one for one in active if now - one.time <= LONGEST_GAP_S]
        pairs = _pairs(active, rows, float(now), places, ranges, kinds, max_speed)
        for number, row in pairs:
            _extend(active[number], row, float(now), places[row], max_speed)
        free = set(rows.tolist()) - {row for _, row in pairs}
        active += [_Track(int(kinds[r]), places[r], float(now), rows=[r]) for r in sorted(free)]
    everything = sorted(ended + active, key=lambda one: -len(one.rows))
    tracks = np.full(len(images), -1)
    for number, one in enumerate(everything[:MOST_TRACKS]):
        if len(one.rows) >= LEAST_BOXES:
            tracks[one.rows] = number
    return tracks


def _pairs(
    active: list[_Track],
    rows: Index,
    now: float,
    places: Array,
    ranges: Array,
    kinds: Index,
    max_speed: float,
) -> list[tuple[int, int]]:
    """Return pairs of track and row: the assignment of least total distance within the gates."""
    if not active:
        return []
    since = np.array([now - one.time for one in active])
    place = np.array([one.place for one in active])
    velocity = np.array([one.velocity for one in active])
    expected = place + velocity * np.minimum(since, 1.0)[:, None]
    away = np.linalg.norm(expected[:, None] - places[rows][None], axis=2)
    gate = max_speed * since[:, None] + SLACK_M + SLACK * ranges[rows][None]
    away[away > gate] = FAR
    away[np.array([one.kind for one in active])[:, None] != kinds[rows][None]] = FAR
    found = zip(*linear_sum_assignment(away), strict=True)
    return [(int(a), int(rows[b])) for a, b in found if away[a, b] < FAR]


def _extend(track: _Track, row: int, now: float, place: Array, max_speed: float) -> None:
    since = max(now - track.time, 1e-3)
    seen = (place - track.place) / since
    seen *= min(1.0, max_speed / max(float(np.linalg.norm(seen)), 1e-9))
    track.velocity = track.velocity + min(1.0, 0.5 * since) * (seen - track.velocity)
    track.place, track.time = place, now
    track.rows.append(row)
