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

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.blocks import TUNING as BLOCKS
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.plausible_state import check_covariance, check_robots
from aerial_gnss_ros.core.fleet.agreement import Agreement, DroneReport, receiver_offset
from aerial_gnss_ros.core.fleet.clocks import TUNING as CLOCKS
from aerial_gnss_ros.core.fleet.clocks import clock_offset
from aerial_gnss_ros.core.fleet.common_share import CommonShare
from aerial_gnss_ros.core.fleet.constellations import TUNING as CONSTELLATIONS
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fault_search import FaultSearch, Found
from aerial_gnss_ros.core.fleet.fleet_references import FleetReferences, staying_references
from aerial_gnss_ros.core.fleet.gates import TUNING as GATES
from aerial_gnss_ros.core.fleet.gates import fitting, usable
from aerial_gnss_ros.core.fleet.matching import RobotMatching
from aerial_gnss_ros.core.fleet.publication import displaced, measured, published
from aerial_gnss_ros.core.fleet.robots import FleetRobot, Names, recognise
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.fleet.staying import StayingRobots
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import ClassMotions
from aerial_gnss_ros.core.models.platform_model import COUNT, named_errors
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold
from aerial_gnss_ros.core.telemetry.depths import inflate_by_depth
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import PlatformError, RobotEstimate

Array = NDArray[np.float64]
_NAMES = {"latency": "clock"}
"""What is in an error's place (see `clocks`)."""


@dataclass(frozen=True)
class FleetTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    released: int = 10
    """Consecutive boxes of a drone that contradict a robot after which they are another robot's.
    Judged."""


TUNING = FleetTuning()


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


