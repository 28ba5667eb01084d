# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fleet's estimator: sightings of several drones, one filter, one name for each robot.

Each drone's own estimator decides which box is which of its robots; the fleet decides which of
these are one (`matching`) and estimates all of them from all boxes (`SharedState`). A box that
contradicts the fleet is not used; a drone whose boxes do so time after time keeps that robot for
itself. Sightings are given in the order of time.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.plausible_state import check_covariance, check_robots
from aerial_gnss_ros.core.fleet.agreement import Agreement
from aerial_gnss_ros.core.fleet.clocks import TUNING as CLOCKS
from aerial_gnss_ros.core.fleet.common_share import CommonShare
from aerial_gnss_ros.core.fleet.constellations import TUNING as CONSTELLATIONS
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fault_search import FaultSearch, Found
from aerial_gnss_ros.core.fleet.fleet_references import FleetReferences, staying_references
from aerial_gnss_ros.core.fleet.gates import fitting, usable
from aerial_gnss_ros.core.fleet.matching import RobotMatching
from aerial_gnss_ros.core.fleet.publication import FleetPublication, FleetUpdate
from aerial_gnss_ros.core.fleet.robot_table import RobotTable
from aerial_gnss_ros.core.fleet.robots import Names, recognise
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import RobotEstimate


@dataclass(frozen=True)
class FleetTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    released: int = 10
    """Consecutive boxes of a drone that contradict a robot after which they are another robot's.
    Judged."""


TUNING = FleetTuning()


