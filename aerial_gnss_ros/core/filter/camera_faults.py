# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's poses, effects of a wrong one on robots, and their evidence on it.

Either robots have moved or the camera has turned: until that is decided (`AttitudeAmbiguity`),
covariances contain the possible rotation. A jump of orientation or height while no robot is in view
remains in the covariances of all robots until it is reversed, or fades as other errors do. A jump
of the receiver moves camera and robots alike, and their covariances contain it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.formation import Formation, formation
from aerial_gnss_ros.core.faults.gnss_jump import nobody
from aerial_gnss_ros.core.faults.rotation_fault import RobotsInView
from aerial_gnss_ros.core.faults.rotation_test import fit_rotation
from aerial_gnss_ros.core.filter.alternative_laws import AlternativeLaws
from aerial_gnss_ros.core.filter.blocks import StateBlocks
from aerial_gnss_ros.core.filter.camera_trajectory import CameraTrajectory
from aerial_gnss_ros.core.filter.linearization import by_angles, by_errors, relinearize
from aerial_gnss_ros.core.filter.restarts import Restarts
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.models.measurement_model import level_axes
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.motion_model import ClassMotions
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, HEIGHT, LATENCY, PlatformModel
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]


class CameraFaults(StateBlocks):
    """Robots in rows 0 to n - 1, seen by one camera that may be wrong.

    Args:
        config: noise, motion and the gimbal's reference.
        log: receives warnings.

    Attributes:
        log: likewise.
        model: of the platform's errors.
        motions: motion models by class.
        motion: model of classes without their own parameters.
        trajectory: poses of the camera.
        laws: beside the joint states.
        restarts: lets robots begin anew, as while the latency is unknown.
        orientation_jumped: whether the camera's orientation has jumped with the last image, and not
            back.
        jumped: whether orientation or height have jumped with the last image.
    """

    def __init__(self, config: EstimatorConfig, log: Events) -> None:
        self.log = log
        self.model = PlatformModel(config.noise, config.gimbal.reference)
        self.motions = ClassMotions(config)
        self.motion = self.motions.default
        self.trajectory = CameraTrajectory(config.camera.latency_s, log)
        self.laws = AlternativeLaws(self.model, config.tracks.find_moored)
        self.restarts = Restarts(self.laws)
        self.reset()

    def reset(self) -> None:
        """Forget robots and camera."""
        self._wider: Array = np.ones(COUNT)
        self._stationary = self.model.stationary(None)
        self.clear(self._stationary)
        self._fresh = True
        self.orientation_jumped = self.jumped = False
        self._climbed = 0.0
        self.trajectory.reset()
        self.laws.reset()
        self.restarts.reset(float(self._stationary[LATENCY, LATENCY]))

    @property
    def stationary(self) -> Array:
        """(9, 9) covariance of the platform's errors when nothing is known."""
        return self._stationary

    def update_camera(self, frame: PosedFrame, robots_tell: Callable[[], bool] = nobody) -> None:
        """Take in the pose of an image.

        Args:
            frame: the image.
            robots_tell: tests by robots, on copies of the previous filter, whether its position has
                jumped (see `GnssJumpDetector`).
        """
        variance = self._stationary.item
        stated = math.sqrt(max(variance(0, 0), variance(0, 1), variance(1, 0), variance(1, 1)))
        jump = self.trajectory.follow_position(frame, stated, robots_tell)
        self._stationary = self._wider * self.model.stationary(frame.pose.fix_covariance)
        if self._fresh:
            self.clear(self._stationary)
            self._fresh = False
        if frame.latency is not None:
            self._settle(*frame.latency)
        self.ambiguity.shifted(self.trajectory.jumps.doubt)
        if jump is not None:
            self._follow_jump(jump)
        unsure = frame.latency[1] if self.restarts.late and frame.latency is not None else 0.0
        self.trajectory.look(frame, unsure)
        self._look_for_jumps()

    def _follow_jump(self, jump: Array) -> None:
        """Follow an accepted jump (3,) of the position, m."""
        for group in self._groups:
            group.shift(jump[:2])
        self.laws.shift(jump[:2])
        self.ambiguity.keep_jump()
        self._spread_doubt()

    def _settle(self, latency_s: float, sigma: float) -> None:
        """Take over the latency's estimate."""
        for group in self._groups:
            group.settle(LATENCY, latency_s, sigma)
        if self.laws.moored is not None:
            self.laws.moored.settle(LATENCY, latency_s, sigma)
        self.restarts.note_latency(sigma)

    def speeds(self, rows: Indices | list[int]) -> Array | float:
        """Return one sigma of robots' unknown velocities, each axis, m/s: (n,), or one for all."""
        if self.motions.alike:
            return self.motions.default_speed
        speeds = np.empty(self._count)
        for group in self._groups:
            speeds[group.rows] = group.motion(self.motion).speed_sigma
        chosen: Array = speeds[rows]
        return chosen

    def turned_by(self, rows: Indices, offsets: Array, variances: Array) -> float:
        """Return the log odds of one camera rotation against independent manoeuvres, nats.

        Args:
            rows: (m,) of the robots.
            offsets: (m, 2) of their boxes from predicted positions, m.
            variances: (m,) of that, each axis, m².
        """
        group_of, slot_of = self._places_of_rows()
        moved = [
            by_angles(self._groups[group_of[row]], slot_of[row : row + 1]) for row in rows.tolist()
        ]
        swerve = MOTION_MODEL.swerve_s * self.speeds(rows)
        return fit_rotation(offsets, variances, np.concatenate(moved), swerve)[2]

    def update_ambiguity(self, seconds: float, over: bool = False) -> None:
        """Update the ambiguity with the time for which boxes have fitted no robot.

        Either the camera has turned, or it had turned before and is right again: so robots not in
        these images become as uncertain as those initialised from them.
        """
        self.ambiguity.update(0.0 if self.restarts.late else seconds, over)
        self._spread_doubt()

    def formation(
        self, old: list[int], new: list[int], more: Array, possible: NDArray[np.bool_]
    ) -> Formation | None:
        """Return which robots `old` are which robots `new`, by relative positions.

        Args:
            old: n rows.
            new: m rows.
            more: (2, 2) additional covariance of their positions, m².
            possible: (n, m) whether one can be the other at all.
        """
        offsets, spread = self.separations(np.array(old), np.array(new))
        group_of, slot_of = self._places_of_rows()
        moved = []
        for row in old:
            group = self._groups[group_of[row]]
            relinearize(group, self.trajectory.seen_from)
            moved.append(by_errors(group, slot_of[row : row + 1]))
        by_platform = np.concatenate(moved)
        height = float(self.trajectory.seen_from.measured.position[2])
        return formation(
            offsets, spread + more, by_platform[:, :, ANGLES],
            height * by_platform[:, :, HEIGHT], possible,
        )  # fmt: skip

    def note_displacement(self, turn: Array, spread: Array, squared: float) -> None:
        """Record the rotation that displaces all robots (see `AttitudeAmbiguity`)."""
        if not self.restarts.late:
            self.ambiguity.note_displacement(turn, spread, squared)
        self._spread_doubt()

    def note_return(self) -> None:
        """Record that all robots are back at their positions before the displacement."""
        self.log.add("Robots are back at their positions before all of them seemed to move.")
        self.ambiguity.note_return()
        self._spread_doubt()

    def note_jump(self, unseen: bool) -> None:
        """Record that orientation or height has jumped with the last image.

        Args:
            unseen: whether it shows no robot that would tell. Then robots out of view, and those
                initialised later, may be wrong by the jump.
        """
        if self.orientation_jumped and unseen:
            self.ambiguity.keep_jump(unseen=True)
        if self.trajectory.motion.height_jump and (unseen or self._climbed):
            self._climbed += self.trajectory.motion.height_jump
            stated = float(self._stationary[HEIGHT, HEIGHT])
            matters = self._climbed**2 > SURE_SIGMAS**2 * stated
            by_height = self._farthest_by_height() if matters else 0.0
            self.ambiguity.climbed(self._climbed**2 * by_height)
        self._spread_doubt()

    def _farthest_by_height(self) -> float:
        """Return the greatest squared displacement of a robot by an error of the height of 1 m."""
        farthest = 0.0
        for group in self._groups:
            relinearize(group, self.trajectory.seen_from)
            moved = by_errors(group, np.arange(len(group.by_pose)))[:, :, HEIGHT]
            farthest = max(farthest, float(np.sum(moved**2, axis=1).max(initial=0.0)))
        return farthest

    def _spread_doubt(self) -> None:
        """Inflate the covariances of all robots by the attitude ambiguity."""
        if not self.ambiguity.active or self.trajectory.view is None:
            return
        for group in self._groups:
            relinearize(group, self.trajectory.view)
            known = np.arange(len(group.by_pose))  # except robots initialised from this image
            moved = by_angles(group, known)
            self.rotation_fault.spread(group.velocity_changes, known, moved, seen=False)

    def _look_for_jumps(self) -> None:
        """Note whether orientation or height have jumped with the last image."""
        self.orientation_jumped = self._has_jumped()
        self.jumped = self.orientation_jumped or bool(self.trajectory.motion.height_jump)

    def _has_jumped(self) -> bool:
        """Return whether the camera's orientation has jumped, and not back."""
        jump, passed = self.trajectory.motion.jump, self.trajectory.passed
        if jump is None:
            return False
        axes = level_axes(self.trajectory.seen_from.measured.rotation)
        if self.ambiguity.update_jump(axes.T @ jump, passed):
            self.log.add("The camera's orientation is back where it was before it jumped.")
            return False
        self.log.counts["orientation_jumps"] += 1
        self.log.add(
            f"The camera's orientation jumped by {math.degrees(math.sqrt(jump @ jump)):.0f} deg "
            f"within {passed:.2g} s: robots that are not detected where they were may be wrong by "
            "as much, as their covariances state."
        )
        return True

    def _in_view(self, group: JointState, slots: Indices) -> RobotsInView:
        """Return what robots in view tell of a camera that rotates."""
        unknown = group.covariance.diagonal()[COUNT:].reshape(-1, 4)[slots, 2:].sum(axis=1)
        fastest = group.motion(self.motion, slots).fastest
        moved = by_angles(group, slots)
        return RobotsInView(group.velocity_changes, slots, moved, unknown, fastest)
