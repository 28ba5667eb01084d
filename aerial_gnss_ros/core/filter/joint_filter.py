# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The joint filter of platform errors and robots: its interface to the tracker, by row."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.faults.gnss_jump import GnssJumpDetector, nobody
from aerial_gnss_ros.core.faults.noise_level import NoiseLevel
from aerial_gnss_ros.core.faults.rotation_fault import RobotsInView
from aerial_gnss_ros.core.filter.camera_faults import CameraFaults
from aerial_gnss_ros.core.filter.correlation_times import CorrelationTimes
from aerial_gnss_ros.core.filter.innovation import (
    PairInnovations,
    joint_covariance,
    pair_innovations,
)
from aerial_gnss_ros.core.filter.linearization import (
    CameraView,
    by_angles,
    by_platform,
    relinearize,
)
from aerial_gnss_ros.core.filter.moored_mixture import MooredMixture
from aerial_gnss_ros.core.filter.recalibration import (
    CalibrationChange,
    recalibrate,
    reinitialize,
)
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.update import Outcome, correct, linearise
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.camera_motion import TUNING as CAMERA_MOTION
from aerial_gnss_ros.core.models.camera_motion import CameraMotion
from aerial_gnss_ros.core.models.motion_model import ClassMotions
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, LATENCY, PlatformModel
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.text.sentences import counted

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointFilterTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    sure_s: float = 0.1
    """An unknown latency counts as known once its sigma is at most this, s. Judged."""
    unsure_s: float = 0.2
    """A known latency counts as unknown once its sigma is above this, s. Judged."""
    feigned_mps: float = 2.0
    """Apparent speed of a robot that a wrong latency can cause, one sigma, m/s. Judged."""


TUNING = JointFilterTuning()


_NO_ROWS: Indices = np.zeros(0, np.intp)