class Fleet:
    """Robots of several drones.

    Args:
        configs: of each drone's estimator, by the drone's name.
        local: the frame `map`.
        share: prior share of the receivers' variance that is common, 0 to 1.

    Attributes:
        local: likewise.
        table: of the robots.

    Raises:
        ConfigError: a drone's configuration asks for what a fleet cannot do yet.
    """

    def __init__(
        self, configs: Mapping[str, EstimatorConfig], local: LocalMap, share: float = 0.5
    ) -> None:
        if not 0.0 <= share <= 1.0:
            raise ConfigError(f"the receivers' common share must lie within 0 to 1, not {share:g}.")
        for name, config in configs.items():
            refuse_unable(name, config)
        self.local = local
        self._drones = [
            Drone(name, config, CLOCKS.sigma_s if k else 0.0)
            for k, (name, config) in enumerate(configs.items())
        ]
        self._number = {name: i for i, name in enumerate(configs)}
        first = next(iter(configs.values()))
        self._threshold = gate_threshold(first.tracks.gate_probability)
        self.table = RobotTable(self._drones, [*configs.values()], share)
        self._matching = RobotMatching(self._drones)
        self._faults = FaultSearch(self._drones, self.table.motions.default_speed)
        self._references = FleetReferences(
            self._drones, staying_references(self._drones), self.table.state, CommonShare(share)
        )
        self._publication = FleetPublication(
            self._drones, self.table, self._references, local, first.depth.sigma_m
        )
        self._names = Names()
        self._now_ns: int | None = None

    def follow(self, former: Fleet) -> None:
        """Go on with the names of a fleet of which this one is made again, with all its drones."""
        numbers = {k: self._number[one.name] for k, one in enumerate(former._drones)
                   if one.name in self._number}  # fmt: skip
        names = {
            (numbers[drone], label): robot.name
            for robot in former.table.robots
            if robot.name
            for drone, label in robot.labels.items()
            if drone in numbers
        }
        self._names.follow(former._names.taken, names)

    def update(self, name: str, seen: Sighting, publish: bool = True) -> FleetUpdate:
        """Take in a drone's sighting, not older than the one before.

        Args:
            name: of the drone.
            seen: its sighting.
            publish: whether estimates are asked for, which take a third of the time.

        Raises:
            StateError: a number is not finite or not plausible.
        """
        drone, stamp_ns = self._number[name], seen.pose.stamp_ns
        self._predict(stamp_ns)
        table = self.table
        self._measure(drone, seen, table.look(drone, seen, self.local))
        pairs = self._matching.update(table.state, table.robots, stamp_ns)
        for first, second in pairs:
            table.tie(first, second, CONSTELLATIONS.same_m)
        self._drop([first for first, _ in pairs])
        found = self._faults.update(table.state, table.robots, stamp_ns)
        if found is not None:
            self._blame(found)
        for slot, robot in enumerate(table.robots):
            waits = robot.labels and not robot.name
            if waits and self._matching.nobody_else(slot, table.robots, stamp_ns):
                robot.name = self._names.issue(robot)
        self._references.update(table.robots, drone, seen, table.state, self.local)
        check_covariance(table.state.joint.covariance, "robots and platform")
        check_robots(table.state.joint.robots, "robots")
        return self._publication.update(drone, seen, publish)

    def predicted(self, stamp_ns: int) -> tuple[RobotEstimate, ...]:
        """Return the robots predicted without an image; the state is not changed.

        Args:
            stamp_ns: time of the prediction, on the images' clock, ns.
        """
        last = [one.last for one in self._drones if one.last is not None]
        if not last:
            return ()
        newest = max(last, key=lambda seen: seen.pose.stamp_ns)
        scene_ns = newest.pose.stamp_ns + stamp_ns - newest.stamp_ns
        seen = replace(newest, stamp_ns=stamp_ns, pose=replace(newest.pose, stamp_ns=scene_ns))
        return copy.deepcopy(self).coast(seen)

    def coast(self, seen: Sighting) -> tuple[RobotEstimate, ...]:
        """Predict to the time of a sighting without it; return the robots there."""
        self._predict(seen.pose.stamp_ns)
        return self._publication.estimates(seen)[0]

    def _predict(self, stamp_ns: int) -> None:
        """Predict to the time of a scene and drop robots unseen for too long."""
        before, self._now_ns = self._now_ns, stamp_ns
        if before is None:
            return
        self.table.predict(max((stamp_ns - before) * 1e-9, 0.0))
        self._drop(self.table.ended(stamp_ns))

    def _blame(self, found: Found) -> None:
        """Let the filter allow for a drone's fault.

        Where drones contradicted each other, it begins anew: what it believes may come from the
        fault.
        """
        wrong = self._drones[found.drone]
        wrong.fault = found.fault
        for one in self._drones:
            one.agreement = Agreement()
        if found.trial is None:
            return
        columns = found.fault.columns
        wrong.assumed[columns] = found.trial.errors[columns]
        self.table.restart(found.drone, found.trial)
        self._matching = RobotMatching(self._drones)
        self._references.reset()

    def _drop(self, slots: list[int]) -> None:
        if slots:
            self.table.drop(slots)
            self._matching.dropped(slots)

    def _measure(self, drone: int, seen: Sighting, view: CameraView) -> None:
        """Update robots with a drone's boxes; begin those that it has not named before."""
        table = self.table
        known = recognise(table.robots, drone, seen)
        if known.slots:
            self._update(drone, seen, view, known.slots)
        for k, slot in known.slots.items():
            table.robots[slot].note_track(drone, seen.tracks[k], seen.labels[k])
        if known.new:
            table.begin(drone, seen, view, known.new)
        gone = [old for old, new in known.again if table.resume(drone, old, new)]
        table.settle()
        self._drop(gone)

    def _update(self, drone: int, seen: Sighting, view: CameraView, slots: dict[int, int]) -> None:
        """Update robots with their boxes.

        Args:
            drone: its number.
            seen: its sighting.
            view: the camera.
            slots: of the robots, by box; without those whose boxes are another robot's from now on.
        """
        one, stamp_ns, table = self._drones[drone], seen.pose.stamp_ns, self.table
        fits = fitting(table.state, seen, view, one.model, slots)
        speed = table.motions.default_speed
        used = usable(table.state.joint, table.robots, fits, slots, speed, self._threshold)
        squared, count = 0.0, 0
        if used:
            outcome = table.correct(drone, seen, view, {k: slots[k] for k in used})
            squared, count = outcome.squared, outcome.count
        robots = [table.robots[slots[k]] for k in slots]
        shared = [self._matching.others_see(drone, robot, stamp_ns) for robot in robots]
        refused = 0
        for k, robot, common in zip([*slots], robots, shared, strict=True):
            if k in used:
                robot.measured(drone, stamp_ns, seen.doubt[k])
                continue
            refused += common
            robot.refused[drone] = robot.refused.get(drone, 0) + 1
            if robot.refused[drone] >= TUNING.released:
                robot.release(drone)
                del slots[k]
        if any(shared):
            one.agreement.add(squared, count, refused, sum(shared))


def refuse_unable(name: str, config: EstimatorConfig) -> None:
    """Refuse a drone whose configuration asks for what a fleet cannot do yet.

    Raises:
        ConfigError: names the parameter.
    """
    trouble = ""
    if config.noise.value("latency_s") > 0.0:
        trouble = "noise.latency_s must be 0: measure the latency with `aerial-gnss calibrate`"
    elif config.robots:
        trouble = "robots must be empty: names are not bound to places"
    elif config.method != "filter":
        trouble = f"method must be filter, not {config.method}"
    if trouble:
        raise ConfigError(f"several drones together, drone {name}: {trouble}.")
