# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests whether robots left their gates independently or by one rotation of the camera.

Robots that manoeuvre harder than stated leave their gates, several at once where images are rare. A
rotation of the camera moves all boxes together, along the derivative of positions by its angles.
`rotation_test` compares the two; robots that stayed inside their gates are evidence against a
rotation.
"""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.association.assignment import lone
from aerial_gnss_ros.core.association.clutter import Clutter
from aerial_gnss_ros.core.association.gating import CandidatePairs
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.filter.innovation import PairInnovations
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.models.motion_model import manoeuvre_covariance
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis


def swerves(
    joint: JointFilter, pairs: PairInnovations, left: list[int], chosen: list[int], threshold: float
) -> int:
    """Return how many robots outside their gates manoeuvred independently.

    Zero, unless that is clearly likelier than a rotation of the camera.

    Args:
        joint: the joint filter.
        pairs: of robots and boxes.
        left: unassociated pairs, of robots expected in the image.
        chosen: pairs of robots inside their gates.
        threshold: squared Mahalanobis distance at the edge of a gate.
    """
    spread = pairs.spread[left] + manoeuvre_covariance(joint.speeds(pairs.rows[left]))
    squared = mahalanobis(pairs.offsets[left], spread)[0].tolist()
    rows: set[int] = set()
    columns: set[int] = set()
    own: list[int] = []
    for near, k in sorted(zip(squared, left, strict=True)):
        row, column = int(pairs.rows[k]), int(pairs.columns[k])
        if near <= threshold and row not in rows and column not in columns:
            rows.add(row)
            columns.add(column)
            own.append(k)
    if not own:
        return 0
    both = own + chosen
    variances = 0.5 * np.trace(pairs.spread[both], axis1=1, axis2=2)
    turned = joint.turned_by(pairs.rows[both], pairs.offsets[both], variances)
    return len(own) if turned < -CLEAR_NATS else 0


def manoeuvred_pairs(
    joint: JointFilter,
    tracks: list[Track],
    candidates: CandidatePairs,
    left: list[int],
    threshold: float,
    clutter: Clutter,
) -> list[int]:
    """Return left-over pairs of robots and boxes that can only belong together.

    A robot without a box in its gate, and a box near it that fits no other robot: it has
    manoeuvred, rather than vanished just when another one surfaced there. But the detector may
    have missed it and reported clutter there, the likelier the lower the camera. Where that may
    well be, the box must continue an earlier one since the robot was last seen.

    Args:
        joint: the joint filter.
        tracks: all of them.
        candidates: candidate pairs, without manoeuvres.
        left: left-over pairs of robots and boxes of one class.
        threshold: squared Mahalanobis distance at the edge of a gate.
        clutter: rates of clutter and of missed robots.
    """
    pairs = candidates.pairs
    spread = pairs.spread[left] + manoeuvre_covariance(joint.speeds(pairs.rows[left]))
    squared, log_sizes = mahalanobis(pairs.offsets[left], spread)
    doubtful = dict(zip(left, clutter.doubtful(log_sizes).tolist(), strict=True))
    near = [k for k, one in zip(left, squared.tolist(), strict=True) if one <= threshold]
    rows, columns = pairs.rows[near].tolist(), pairs.columns[near].tolist()
    own: list[int] = []
    for k, row, column, alone in zip(near, rows, columns, lone(rows, columns), strict=True):
        robot = tracks[row]
        others = [
            tracks[candidates.rows[i]]
            for i in candidates.new_inside
            if candidates.columns[i] == column
        ]
        if not alone or any(robot.coexisted(other) for other in others):
            continue
        if not doubtful[k] or any(one.first_seen_ns > robot.last_seen_ns for one in others):
            own.append(k)
    return own
