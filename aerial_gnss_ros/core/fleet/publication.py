# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a fleet publishes: robots, widened by what is in doubt, drones' errors, and a report."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.agreement import DroneReport, receiver_offset
from aerial_gnss_ros.core.fleet.clocks import clock_offset
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fleet_references import FleetReferences
from aerial_gnss_ros.core.fleet.matching import TUNING as MATCHING
from aerial_gnss_ros.core.fleet.robot_table import RobotTable
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.models.platform_model import COUNT, named_errors
from aerial_gnss_ros.core.telemetry.depths import inflate_by_depth
from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate, State

Array = NDArray[np.float64]
_NAMES = {"latency": "clock"}
"""What is in an error's place (see `clocks`)."""


@dataclass(frozen=True)
class FleetUpdate:
    """Result of one sighting.

    Attributes:
        estimates: confirmed and coasting robots, ordered by name; none where they were not asked
            for.
        platform: errors of all drones, with the drone's name before that of the error where there
            are several; likewise.
        report: of the drone that the sighting came from.
        names: the fleet's name by that drone's own, of the robots that it knows.
        notes: what became of references.
    """

    estimates: tuple[RobotEstimate, ...]
    platform: tuple[PlatformError, ...]
    report: DroneReport
    names: dict[str, str]
    notes: tuple[str, ...] = ()


class FleetPublication:
    """Robots and drones' errors, as the filter and references have them.

    Args:
        drones: of the fleet, by number.
        table: of the robots.
        references: objects of known position.
        local: the frame `map`.
        depth_m: one sigma of the robots' depth, m.
    """

    def __init__(
        self, drones: list[Drone], table: RobotTable, references: FleetReferences,
        local: LocalMap, depth_m: float,
    ) -> None:  # fmt: skip
        self._drones, self._table, self._references = drones, table, references
        self._local, self._depth_m = local, depth_m

    def estimates(self, seen: Sighting) -> tuple[tuple[RobotEstimate, ...], Array, Array]:
        """Return robots and drones' errors at the time of a sighting.

        Returns:
            The robots that have a name; the errors (9 N,) of all drones; their covariance.
        """
        table, stamp_ns = self._table, seen.pose.stamp_ns
        joint, robots = table.state.joint, table.robots
        mean, blocks = joint.robots.copy(), joint.blocks()
        told = self._references.apply(robots, mean, blocks, table.state, stamp_ns)
        if table.staying is not None and table.staying.law is not None:
            # Images of drones that take turns are no misses.
            shown = [measured(robot, self._drones, stamp_ns) for robot in robots]
            unseen = np.where(shown, 0.0, joint.unseen)
            table.staying.publish(mean, blocks, self._references.published, unseen)
        estimates = published(mean, blocks, robots, self._drones, seen, self._local)
        found = inflate_by_depth(tuple(estimates), seen.pose, self._local, self._depth_m)
        return found, *told

    def update(self, drone: int, seen: Sighting, with_estimates: bool) -> FleetUpdate:
        """Return the result of a sighting that the fleet has taken in.

        Args:
            drone: number of its drone.
            seen: the sighting.
            with_estimates: whether robots and errors are asked for.
        """
        estimates, platform = tuple[RobotEstimate, ...](), tuple[PlatformError, ...]()
        if with_estimates:
            estimates, errors, spread = self.estimates(seen)
            platform = platform_errors(self._drones, errors, spread)
        known = [robot for robot in self._table.robots if robot.name and drone in robot.labels]
        return FleetUpdate(
            estimates,
            platform,
            self._report(drone, seen, sum(len(robot.labels) > 1 for robot in known)),
            {robot.labels[drone]: robot.name for robot in known},
            tuple(self._references.log.drain()),
        )

    def _report(self, drone: int, seen: Sighting, shared: int) -> DroneReport:
        """Return what is to be said of a drone that shares some robots with others."""
        one, state, drones = self._drones[drone], self._table.state, len(self._drones)
        offset, sigma = receiver_offset(state, drone, drones)
        disagrees = (
            one.fault is not None
            or one.suspected
            or one.agreement.disagrees
            or displaced(self._table.robots, drone, seen.pose.stamp_ns) > 0.0
        )
        return DroneReport(
            one.name, seen.stamp_ns, one.agreement.ratio, shared, offset, sigma, disagrees,
            one.fault.sensor if one.fault is not None else "", clock_offset(state, drone, drones),
        )  # fmt: skip


def platform_errors(drones: list[Drone], errors: Array, spread: Array) -> tuple[PlatformError, ...]:
    """Return all drones' errors by name.

    Args:
        drones: N of them, by number.
        errors: (9 N,) in their order.
        spread: (9 N, 9 N) covariance of these.
    """
    found = list[PlatformError]()
    for number, one in enumerate(drones):
        own = slice(COUNT * number, COUNT * number + COUNT)
        axes = None if one.view is None else one.view.axes
        for error in named_errors(errors[own], spread[own, own], axes):
            name = f"{one.name} {_NAMES.get(error.name, error.name)}"
            found.append(replace(error, name=name) if len(drones) > 1 else error)
    return tuple(found)


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
