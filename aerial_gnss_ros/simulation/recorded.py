# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Uses a recorded DJI flight as the true motion of a simulation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.adapters.dji_log import DjiLog
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, slerp
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.simulation.flight import HOLETOWN, Motion

Array = NDArray[np.float64]

LONGEST_GAP_S = 2.0
"""Rows farther apart are not interpolated, s: the motion in between is unknown."""


class RecordedFlight:
    """A part of a DJI log, interpolated: positions linearly, orientations by slerp.

    The camera is at the GNSS antenna, as the log has no lever arm. Beyond the log's ends the drone
    stands still, so that telemetry can begin a little before the images.
    """

    def __init__(
        self,
        log: DjiLog,
        start_s: float = 0.0,
        duration_s: float | None = None,
        water_altitude_m: float = HOLETOWN.altitude,
    ) -> None:
        """Cut out the piece.

        Args:
            log: the recording.
            start_s: start of the piece, s since the log's first row.
            duration_s: its length, s; None: to the log's end.
            water_altitude_m: altitude of the water above the ellipsoid (not in the log).

        Raises:
            InputError: the piece is not in the log, or has gaps.
        """
        if not (len(log.gimbal) and len(log.attitude) and len(log.height)):
            raise InputError(
                f"{log.path} lacks height, attitude or gimbal angles; a flight record as CSV "
                "has them."
            )
        log = _above_water(log)
        self._log = log
        seconds: Array = np.asarray(log.stamps_ns * 1e-9)
        end = float(seconds[-1])
        if not 0.0 <= start_s < end:
            raise InputError(f"{log.path} is {end:.1f} s long and has no row at {start_s:g} s.")
        length = end - start_s if duration_s is None else duration_s
        if not length > 0.0:
            raise InputError(f"a flight must last longer than 0 s, not {length:g} s.")
        if start_s + length > end + 1e-6:
            raise InputError(
                f"{log.path} ends at {end:.1f} s, before {start_s:g} + {length:g} s; start "
                "earlier or give a shorter duration."
            )
        self._start, self._duration = start_s, length
        self._seconds = seconds - start_s
        self._refuse_gaps(seconds, start_s, start_s + length)
        first = int(np.searchsorted(seconds, start_s, side="right")) - 1
        self._origin = MapDatum(
            float(log.latitude[first]), float(log.longitude[first]), water_altitude_m
        )
        enu = enu_from_geodetic(
            log.latitude, log.longitude, 0.0, self._origin.latitude, self._origin.longitude, 0.0
        )
        self._positions = np.column_stack([enu[:, :2], log.height])

    @property
    def origin(self) -> MapDatum:
        """Position at the start of the piece."""
        return self._origin

    @property
    def duration_s(self) -> float:
        """Length of the piece, s."""
        return self._duration

    @property
    def words(self) -> str:
        """What the flight is, in words."""
        inside = (self._seconds >= 0.0) & (self._seconds <= self._duration)
        height = self._positions[inside, 2]
        return (
            f"recorded flight {self._log.path.name}, {self._start:g} to "
            f"{self._start + self._duration:g} s, {height.min():.1f} to {height.max():.1f} m above "
            "the water"
        )

    def sample(self, t: ArrayLike) -> Motion:
        """Return the recorded motion at times (n,) in s since the piece's start."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        clamped = np.clip(times, self._seconds[0], self._seconds[-1])
        right = np.clip(np.searchsorted(self._seconds, clamped), 1, len(self._seconds) - 1)
        before, after = self._seconds[right - 1], self._seconds[right]
        share = (clamped - before) / (after - before)
        weight = share[:, None]
        position = (1.0 - weight) * self._positions[right - 1] + weight * self._positions[right]
        body, gimbal = (
            matrix_from_quaternion(slerp(values[right - 1], values[right], share))
            for values in (self._log.attitude, self._log.gimbal)
        )
        return Motion(times, position, position, body, gimbal)

    def _refuse_gaps(self, seconds: Array, start: float, end: float) -> None:
        gaps = np.diff(seconds)
        inside = (seconds[1:] > start) & (seconds[:-1] < end) & (gaps > LONGEST_GAP_S)
        if inside.any():
            at = float(seconds[:-1][inside][0])
            raise InputError(
                f"{self._log.path} has no usable rows for {float(gaps[inside][0]):.1f} s after "
                f"{at:.1f} s; choose another --start."
            )


def _above_water(log: DjiLog) -> DjiLog:
    """Return the rows at or above the take-off point, which is on the simulated water.

    Raises:
        InputError: no such rows.
    """
    rows = log.height >= 0.0
    if np.count_nonzero(rows) < 2:
        raise InputError(
            f"{log.path} never rises above its take-off point, which is on the water here; use "
            "another log."
        )
    return log if rows.all() else log.chosen(rows)


def water_seconds(
    log: DjiLog, duration_s: float, steepest_rad: float = math.radians(12.0)
) -> Array:
    """Return the starts (n,) in s of all pieces in which the camera sees water throughout.

    Args:
        log: the recording.
        duration_s: length of a piece, s.
        steepest_rad: least angle of the optical axis below the horizon, rad.
    """
    if not (len(log.gimbal) and len(log.height)):
        return np.zeros(0)
    down = -matrix_from_quaternion(log.gimbal)[:, 2, 0]
    bad = (down < math.sin(steepest_rad)) | (log.height < 1.0)
    seconds: Array = np.asarray(log.stamps_ns * 1e-9)
    bad[1:] |= np.diff(seconds) > LONGEST_GAP_S
    spoiled = np.concatenate([[0], np.cumsum(bad)])
    starts = np.arange(len(seconds))
    ends = np.searchsorted(seconds, seconds + duration_s, side="right")
    good = (seconds + duration_s <= seconds[-1]) & (spoiled[ends] - spoiled[starts] == 0)
    return np.asarray(seconds[good], dtype=np.float64)