class JointFilter(CameraFaults):
    """Joint filter of robots in rows 0 to n - 1 and the platform's errors.

    Args:
        config: noise, motion and the gimbal's reference.
        log: receives warnings.

    Attributes:
        moored: weighs whether robots that seem to stay do; None: it is not asked for.
        monitor: consistency of innovations with the stated noise.
        jumps: detector of GNSS jumps.
        noise: ratio of actual to stated white noise.
        times: weighs for how long the platform's slow errors last.
        jumped: whether orientation or height have jumped with the last image.
    """

    def __init__(self, config: EstimatorConfig, log: Events | None = None) -> None:
        self.log = log or Events()
        self.monitor = InnovationMonitor()
        self.model = PlatformModel(config.noise, config.gimbal.reference)
        self.motions = ClassMotions(config)
        self.motion = self.motions.default
        self._latency_ns = round(config.camera.latency_s * 1e9)
        self.moored = MooredMixture() if config.tracks.find_moored else None
        self.noise = NoiseLevel()
        self.times = CorrelationTimes(self.model)
        self.jumps = GnssJumpDetector(self.log)
        self.reset()

    def reset(self) -> None:
        """Reset robots and platform."""
        self._wider: Array = np.ones(COUNT)
        self._stationary = self.model.stationary(None)
        self.clear(self._stationary)
        self._fresh = True
        if self.moored is not None:
            self.moored.reset()
        self._late = self._stationary[LATENCY, LATENCY] > TUNING.sure_s**2
        self._found = False
        self._refusing = False
        self._pose_ns: int | None = None
        self._motion = CameraMotion()
        self._recalibrated = self._anew = False
        self.jumps.reset()
        self._sight: CameraView | None = None
        self.orientation_jumped = self.jumped = False
        self._climbed = 0.0
        self.monitor.reset()
        self.noise.reset()
        self.times.reset()

    @property
    def stationary(self) -> Array:
        """(7, 7) covariance of the platform's errors when nothing is known."""
        return self._stationary

    def predict(self, seconds: float) -> None:
        """Predict to a later time."""
        if not self._late:
            self.times.predict(self._groups[0], seconds, self._stationary, self.motion)
        if self.moored is not None:
            keep = self.model.decay(seconds)
            self.moored.predict(self._groups, seconds, keep, self._stationary, self.motion)
        self.predict_with(self._groups, seconds)
        if self.ambiguity.episodes and seconds > 0.0:
            keep = self.model.decay(seconds)
            self.ambiguity.predict(seconds, float(keep[ANGLES.start]))

    def update_camera(self, frame: PosedFrame, robots_tell: Callable[[], bool] = nobody) -> bool:
        """Take in the pose of an image; return whether its boxes can be used.

        Args:
            frame: the image.
            robots_tell: tests by robots, on copies of the previous filter, whether its position has
                jumped (see `GnssJumpDetector`).
        """
        pose, measured = frame.pose, frame.in_map
        passed = 0.0 if self._pose_ns is None else (pose.stamp_ns - self._pose_ns) * 1e-9
        expected = None if self._recalibrated else self._motion.predicted_position(passed)
        variance = self._stationary.item
        stated = math.sqrt(max(variance(0, 0), variance(0, 1), variance(1, 0), variance(1, 1)))
        settled, jump = self.jumps.update(measured.position, expected, passed, stated, robots_tell)
        known = pose.fix_covariance
        self._stationary = self._wider * self.model.stationary(known)
        if self._fresh:
            self.clear(self._stationary)
            self._fresh = False
        if frame.latency is not None:
            self._settle(*frame.latency)
        self._pose_ns = pose.stamp_ns
        if jump is not None:
            self._follow_jump(jump)
        shown = MapPose(measured.position - self.jumps.offset, measured.rotation)
        applied = (frame.detections.stamp_ns - pose.stamp_ns - self._latency_ns) * 1e-9
        elsewhen = self._recalibrated or (
            self._sight is not None and abs(applied - self._sight.applied) > CAMERA_MOTION.moved_s
        )
        self._recalibrated = False
        foretold = self._motion.restart(shown) if elsewhen else self._motion.update(shown, passed)
        self.orientation_jumped = self._motion.jump is not None and self._jumped(shown, passed)
        self.jumped = self.orientation_jumped or bool(self._motion.height_jump)
        unsure = frame.latency[1] if self._late and frame.latency is not None else 0.0
        self._sight = CameraView.of(
            frame.camera,
            shown,
            self._motion.rates,
            applied,
            foretold,
            unsure,
            pose.interpolation_noise(passed),
        )
        return settled

    def _follow_jump(self, jump: Array) -> None:
        """Follow an accepted jump (3,) of the position, m."""
        self._motion.shift(jump)
        self.times.restart()
        if self.moored is not None:
            self.moored.reset()
        for group in self._groups:
            group.shift(jump[:2])
        away = self.jumps.believed
        self.ambiguity.shifted(float(away @ away))
        self.ambiguity.keep_jump()
        self._spread_doubt()

    def reconfigure(self, config: EstimatorConfig, class_ids: Sequence[str]) -> None:
        """Use the motion models of another configuration from now on.

        Args:
            config: of which only `classes` may differ.
            class_ids: class of the robot in each row.
        """
        self.motions = ClassMotions(config)
        self.motion = self.motions.default
        own = self.motions.of(class_ids)
        for group in self._groups:
            unlike = np.full((2, len(group)), np.nan)
            group.own = unlike if own is None else own[:, group.rows]
        if self.moored is not None:
            self.moored.reconfigure()

    def recalibrate(
        self, change: CalibrationChange, also: Sequence[JointState], searched: bool
    ) -> None:
        """Continue with another calibration (see `recalibration`).

        Args:
            change: of the calibration.
            also: other joint states of the same camera.
            searched: whether the latency is estimated by `LatencySearch`.
        """
        self.times.restart()
        later_ns = round(float(change.errors[LATENCY]) * 1e9)
        self._latency_ns += later_ns
        if self._pose_ns is not None and not searched:
            self._pose_ns -= later_ns
        if self._sight is None:
            return
        if self.moored is not None:
            self.moored.recalibrate(change, self._stationary, self._sight)
        for group in (*self._groups, *also):
            recalibrate(group, change, self._stationary, self._sight, searched)
        if not change.modelled(self._stationary):
            self._anew = True
        self._recalibrated = True

    def _settle(self, latency_s: float, sigma: float) -> None:
        """Take over the latency's estimate."""
        for group in self._groups:
            group.settle(LATENCY, latency_s, sigma)
        if self.moored is not None:
            self.moored.settle(LATENCY, latency_s, sigma)
        before, self._late = self._late, sigma > (TUNING.sure_s if self._late else TUNING.unsure_s)
        self._found = not self._late and (before or self._found)

    def compare(
        self,
        seen: Measurements,
        scale: float,
        floor: float,
        groups: list[JointState] | None = None,
    ) -> PairInnovations:
        """Return the innovations of the pairs of robots and detections that are close.

        Detections are placed with the estimated platform errors; the covariances account for errors
        common to robot and detection.

        Args:
            seen: the image's detections.
            scale: of the covariance's trace, and
            floor: m², of the squared distance up to which a pair is returned.
            groups: other joint states to use; None: the filter's own.
        """
        view, found = self._sight, []
        assert view is not None  # noqa: S101 - `update_camera` came first
        rays = view.rays(seen.points)
        for group in self._groups if groups is None else groups:
            if len(group.rows):
                places, by_errors = relinearize(group, view, rays)
                found.append(pair_innovations(group, places, by_errors, seen.white, scale, floor))
        return found[0] if len(found) == 1 else PairInnovations.of_groups(found)

    def compare_jointly(self, seen: Measurements, pairs: PairInnovations) -> Array | None:
        """Return the covariance (2 k, 2 k) of some pairs together, see `joint_covariance`.

        Args:
            seen: the image's detections.
            pairs: k of those that `compare` has returned.

        Returns:
            None where their robots are in several blocks.
        """
        group_of, slot_of = self._places_of_rows()
        groups = set(group_of[pairs.rows].tolist())
        if len(groups) != 1:
            return None
        group, columns = self._groups[groups.pop()], pairs.columns
        moved = by_platform(group, pairs.offsets + group.robots[slot_of[pairs.rows], :2])
        own = self.box_noise(seen.positions)[columns]
        return joint_covariance(group, slot_of[pairs.rows], moved, seen.white[columns], own)

    def predict_with(self, groups: list[JointState], seconds: float) -> None:
        """Predict other joint states of the same camera."""
        if seconds <= 0.0:
            return
        keep = self.model.decay(seconds)
        groups[0].rotation_fault.predict(seconds, float(keep[ANGLES.start]))
        for group in groups:
            group.predict(seconds, keep, self._stationary, self.motion)

    def correct(self, seen: Measurements, rows: Indices, columns: Indices) -> Indices:
        """Update robots `rows` with detections `columns`; return the rows that were refused.

        Refused are detections that imply a speed above `tracks.max_speed`.
        """
        if not len(rows) or self._sight is None:
            return _NO_ROWS
        self._discount(self.noise.take_underestimated())
        refused = [_NO_ROWS]
        column_of = np.empty(self._count, np.intp)
        column_of.fill(-1)
        column_of[rows] = columns
        squared, count = 0.0, 0
        judged: list[RobotsInView] = []
        for group in self._groups:
            (slots,) = (column_of[group.rows] >= 0).nonzero()
            if len(slots):
                pixels = seen.pixels[column_of[group.rows[slots]]]
                self._forget(group, slots)
                outcome = correct(
                    group,
                    slots,
                    pixels,
                    self._sight,
                    self.model,
                    2.0 * self.motions.default_speed,
                    self.noise.level,
                )
                if not self._late:
                    used = pixels[np.searchsorted(slots, outcome.slots)]
                    self._weigh(group, outcome, used)
                group.doubt_platform(group.manoeuvre_noise.take_underestimated(), self._stationary)
                if group is self._groups[0]:
                    self.times.doubt_platform(self._stationary)
                squared, count = squared + outcome.squared, count + outcome.count
                if not self._late and self.rotation_fault.due:
                    judged.append(self._in_view(group, slots))
                refused.append(group.rows[outcome.refused])
        self._found = self._anew = False
        if judged:
            self.rotation_fault.judge(judged, self.noise.unknown)
        if not self._late:
            errors, turned = self._groups[0].mean[:COUNT], self.rotation_fault.sigma
            for sentence in self.monitor.update_image(
                squared, count, self.noise.level, turned, errors, self._stationary
            ):
                self.log.add(sentence)
        gone = refused[-1] if len(refused) <= 2 else np.concatenate(refused)
        if len(gone) or self._refusing:
            self._report_refused(len(gone))
        return gone

    def _forget(self, group: JointState, slots: Indices) -> None:
        """Let robots begin anew where the latency or another calibration demands it.

        Args:
            group: the joint state.
            slots: of robots that the image shows.
        """
        if self._late or self._found:
            if self.moored is not None:
                self.moored.reset()
            self.times.restart()
            relinearize(group, self._seen_from())
            # Otherwise robots seem too fast.
            feigned = TUNING.feigned_mps if self._late else 0.0
            speeds = group.motion(self.motion, slots).speed_sigma
            group.forget(slots, self._stationary, speeds + feigned)
        if self._anew:
            self.times.restart()
            relinearize(group, self._seen_from())
            speeds = group.motion(self.motion, slots).speed_sigma
            reinitialize(group, slots, self._stationary, speeds)

    def _weigh(self, group: JointState, outcome: Outcome, pixels: Array) -> None:
        """Let the hypotheses beside a group take in an image that it has taken in.

        Args:
            group: the joint state.
            outcome: how well the image fitted it.
            pixels: (m, 2) of the boxes that were used.
        """
        sight, level = self._sight, self.noise.level
        assert sight is not None  # noqa: S101 - the group has taken in an image of it
        if self.moored is not None:
            self.moored.update(group, outcome, pixels, sight, self.model, level)
        if group is self._groups[0] and self.times.update(outcome, pixels, sight, level):
            self.monitor.quick_s = self.times.unstated_s
            if self.moored is not None:
                self.moored.reset()

    def inflate_velocities(self, rows: Indices, speed: Array | float, seconds: float) -> None:
        """Inflate velocity covariances of robots, see `StateBlocks`."""
        super().inflate_velocities(rows, speed, seconds)
        if self.times.runs:
            speeds = np.full(self._count, np.nan)
            speeds[rows] = speed
            speeds = speeds[self._groups[0].rows]
            slots = np.flatnonzero(~np.isnan(speeds))
            self.times.inflate_velocities(slots, speeds[slots], seconds)

    def _discount(self, factor: float) -> None:
        """Let what boxes have told so far count less; the laws beside begin anew.

        Args:
            factor: of the variance of their noise, at least 1.
        """
        if factor <= 1.0:
            return
        if self.moored is not None:
            self.moored.reset()
        self.times.restart()
        before, self._wider = self._wider, np.ones(COUNT)
        self._wider[ANGLES] = self.noise.of_slow_errors
        wider = self._wider / before
        for group in self._groups:
            relinearize(group, self._seen_from())
            speeds = group.motion(self.motion).speed_sigma
            group.discount(factor, self._stationary, speeds, wider)
            group.manoeuvre_noise.forget()
            group.velocity_changes.discount(factor)
        self._stationary = wider * self._stationary

    def _in_view(self, group: JointState, slots: Indices) -> RobotsInView:
        unknown = group.covariance.diagonal()[COUNT:].reshape(-1, 4)[slots, 2:].sum(axis=1)
        fastest = group.motion(self.motion, slots).fastest
        moved = by_angles(group, slots)
        return RobotsInView(group.velocity_changes, slots, moved, unknown, fastest)

    def _report_refused(self, refused: int) -> None:
        if refused and not self._refusing:
            self.log.add(
                f"Boxes imply that {counted(refused, 'robot')} exceeded {self.motions.words} and "
                "are not used: the compass, the gimbal or camera.latency_s may be wrong."
            )
        self._refusing = bool(refused)

    def begin(self, seen: Measurements, columns: Indices) -> None:
        """Add a robot for each of the detections `columns`, in rows after the present ones."""
        if not len(columns):
            return
        view, white, speed = self._seen_from(), seen.white, self.motions.default_speed
        rays = view.rays(seen.points)
        for group, rows, taken in self.allocate(np.asarray(columns, np.intp)):
            places, by_errors = relinearize(group, view, rays[taken])
            own = self.motions.of(seen.class_ids[taken].tolist())
            group.add(rows, places, by_errors, white[taken], speed, own)

    def box_noise(self, places: Array) -> Array:
        """Return covariances (m, 2, 2) of positions that boxes' own noise causes, m²."""
        by_pixel = np.linalg.inv(linearise(self._seen_from(), np.zeros(COUNT), places).by_place)
        noise: Array = self.noise.level * self.model.pixel * by_pixel @ by_pixel.swapaxes(1, 2)
        return noise
