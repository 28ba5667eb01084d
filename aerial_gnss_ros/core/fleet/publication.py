# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a fleet publishes of its robots: the filter's estimates, widened by what is in doubt."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.matching import TUNING as MATCHING
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import RobotEstimate, State

Array = NDArray[np.float64]


def published(
    mean: Array, blocks: Array, robots: list[FleetRobot], drones: list[Drone], seen: Sighting,
    local: LocalMap,
) -> list[RobotEstimate]:  # fmt: skip
    """Return the robots that have a name, in the order of names.

    A robot is confirmed if the last image of any drone measured it.

    Args:
        mean: (n, 4) their states, m, m/s.
        blocks: (n, 4, 4) covariances of these; changed in place.
        robots: of the fleet.
        drones: by number.
        seen: the last sighting.
        local: the frame `map`.
    """
    now_ns = seen.pose.stamp_ns
    wrong = {number for number, one in enumerate(drones) if one.fault is not None}
    apart = [displaced(robots, number, now_ns) for number in range(len(drones))]
    places = local.places(mean[:, :2])
    found = list[RobotEstimate]()
    for slot, robot in enumerate(robots):
        if not robot.name:
            continue
        covariance = blocks[slot]
        covariance[:2, :2] += robot.widening(now_ns, wrong)
        if len(robot.labels) == 1 and not robot.contradicted(now_ns):
            # What displaces others of its only drone's robots may displace it as well.
            covariance[:2, :2] += apart[next(iter(robot.labels))] ** 2 * np.eye(2)
        state = State.CONFIRMED if measured(robot, drones, now_ns) else State.COASTING
        found.append(
            RobotEstimate(
                seen.stamp_ns,
                robot.name,
                robot.class_id,
                state,
                float(places[0][slot]),
                float(places[1][slot]),
                seen.pose.altitude - seen.pose.height,
                mean[slot, :2].copy(),
                mean[slot, 2:].copy(),
                covariance,
                robot.last_seen_ns + seen.stamp_ns - now_ns,
            )
        )
    return sorted(found, key=lambda one: one.robot_id)


def displaced(robots: list[FleetRobot], drone: int, now_ns: int) -> float:
    """Return how far off another drone shows robots in the place of a drone's own, at most, m.

    0 where none does.

    Args:
        robots: of the fleet.
        drone: number of the drone.
        now_ns: time of the last scene, ns.
    """
    found = 0.0
    for robot in robots:
        own = len(robot.labels) == 1 and drone in robot.labels
        if own and robot.rival is not None and robot.contradicted(now_ns):
            found = max(found, float(np.linalg.norm(robot.rival)))
    return found


def measured(robot: FleetRobot, drones: list[Drone], now_ns: int) -> bool:
    """Return whether the last image of any drone measured a robot."""
    for number in robot.labels:
        one = drones[number]
        if one.last is None or not one.recent(now_ns, MATCHING.fresh_s):
            continue
        if robot.seen_ns.get(number) == one.last.pose.stamp_ns:
            return True
    return False
