# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The joint filter of platform errors and robots: its interface to the tracker, by row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.faults.noise_level import NoiseLevel
from aerial_gnss_ros.core.faults.rotation_fault import RobotsInView
from aerial_gnss_ros.core.filter.blocks import TUNING as BLOCKS
from aerial_gnss_ros.core.filter.camera_faults import CameraFaults
from aerial_gnss_ros.core.filter.innovation import (
    PairInnovations,
    joint_covariance,
    pair_innovations,
)
from aerial_gnss_ros.core.filter.linearization import CameraView, by_platform, relinearize
from aerial_gnss_ros.core.filter.outcome import Outcome
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.recalibration import CalibrationChange, recalibrate
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.filter.update import correct
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.models.motion_model import ClassMotions
from aerial_gnss_ros.core.models.platform_model import ANGLES, COUNT, LATENCY, at_azimuth
from aerial_gnss_ros.core.values.events import Events

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_NO_ROWS: Indices = np.zeros(0, np.intp)

_TOO_FAST = (
    "Boxes imply that a robot exceeded {} and are not used: the compass, the gimbal or "
    "camera.latency_s may be wrong."
)


class JointFilter(CameraFaults):
    """Joint filter of robots in rows 0 to n - 1 and the platform's errors.

    Args:
        config: noise, motion and the gimbal's reference.
        log: receives warnings.

    Attributes:
        monitor: consistency of innovations with the stated noise.
        noise: ratio of actual to stated white noise.
    """

    def __init__(self, config: EstimatorConfig, log: Events | None = None) -> None:
        self.monitor = InnovationMonitor()
        self.noise = NoiseLevel()
        super().__init__(config, log or Events())

    def reset(self) -> None:
        """Reset robots and platform."""
        super().reset()
        self.monitor.reset()
        self.noise.reset()

    def predict(self, seconds: float) -> None:
        """Predict to a later time."""
        late = self.restarts.late
        self.laws.predict(self._groups, seconds, self._stationary, self.motion, late)
        self.predict_with(self._groups, seconds)
        if self.ambiguity.episodes and seconds > 0.0:
            keep = self.model.decay(seconds)
            self.ambiguity.predict(seconds, float(keep[ANGLES.start]))

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
        if self.laws.moored is not None:
            self.laws.moored.reconfigure()

    def recalibrate(
        self, change: CalibrationChange, also: Sequence[JointState], searched: bool
    ) -> None:
        """Continue with another calibration (see `recalibration`).

        Args:
            change: of the calibration.
            also: other joint states of the same camera.
            searched: whether the latency is estimated by `LatencySearch`.
        """
        self.laws.times.restart()
        self.trajectory.delay(float(change.errors[LATENCY]), searched)
        view = self.trajectory.view
        if view is None:
            return
        if self.laws.moored is not None:
            self.laws.moored.recalibrate(change, self._stationary, view)
        for group in (*self._groups, *also):
            recalibrate(group, change, self._stationary, view, searched)
        if not change.modelled(self._stationary):
            self.restarts.note_recalibration()
        self.trajectory.note_recalibration()

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
        view, found = self.trajectory.seen_from, []
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
        """Predict other joint states of the same camera, as `predict` does."""
        if seconds <= 0.0:
            return
        keep = self.model.decay(seconds)
        groups[0].rotation_fault.predict(seconds, float(keep[ANGLES.start]))
        for group in groups:
            group.predict(seconds, keep, self._stationary, self.motion)

    def correct(
        self, seen: Measurements, rows: Indices, columns: Indices, robots: Mask | None = None
    ) -> Indices:
        """Update robots `rows` with detections `columns`; return the rows that were refused.

        Refused are detections that imply a speed above `tracks.max_speed`.

        Args:
            seen: the image's detections.
            rows: (m,) of the tracks.
            columns: (m,) their detections.
            robots: (m,) which tracks are robots. Others may be anything, a part of the drone that
                moves along with the camera, too: they are evidence of neither the camera nor the
                noise. None: all.
        """
        view, late = self.trajectory.view, self.restarts.late
        if not len(rows) or view is None:
            return _NO_ROWS
        self._discount(self.noise.take_underestimated())
        refused = [_NO_ROWS]
        column_of = np.empty(self._count, np.intp)
        column_of.fill(-1)
        column_of[rows] = columns
        evident = np.ones(self._count, np.bool_)
        if robots is not None:
            evident[rows] = robots
        squared, count, due = 0.0, 0, not late and self.rotation_fault.due
        judged, tentative = list[RobotsInView](), list[RobotsInView]()
        for group in self._groups:
            (slots,) = (column_of[group.rows] >= 0).nonzero()
            if not len(slots):
                continue
            self.restarts.apply(group, slots, view, self._stationary, self.motion)
            known = evident[group.rows[slots]]
            shown, others = slots[known], slots[~known]
            pixels = seen.pixels[column_of[group.rows]]
            if len(shown):
                outcome = self._update(group, shown, pixels[shown], view)
                squared, count = squared + outcome.squared, count + outcome.count
                if due:
                    judged.append(self._in_view(group, shown))
                refused.append(group.rows[outcome.refused])
                if len(outcome.refused):
                    self.log.warn_once("too fast", _TOO_FAST.format(self.motions.words))
            if len(others):
                outcome = self._correct_alone(group, others, pixels, view)
                refused.append(group.rows[outcome.refused])
                if due:
                    tentative.append(self._in_view(group, others))
        self.restarts.done()
        if due:
            self.rotation_fault.judge(judged, tentative, self.noise.unknown)
        if not late:
            turned, stated = self.rotation_fault.sigma, self.model.stated(self._stationary)
            errors, stated = at_azimuth(self._groups[0].mean[:COUNT], stated, view.axes)
            for sentence in self.monitor.update_image(
                squared, count, self.noise.level, turned, errors, stated
            ):
                self.log.add(sentence)
        return refused[-1] if len(refused) <= 2 else np.concatenate(refused)

    def _update(
        self, group: JointState, slots: Indices, pixels: Array, view: CameraView
    ) -> Outcome:
        """Update a group and the laws beside it; return how well the image fitted it.

        Args:
            group: the joint state.
            slots: (m,) of its robots that the image shows.
            pixels: (m, 2) of their boxes.
            view: the camera.
        """
        level, first = self.noise.level, group is self._groups[0]
        outcome = self._correct(group, slots, pixels, view, False)
        if not self.restarts.late:
            used = pixels[np.searchsorted(slots, outcome.slots)]
            if self.laws.update(group, first, outcome, used, view, level):
                self.monitor.quick_s = self.laws.times.unstated_s
        group.doubt_platform(group.manoeuvre_noise.take_underestimated(), self._stationary)
        if first:
            self.laws.times.doubt_platform(self._stationary)
        return outcome

    def _correct_alone(
        self, group: JointState, slots: Indices, pixels: Array, view: CameraView
    ) -> Outcome:
        """Correct robots (m,) of a group, and of the laws beside it, by boxes (n, 2) alone."""
        outcome = self._correct(group, slots, pixels[slots], view, True)
        if not self.restarts.late:
            first, used = group is self._groups[0], outcome.slots
            self.laws.correct_alone(group, first, used, pixels[used], view, self.noise.level)
        return outcome

    def _correct(
        self, group: JointState, slots: Indices, pixels: Array, view: CameraView, alone: bool
    ) -> Outcome:
        fastest, level = 2.0 * self.motions.default_speed, self.noise.level
        return correct(group, slots, pixels, view, self.model, fastest, level, alone)

    def inflate_velocities(self, rows: Indices, speed: Array | float, seconds: float) -> None:
        """Inflate velocity covariances of robots, see `StateBlocks`."""
        super().inflate_velocities(rows, speed, seconds)
        if self.laws.times.runs:
            speeds = np.full(self._count, np.nan)
            speeds[rows] = speed
            speeds = speeds[self._groups[0].rows]
            slots = np.flatnonzero(~np.isnan(speeds))
            self.laws.times.inflate_velocities(slots, speeds[slots], seconds)

    def _discount(self, factor: float) -> None:
        """Let what boxes have told so far count less; the laws beside begin anew.

        Args:
            factor: of the variance of their noise, at least 1.
        """
        if factor <= 1.0:
            return
        self.laws.restart()
        before, self._wider = self._wider, np.ones(COUNT)
        self._wider[ANGLES.start : LATENCY] = self.noise.of_slow_errors
        wider = self._wider / before
        for group in self._groups:
            relinearize(group, self.trajectory.seen_from)
            speeds = group.motion(self.motion).speed_sigma
            group.discount(factor, self._stationary, speeds, wider)
            group.manoeuvre_noise.forget()
            group.velocity_changes.discount(factor)
        self._stationary = wider * self._stationary

    def _joined(self, group: JointState, first: int, second: int, fits: float) -> None:
        self.laws.join(group, first, second, BLOCKS.same_place_m, fits)

    def begin(self, seen: Measurements, columns: Indices) -> None:
        """Add a robot for each of the detections `columns`, in rows after the present ones."""
        if not len(columns):
            return
        view, white, speed = self.trajectory.seen_from, seen.white, self.motions.default_speed
        rays = view.rays(seen.points)
        for group, rows, taken in self.allocate(np.asarray(columns, np.intp)):
            places, by_errors = relinearize(group, view, rays[taken])
            own = self.motions.of(seen.class_ids[taken].tolist())
            group.add(rows, places, by_errors, white[taken], speed, own)

    def box_noise(self, places: Array) -> Array:
        """Return covariances (m, 2, 2) of positions that boxes' own noise causes, m²."""
        by_pixel = np.linalg.inv(
            linearise(self.trajectory.seen_from, np.zeros(COUNT), places).by_place
        )
        noise: Array = self.noise.level * self.model.pixel * by_pixel @ by_pixel.swapaxes(1, 2)
        return noise
