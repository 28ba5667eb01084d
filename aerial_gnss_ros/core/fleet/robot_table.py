# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fleet's robots: a record of each, and its state in the filter; both use the same slots.

The filter has two laws, which take in the same images: in one all robots swim (`SharedState`), in
the other some stay (`StayingRobots`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.blocks import TUNING as BLOCKS
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fault_trial import Trial
from aerial_gnss_ros.core.fleet.gates import TUNING as GATES
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.fleet.staying import StayingRobots
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import ClassMotions

Array = NDArray[np.float64]


class RobotTable:
    """Robots by slot.

    Args:
        drones: of the fleet, by number.
        configs: of their estimators; robots move and end as that of the first one states.
        share: prior share of the receivers' variance that is common, 0 to 1.

    Attributes:
        robots: the records, in the order of `state.joint`.
        state: the law in which all swim.
        staying: weighs whether robots stay; None: that is not asked.
        motions: motion models by class.
    """

    def __init__(
        self, drones: list[Drone], configs: Sequence[EstimatorConfig], share: float
    ) -> None:
        self._drones, self._config, self._share = drones, configs[0], share
        self._find_staying = all(one.tracks.find_moored for one in configs)
        self.motions = ClassMotions(self._config)
        self.state = SharedState(self._stationary, share)
        self.staying: StayingRobots | None = None
        self.robots: list[FleetRobot] = []
        self._absent: list[FleetRobot] = []

    @property
    def _stationary(self) -> list[Array]:
        return [one.stationary for one in self._drones]

    def predict(self, seconds: float) -> None:
        """Predict to a later time."""
        keep = [one.decay(seconds) for one in self._drones]
        if self.staying is not None:
            self.staying.predict(seconds, keep, self._stationary, self.motions.default)
        self.state.predict(seconds, keep, self._stationary, self.motions.default)

    def ended(self, now_ns: int) -> list[int]:
        """Return the slots of robots unseen for too long."""
        present = self._present(self.robots, now_ns)
        return [slot for slot, here in enumerate(present) if not here]

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

    def drop(self, slots: list[int]) -> None:
        """Remove robots; later ones move up."""
        self.state.drop(np.array(sorted(slots), np.intp))
        self.robots = [robot for slot, robot in enumerate(self.robots) if slot not in slots]
        self.state.joint.rows = np.arange(len(self.robots))

    def look(self, drone: int, seen: Sighting, local: LocalMap) -> CameraView:
        """Take in the pose of a drone's image; without robots, the filter begins anew.

        Args:
            drone: its number.
            seen: the image.
            local: the frame `map`.
        """
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
        view = one.look(seen, local)
        self.state.look(drone, view)
        if self.staying is not None:
            self.staying.look(drone, view)
        return view

    def correct(
        self, drone: int, seen: Sighting, view: CameraView, slots: dict[int, int]
    ) -> Outcome:
        """Update robots with their boxes, after `look`; return how well the image fits.

        What no drone has confirmed as a robot is evidence of no camera (see `JointFilter.correct`).

        Args:
            drone: number of the image's drone.
            seen: the image.
            view: its camera.
            slots: of the robots, by box.
        """
        tentative = {k: slot for k, slot in slots.items() if self.robots[slot].tentative}
        slots = {k: slot for k, slot in slots.items() if k not in tentative}
        model, outcome = self._drones[drone].model, self._correct(drone, seen, view, slots)
        self.state.doubt_platforms(self._stationary)
        if self.staying is not None and slots:
            box_of = {slot: box for box, slot in slots.items()}
            boxes = [box_of[slot] for slot in outcome.slots.tolist()]
            self.staying.update(outcome, seen.pixels[boxes], view, model, seen.level)
        if tentative:
            self._correct(drone, seen, view, tentative, alone=True)
        return outcome

    def _correct(
        self, drone: int, seen: Sighting, view: CameraView, slots: dict[int, int],
        alone: bool = False,
    ) -> Outcome:  # fmt: skip
        return self.state.correct(
            np.array([*slots.values()], np.intp), seen.pixels[[*slots]], view,
            self._drones[drone].model, 2.0 * self.motions.default_speed, seen.level, alone,
        )  # fmt: skip

    def begin(self, drone: int, seen: Sighting, view: CameraView, new: list[int]) -> None:
        """Begin robots from boxes, after `look`.

        Args:
            drone: number of the image's drone.
            seen: the image.
            view: its camera.
            new: the boxes.
        """
        rows = np.arange(len(self.robots), len(self.robots) + len(new))
        own = self.motions.of([seen.class_ids[k] for k in new])
        model, speed = self._drones[drone].model, self.motions.default_speed
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

    def resume(self, drone: int, old: int, new: int) -> bool:
        """Make a robot that has come back to a drone one with its new track, if that fits.

        Otherwise the drone's label is a robot's of its own, as after boxes that contradict one.

        Args:
            drone: its number.
            old: slot of the robot, which is to be dropped if that fits.
            new: of the tentative one.
        """
        if self.robots[old].last_seen_ns < self.robots[new].began_ns:
            self.state.joint.inflate_velocities(
                np.array([old]), self.motions.default_speed, MOTION_MODEL.swerve_s
            )
        if self.state.apart(old, new, BLOCKS.same_place_m) > GATES.gate:
            self.robots[old].release(drone)
            return False
        self.tie(old, new, BLOCKS.same_place_m)
        self.robots[new].join(self.robots[old])
        return True

    def tie(self, first: int, second: int, sigma: float) -> None:
        """Condition on two robots having the same position, but for one sigma, m."""
        self.state.tie(first, second, sigma)
        if self.staying is not None:
            self.staying.tie(first, second, sigma)

    def settle(self) -> None:
        """Bring the robots back to the fleet's time, after the updates of an image."""
        self.state.settle()
        if self.staying is not None:
            self.staying.settle()

    def restart(self, drone: int, trial: Trial) -> None:
        """Let the filter begin anew with the next image: a drone was wrong.

        Robots keep their names, and those on which drones agree under the fault are one.

        Args:
            drone: number of the drone.
            trial: under which the drones agree.
        """
        for robot in self.robots:
            robot.release(drone)
            robot.note_rival(None, 0)
            robot.refused.clear()
        for label, other, of_other in trial.matched:
            for robot in self.robots:
                if robot.labels.get(other) == of_other and drone not in robot.labels:
                    robot.labels[drone] = label
                    break
        self._absent += [robot for robot in self.robots if robot.labels]
        self.robots = []
