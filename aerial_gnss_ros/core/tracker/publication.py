# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Published estimates of labelled robots: moments of the mixture of hypotheses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.identity.label_ambiguity import Position
from aerial_gnss_ros.core.models.platform_model import named_errors
from aerial_gnss_ros.core.numerics.gaussian import within
from aerial_gnss_ros.core.references.references import References
from aerial_gnss_ros.core.tracker.fork import Fork
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate

Array = NDArray[np.float64]


def published(
    table: TrackTable,
    encounters: Encounters,
    fork: Fork | None,
    references: References,
    local: LocalMap,
    altitude: float,
    stamp_ns: int,
) -> tuple[tuple[RobotEstimate, ...], tuple[PlatformError, ...]]:
    """Return the labelled robots at an image, sorted by label, and the platform's errors.

    Those that vanished (see `VanishedRobots`) are left out.

    Args:
        table: of the tracks.
        encounters: ambiguities of labels.
        fork: the alternative hypothesis, if there is one.
        references: objects of known position.
        local: the frame `map`.
        altitude: of the water above the ellipsoid, m.
        stamp_ns: of the image, ns.
    """
    joint, labelled = table.filter, list[tuple[str, int]]()
    for row, track in enumerate(table.tracks):
        if track.robot_id and not track.vanished:
            labelled.append((track.robot_id, row))
    errors, view = joint.platform, joint.trajectory.view
    axes = None if view is None else view.axes
    if not labelled:
        return (), named_errors(*errors, axes)
    labelled.sort()
    labels, rows = zip(*labelled, strict=True)
    mean, covariance = joint.moments()
    told = references.apply(table.tracks, mean, covariance, stamp_ns)
    seen = None if told is None else references.turned
    joint.add_fault_covariances(covariance, seen)
    if joint.laws.moored is not None and fork is None:
        by_law = () if told is None else (references.published,)
        joint.laws.moored.publish(joint.groups, mean, covariance, *by_law)
    if list(rows) != list(range(len(mean))):
        mean, covariance = mean[list(rows)], covariance[list(rows)]
    if encounters.ambiguous:
        add_label_ambiguity(labels, mean, covariance, encounters)
    if fork is not None:  # either hypothesis may be right
        slots = {name: i for i, name in enumerate(labels)}
        for name, apart in fork.apart(slots, mean[:, :2]).items():
            covariance[slots[name], :2, :2] += np.outer(apart, apart)
    latitude, longitude = local.places(mean[:, :2])
    estimates: list[RobotEstimate] = []
    places = zip(latitude.tolist(), longitude.tolist(), strict=True)
    states = zip(mean[:, :2], mean[:, 2:], covariance, strict=True)
    for row, (lat, lon), (position, velocity, spread) in zip(rows, places, states, strict=True):
        track = table.tracks[row]
        estimates.append(
            RobotEstimate(
                stamp_ns, track.robot_id, track.class_id, track.state, lat, lon, altitude,
                position, velocity, spread, track.last_seen_ns,
            )
        )  # fmt: skip
    return tuple(estimates), named_errors(*(told or errors), axes)


def with_white(
    estimates: tuple[RobotEstimate, ...], table: TrackTable
) -> tuple[RobotEstimate, ...]:
    """Return estimates with the white parts of their covariances.

    It is what a robot's boxes leave uncertain where the platform's errors are known. All else, such
    as a possible jump or another label, lasts, and counts as shared.

    Args:
        estimates: of all robots, as published.
        table: of the tracks.
    """
    if not estimates:
        return ()
    own = table.filter.given_platform()
    rows = {track.robot_id: row for row, track in enumerate(table.tracks)}
    return tuple(
        replace(one, white=within(own[rows[one.robot_id]], one.covariance[:2, :2]))
        for one in estimates
    )


def add_label_ambiguity(
    labels: tuple[str, ...], mean: Array, covariance: Array, encounters: Encounters
) -> None:
    """Add the spread over robots of ambiguous labels to covariances (n, 4, 4).

    Args:
        labels: (n,) of the robots.
        mean: (n, 4) positions and velocities, m, m/s.
        covariance: of these, changed in place.
        encounters: ambiguities of labels.
    """
    spots = {
        name: Position(mean[i, :2].copy(), covariance[i, :2, :2].copy())
        for i, name in enumerate(labels)
    }
    for name, more in encounters.ambiguity_covariances(spots).items():
        covariance[labels.index(name), :2, :2] += more