class Fleet:
    """Robots of several drones.

    Args:
        configs: of each drone's estimator, by the drone's name.
        local: the frame `map`.
        share: prior share of the receivers' variance that is common, 0 to 1.

    Attributes:
        local: likewise.
        robots: in the order of `state.joint`.
        state: the filter.
        staying: weighs whether robots stay; None: that is not asked.

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
        self._config = next(iter(configs.values()))
        self._drones = [
            Drone(name, config, CLOCKS.sigma_s if k else 0.0)
            for k, (name, config) in enumerate(configs.items())
        ]
        self._number = {name: i for i, name in enumerate(configs)}
        self._motions = ClassMotions(self._config)
        self._threshold = gate_threshold(self._config.tracks.gate_probability)
        self._share = share
        self.state = SharedState(self._stationary, share)
        self._find_staying = all(one.tracks.find_moored for one in configs.values())
        self.staying: StayingRobots | None = None
        self.robots: list[FleetRobot] = []
        self._matching = RobotMatching(self._drones)
        self._faults = FaultSearch(self._drones, self._motions.default_speed)
        self._references = FleetReferences(
            self._drones, staying_references(self._drones), self.state, CommonShare(share)
        )
        self._absent: list[FleetRobot] = []
        self._names = Names()
        self._now_ns: int | None = None

    def follow(self, former: Fleet) -> None:
        """Go on with the names of a fleet of which this one is made again, with all its drones."""
        numbers = {k: self._number[one.name] for k, one in enumerate(former._drones)
                   if one.name in self._number}  # fmt: skip
        names = {
            (numbers[drone], label): robot.name
            for robot in former.robots
            if robot.name
            for drone, label in robot.labels.items()
            if drone in numbers
        }
        self._names.follow(former._names.taken, names)

    @property
    def _stationary(self) -> list[Array]:
        return [one.stationary for one in self._drones]

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
        view = self._look(drone, seen)
        self._measure(drone, seen, view)
        pairs = self._matching.update(self.state, self.robots, stamp_ns)
        for first, second in pairs:
            self._tie(first, second, CONSTELLATIONS.same_m)
        self._drop([first for first, _ in pairs])
        found = self._faults.update(self.state, self.robots, stamp_ns)
        if found is not None:
            self._blame(found)
        for slot, robot in enumerate(self.robots):
            waits = robot.labels and not robot.name
            if waits and self._matching.nobody_else(slot, self.robots, stamp_ns):
                robot.name = self._names.issue(robot)
        self._references.update(self.robots, drone, seen, self.state, self.local)
        check_covariance(self.state.joint.covariance, "robots and platform")
        check_robots(self.state.joint.robots, "robots")
        estimates, platform = self._positions(seen) if publish else ((), ())
        return self._result(drone, seen, estimates, platform)

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
        return self._published(seen)[0]

    def _predict(self, stamp_ns: int) -> None:
        """Predict to the time of a scene and drop robots unseen for too long."""
        before, self._now_ns = self._now_ns, stamp_ns
        if before is None:
            return
        seconds = max((stamp_ns - before) * 1e-9, 0.0)
        keep = [one.model.decay(seconds) for one in self._drones]
        if self.staying is not None:
            self.staying.predict(seconds, keep, self._stationary, self._motions.default)
        self.state.predict(seconds, keep, self._stationary, self._motions.default)
        present = self._present(self.robots, stamp_ns)
        self._drop([slot for slot, here in enumerate(present) if not here])

    def _present(self, robots: list[FleetRobot], now_ns: int) -> list[bool]:
        """Return which robots are still predicted without a box."""
        first_s = self._config.tracks.confirm_window_s
        coast_s = {
            one: self._config.robot_class(one).coast_s for one in {r.class_id for r in robots}
        }
        return [
            (now_ns - one.last_seen_ns) * 1e-9
            <= (first_s if one.tentative else coast_s[one.class_id])
            for one in robots
        ]

    def _blame(self, found: Found) -> None:
        """Let the filter allow for a drone's fault.

        Where drones contradicted each other, it begins anew: what it believes may come from the
        fault. Robots keep their names, and those on which drones agree under the fault are one.
        """
        wrong = self._drones[found.drone]
        wrong.fault = found.fault
        for one in self._drones:
            one.agreement = Agreement()
        if found.trial is None:
            return
        columns = found.fault.columns
        wrong.assumed[columns] = found.trial.errors[columns]
        for robot in self.robots:
            robot.release(found.drone)
            robot.note_rival(None, 0)
            robot.refused.clear()
        for label, other, of_other in found.trial.matched:
            for robot in self.robots:
                if robot.labels.get(other) == of_other and found.drone not in robot.labels:
                    robot.labels[found.drone] = label
                    break
        self._absent += [robot for robot in self.robots if robot.labels]
        self.robots, self._matching = [], RobotMatching(self._drones)
        self._references.reset()

    def _drop(self, slots: list[int]) -> None:
        if not slots:
            return
        self.state.drop(np.array(sorted(slots), np.intp))
        self.robots = [robot for slot, robot in enumerate(self.robots) if slot not in slots]
        self.state.joint.rows = np.arange(len(self.robots))
        self._matching.dropped(slots)

    def _look(self, drone: int, seen: Sighting) -> CameraView:
        """Take in the pose of an image."""
        one = self._drones[drone]
        one.state_receiver(seen)
        if not self.robots:
            self.state = SharedState(self._stationary, self._share)
            for number, each in enumerate(self._drones):
                if each.fault is not None:
                    self.state.assume(number, each.assumed)
            self.staying = StayingRobots(self.state) if self._find_staying else None
        elif one.last is None or one.jumped(seen):
            self.state.forget_gnss(drone, self._stationary)
            if self.staying is not None:
                self.staying.reset()
        view = one.look(seen, self.local)
        self.state.look(drone, view)
        if self.staying is not None:
            self.staying.look(drone, view)
        return view

    def _measure(self, drone: int, seen: Sighting, view: CameraView) -> None:
        """Update robots with a drone's boxes; begin those that it has not named before."""
        known = recognise(self.robots, drone, seen)
        if known.slots:
            self._update(drone, seen, view, known.slots)
        for k, slot in known.slots.items():
            self.robots[slot].note_track(drone, seen.tracks[k], seen.labels[k])
        if known.new:
            self._begin(drone, seen, view, known.new)
        gone = [old for old, new in known.again if self._is_back(drone, old, new)]
        self.state.settle()
        if self.staying is not None:
            self.staying.settle()
        self._drop(gone)

    def _tie(self, first: int, second: int, sigma: float) -> None:
        """Condition on two robots having the same position."""
        self.state.tie(first, second, sigma)
        if self.staying is not None:
            self.staying.tie(first, second, sigma)

    def _is_back(self, drone: int, old: int, new: int) -> bool:
        """Make a robot that has come back to a drone one with its new track, if that fits.

        Otherwise the drone's label is a robot's of its own, as after boxes that contradict one.

        Args:
            drone: its number.
            old: place of the robot.
            new: of the tentative one.
        """
        joint, speed = self.state.joint, self._motions.default_speed
        if self.robots[old].last_seen_ns < self.robots[new].began_ns:
            joint.inflate_velocities(np.array([old]), speed, MOTION_MODEL.swerve_s)
        if self.state.apart(old, new, BLOCKS.same_place_m) > GATES.gate:
            self.robots[old].release(drone)
            return False
        self._tie(old, new, BLOCKS.same_place_m)
        self.robots[new].join(self.robots[old])
        return True

    def _update(self, drone: int, seen: Sighting, view: CameraView, slots: dict[int, int]) -> None:
        """Update robots with their boxes.

        Args:
            drone: its number.
            seen: its sighting.
            view: the camera.
            slots: places of the robots by box.
        """
        one, stamp_ns = self._drones[drone], seen.pose.stamp_ns
        fits = fitting(self.state, seen, view, one.model, slots)
        used = usable(
            self.state.joint, self.robots, drone, fits, slots, self._motions.default_speed,
            self._threshold,
        )  # fmt: skip
        squared, count = 0.0, 0
        if used:
            outcome = self.state.correct(
                np.array([slots[k] for k in used], np.intp), seen.pixels[used], view, one.model,
                2.0 * self._motions.default_speed, seen.level,
            )  # fmt: skip
            squared, count = outcome.squared, outcome.count
            self.state.doubt_platforms([each.stationary for each in self._drones])
            if self.staying is not None:
                box_of = {slots[k]: k for k in used}
                boxes = [box_of[slot] for slot in outcome.slots.tolist()]
                self.staying.update(outcome, seen.pixels[boxes], view, one.model, seen.level)
        robots = [self.robots[slots[k]] for k in slots]
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

    def _begin(self, drone: int, seen: Sighting, view: CameraView, new: list[int]) -> None:
        """Begin robots from boxes."""
        rows = np.arange(len(self.robots), len(self.robots) + len(new))
        own = self._motions.of([seen.class_ids[k] for k in new])
        model, speed = self._drones[drone].model, self._motions.default_speed
        self.state.begin(rows, seen.pixels[new], view, model, speed, own, seen.level)
        stamp_ns = seen.pose.stamp_ns
        for k in new:
            robot = self._absent_robot(drone, seen.labels[k], stamp_ns)
            robot = robot or FleetRobot(seen.class_ids[k], stamp_ns, stamp_ns)
            robot.note_track(drone, seen.tracks[k], seen.labels[k])
            robot.measured(drone, stamp_ns, seen.doubt[k])
            self.robots.append(robot)

    def _absent_robot(self, drone: int, label: str, now_ns: int) -> FleetRobot | None:
        """Return the robot of a drone's label that the filter has begun anew without."""
        present = self._present(self._absent, now_ns)
        self._absent = [one for one, here in zip(self._absent, present, strict=True) if here]
        for robot in self._absent:
            if label and robot.labels.get(drone) == label:
                self._absent.remove(robot)
                return robot
        return None

    def _published(self, seen: Sighting) -> tuple[tuple[RobotEstimate, ...], Array, Array]:
        """Return the robots at the time of a sighting, all drones' errors and their covariance."""
        joint = self.state.joint
        mean, blocks = joint.robots.copy(), joint.blocks()
        told = self._references.apply(self.robots, mean, blocks, self.state, seen.pose.stamp_ns)
        if self.staying is not None and self.staying.law is not None:
            # Images of drones that take turns are no misses.
            shown = [measured(robot, self._drones, seen.pose.stamp_ns) for robot in self.robots]
            unseen = np.where(shown, 0.0, joint.unseen)
            self.staying.publish(mean, blocks, self._references.published, unseen)
        estimates = published(mean, blocks, self.robots, self._drones, seen, self.local)
        depth_m = self._config.depth.sigma_m
        found = inflate_by_depth(tuple(estimates), seen.pose, self.local, depth_m)
        return found, *told

    def _positions(
        self, seen: Sighting
    ) -> tuple[tuple[RobotEstimate, ...], tuple[PlatformError, ...]]:
        """Return robots and all drones' errors as published at the time of a sighting."""
        estimates, errors, spread = self._published(seen)
        several = len(self._drones) > 1
        platform = list[PlatformError]()
        for number, each in enumerate(self._drones):
            own = slice(COUNT * number, COUNT * number + COUNT)
            platform += [
                replace(error, name=f"{each.name} {_NAMES.get(error.name, error.name)}")
                if several
                else error
                for error in named_errors(errors[own], spread[own, own])
            ]
        return estimates, tuple(platform)

    def _result(
        self, drone: int, seen: Sighting, estimates: tuple[RobotEstimate, ...],
        platform: tuple[PlatformError, ...],
    ) -> FleetUpdate:  # fmt: skip
        """Return what is published, and what is to be said of the drone."""
        one, now_ns = self._drones[drone], seen.pose.stamp_ns
        known = [robot for robot in self.robots if robot.name and drone in robot.labels]
        offset, sigma = receiver_offset(self.state, drone, len(self._drones))
        report = DroneReport(
            one.name, seen.stamp_ns, one.agreement.ratio,
            sum(len(robot.labels) > 1 for robot in known), offset, sigma,
            one.fault is not None
            or one.suspected
            or one.agreement.disagrees
            or displaced(self.robots, drone, now_ns) > 0.0,
            one.fault.sensor if one.fault is not None else "",
            clock_offset(self.state, drone, len(self._drones)),
        )  # fmt: skip
        return FleetUpdate(
            estimates,
            platform,
            report,
            {robot.labels[drone]: robot.name for robot in known},
            tuple(self._references.log.drain()),
        )


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
