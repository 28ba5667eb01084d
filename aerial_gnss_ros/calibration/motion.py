# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's motion from telemetry: smooth in time, each input from its own samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from aerial_gnss_ros.calibration.pose_errors import ERRORS
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.smoothing import PiecewiseSpline
from aerial_gnss_ros.calibration.telemetry_smoother import TelemetrySmoother
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.values.rejection import Input

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

MOST_SAMPLES = 4000


@dataclass(frozen=True)
class Poses:
    """Camera poses in `map` at n times.

    Attributes:
        position: (n, 3) East, North, Up, m.
        rotation: (n, 3, 3) camera FLU in `map`.
        velocity: (n, 3) m/s.
        turning: (n, 3) about East, North, Up, rad/s.
        known: (n,) False without telemetry; values are meaningless then.
    """

    position: Array
    rotation: Array
    velocity: Array
    turning: Array
    known: NDArray[np.bool_]


class Motion:
    """The camera's poses at any time, for any delay of fixes against orientations.

    Args:
        recording: after the replay.

    Attributes:
        start_ns: time 0 of the splines.
        samples_s: times of the samples of the slowest input, from time 0.
        sample_s: median time between two of them.
        smoothing_s: time over which motion is smoothed, by the names of ERRORS.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        config, stamps = recording.config, recording.stamps
        known = [t for values in stamps.values() for t in (values[:1] + values[-1:])]
        self.start_ns = min(known, default=0)
        turning = _most(stamps, Input.GIMBAL, Input.ATTITUDE)
        level, rising = stamps[Input.FIX], stamps[Input.HEIGHT] or stamps[Input.FIX]
        anything = turning or level or rising or self._mast()
        smoother = TelemetrySmoother(config.noise, config.gimbal.reference)
        gap = config.fix.max_gap
        self._level = self._smooth(
            level or anything, gap, lambda p: p.position[:2], True, smoother.level
        )
        height_gap = config.height.max_gap if stamps[Input.HEIGHT] else gap
        self._height = self._smooth(
            rising or anything, height_gap, lambda p: p.position[2:], True, smoother.height
        )
        turn_gap = config.gimbal.max_gap if stamps[Input.GIMBAL] else config.attitude.max_gap
        self._turn = self._smooth(
            turning or anything, turn_gap, lambda p: quaternion_from_matrix(p.rotation), False,
            smoother.turn,
        )  # fmt: skip
        self._lever = self._levers(turning or anything, turn_gap, smoother)
        level_s, turn_s = max(smoother.times_s["level"]), smoother.times_s["turn"]
        times_s = (level_s, level_s, max(smoother.times_s["height"]), *turn_s)
        self.smoothing_s = dict(zip(ERRORS, times_s, strict=True))
        self._errors = smoother
        tables = [np.unique(np.array(s, dtype=np.int64)) for s in (turning, level) if len(s) > 1]
        slowest = max(tables, key=_spacing, default=np.zeros(1, dtype=np.int64))
        self.samples_s: Array = (slowest - self.start_ns).astype(np.float64) * 1e-9
        self.sample_s = _spacing(slowest) * 1e-9

    def at(self, stamps_ns: Stamps, latency_s: float, fix_delay_s: float) -> Poses:
        """Return poses (n,) of the scenes of images.

        Args:
            stamps_ns: of the images.
            latency_s: time from the scene to the stamp.
            fix_delay_s: time from the validity of fixes and heights to their stamps.
        """
        t: Array = np.asarray((stamps_ns - self.start_ns) * 1e-9 - latency_s, dtype=np.float64)
        level, level_rate, known = self._level.at(t + fix_delay_s)
        height, height_rate, high = self._height.at(t + fix_delay_s)
        quaternion, rate, turned = self._turn.at(t)
        length = np.linalg.norm(quaternion, axis=1)
        known &= high & turned & (length > 0.5)
        quaternion[~known] = 0.0, 0.0, 0.0, 1.0
        length[~known] = 1.0
        quaternion, rate = quaternion / length[:, None], rate / length[:, None]
        position, velocity = np.hstack([level, height]), np.hstack([level_rate, height_rate])
        if self._lever is not None:
            lever, lever_rate, _ = self._lever.at(t)
            position, velocity = position + lever, velocity + lever_rate
        rotation = matrix_from_quaternion(quaternion)
        return Poses(position, rotation, velocity, _turning(quaternion, rate), known)

    def interpolation(self, stamps_ns: Stamps, latency_s: float, ranges_m: Array) -> Array:
        """Return one sigma (n, 3) of the errors of interpolated poses, rad about the error axes.

        Args:
            stamps_ns: (n,) of the images.
            latency_s: time from the scene to the stamp.
            ranges_m: (n,) distances, which convert position errors to directions.
        """
        t: Array = np.asarray((stamps_ns - self.start_ns) * 1e-9 - latency_s, dtype=np.float64)
        moved = self._errors.place_error.variance(t).mean(axis=1) / np.square(ranges_m)
        return np.asarray(np.sqrt(self._errors.turn_error.variance(t) + moved[:, None]))

    def _mast(self) -> list[int]:
        """Return times for a camera whose pose is constant."""
        frames = sorted(self._recording.frames)
        if not frames:
            return []
        return list(range(frames[0] - 4_000_000_000, frames[-1] + 4_000_000_000, 500_000_000))

    def _smooth(
        self,
        stamps: list[int],
        gap_s: float,
        value: Callable[[MapPose], Array],
        antenna: bool,
        smoothed: Callable[[Array, Array], BSpline],
    ) -> PiecewiseSpline:
        times, values = [], []
        for stamp in _thinned(stamps):
            pose = self._recording.pose(stamp, antenna)
            if pose is not None:
                times.append((stamp - self.start_ns) * 1e-9)
                values.append(value(pose))
        table = np.array(values) if values else np.zeros((0, 4))
        spread = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
        return PiecewiseSpline(np.array(times), table, max(gap_s, 1.5 * spread), smoothed)

    def _levers(
        self, stamps: list[int], gap_s: float, smoother: TelemetrySmoother
    ) -> PiecewiseSpline | None:
        if not any(self._recording.config.camera.offset_m):
            return None
        times, values = [], []
        for stamp in _thinned(stamps):
            camera, antenna = self._recording.pose(stamp), self._recording.pose(stamp, True)
            if camera is not None and antenna is not None:
                times.append((stamp - self.start_ns) * 1e-9)
                values.append(camera.position - antenna.position)
        table = np.array(values).reshape(-1, 3)
        return PiecewiseSpline(np.array(times), table, gap_s, smoother.lever)


def _most(stamps: dict[Input, list[int]], *sources: Input) -> list[int]:
    return max((stamps[source] for source in sources), key=len)


def _spacing(stamps: Stamps) -> float:
    return float(np.median(np.diff(stamps))) if len(stamps) > 1 else 1e9


def _thinned(stamps: list[int]) -> list[int]:
    unique = sorted(set(stamps))
    return unique[:: 1 + len(unique) // MOST_SAMPLES]


def _turning(quaternion: Array, rate: Array) -> Array:
    """Return (n, 3) rad/s in the world of quaternions x, y, z, w and their rates.

    The component along the quaternion, which only changes its length, cancels.
    """
    vector, scalar = quaternion[:, :3], quaternion[:, 3:]
    found: Array = 2.0 * (
        scalar * rate[:, :3] - rate[:, 3:] * vector - np.cross(rate[:, :3], vector)
    )
    return found
