# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From telemetry at one time to the camera's pose over the water, or a typed refusal."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, matrix_from_rpy
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.core.geometry.gimbal import Reference, enu_from_camera, mount_matrix
from aerial_gnss_ros.core.geometry.magnetic import declination, true_from_magnetic
from aerial_gnss_ros.core.numerics.small_arrays import all_finite
from aerial_gnss_ros.core.telemetry.corrections import corrected_camera
from aerial_gnss_ros.core.telemetry.scene import SceneTelemetry
from aerial_gnss_ros.core.telemetry.vertical_datum import ellipsoidal_altitude
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix

Array = NDArray[np.float64]
Axes = tuple[int, ...]


class PoseBuilder:
    """Composes the camera's pose as configured.

    Attributes:
        trouble: why the last pose was refused, a sentence; empty if the reason suffices.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        self._config = config
        self._mount = mount_matrix(config.gimbal.mount_rpy_deg)
        self._offset = np.array(config.camera.offset_m, dtype=np.float64)
        self._limits = config.limits
        self._apart = bool(self._offset.any())  # camera and antenna
        calibration = config.calibration
        self._lift = calibration.height_m
        angles = calibration.gimbal_roll_deg, calibration.gimbal_pitch_deg, calibration.heading_deg
        self._turn = np.radians(angles)
        self._turned = bool(self._turn.any())
        self.trouble = ""

    def pose(self, samples: SceneTelemetry) -> CameraPose | Reason:
        """Return the camera's pose.

        Args:
            samples: at the time of the scene.
        """
        self.trouble = ""
        if not samples.fix.valid:
            return Reason.BAD_FIX
        config, body, gimbal = self._config, None, None
        if samples.attitude is not None:
            magnetic = config.attitude.north != "true"
            body = self._orientation(samples.attitude.quaternion, magnetic, samples)
            if body is None:
                return Reason.BAD_ATTITUDE
        reference: str = config.gimbal.reference
        if samples.gimbal is not None:
            reference = samples.gimbal.reference or reference  # a message may state it itself
            magnetic = config.gimbal.north != "true" and reference == "earth"
            gimbal = self._orientation(samples.gimbal.quaternion, magnetic, samples)
            if gimbal is None:
                return Reason.BAD_GIMBAL
        height = self.height(samples, body)
        if isinstance(height, Reason):
            return height
        return self._assemble(samples, height + self._lift, body, gimbal, reference)

    def height(self, samples: SceneTelemetry, body: Array | None) -> float | Reason:
        """Return the antenna's height above the water in m (DESIGN, Altitude)."""
        if samples.height is None:
            height = samples.fix.altitude - self._config.surface.altitude
            if math.isfinite(height):
                return height
            self.trouble = (
                "The fix's altitude is NaN, but height.source none computes the height from it; "
                "give the height on a topic, or as height.value_m."
            )
            return Reason.BAD_FIX
        height = samples.height
        if self._config.height.along == "body" and body is not None:
            height *= float(body[2, 2])
        height -= samples.water_level
        return height if math.isfinite(height) else Reason.BAD_HEIGHT

    def altitude(self, fix: Fix) -> float:
        """Return the antenna's altitude above the ellipsoid in m, NaN if unknown."""
        return ellipsoidal_altitude(fix, self._config.fix)

    def _orientation(
        self, quaternion: Array, magnetic: bool, samples: SceneTelemetry
    ) -> Array | None:
        """Return the orientation of a quaternion (4,) in true ENU, (3, 3); None if unusable.

        Args:
            quaternion: x, y, z, w.
            magnetic: whether it is relative to magnetic north.
            samples: with position and time.
        """
        matrix = matrix_from_quaternion(quaternion)
        if not math.isfinite(sum(matrix.ravel().tolist())):  # one part that is not is enough
            return None
        return self._true_north(matrix, samples) if magnetic else matrix

    def _true_north(self, from_magnetic: Array, samples: SceneTelemetry) -> Array | None:
        """Return (3, 3) turned from magnetic to true north; None, with `trouble`, without model."""
        fix = samples.fix
        try:
            east_of_north = declination(
                fix.latitude, fix.longitude, samples.stamp_ns, self.altitude(fix)
            )
        except InputError as error:
            self.trouble = str(error)
            return None
        return true_from_magnetic(from_magnetic, east_of_north)

    def _assemble(
        self,
        samples: SceneTelemetry,
        height: float,
        body: Array | None,
        gimbal: Array | None,
        reference: str,
    ) -> CameraPose | Reason:
        variances, gaps_s = self._interpolated(samples, reference)
        fix, altitude = samples.fix, ellipsoidal_altitude(samples.fix, self._config.fix)
        latitude, longitude = fix.latitude, fix.longitude
        if body is not None and self._apart:
            east, north, up = self._true_body(body) @ self._offset
            base = altitude if math.isfinite(altitude) else height
            lat, lon, _ = geodetic_from_enu(east, north, up, latitude, longitude, base)
            latitude, longitude = float(lat), float(lon)
            height, altitude = height + float(up), altitude + float(up)
        if not self._limits.height_min_m < height <= self._limits.height_max_m:
            self.trouble = (
                f"A camera {height:.1f} m above the water cannot see robots, so its images are "
                "refused (bad_height); limits.height_min_m and height_max_m bound its height, "
                "water_level is the level of the water above the height's reference."
            )
            return Reason.BAD_HEIGHT
        camera = enu_from_camera(reference, gimbal, body, self._mount)
        return CameraPose(
            stamp_ns=samples.stamp_ns,
            latitude=latitude,
            longitude=longitude,
            height=height,
            altitude=altitude,
            enu_from_camera=corrected_camera(camera, self._turn) if self._turned else camera,
            fix_covariance=None if fix.covariance is None else _horizontal(fix.covariance),
            oldest_age_s=samples.oldest_age_s,
            interpolation=variances,
            gaps_s=gaps_s,
        )

    def _interpolated(self, samples: SceneTelemetry, reference: str) -> tuple[Array, Array]:
        """Return the variances (6,) of a pose by interpolation, and the gaps (6,), s."""
        variances, gaps_s = [0.0] * 6, [0.0] * 6
        for source, kind, axes in _sources(reference, samples.height is None):
            one = samples.uncertain.get(source)
            if one is None:
                continue
            for axis in axes:
                variances[axis] += one.variance[kind]
                gaps_s[axis] = max(gaps_s[axis], one.gap_s)
        return np.array(variances), np.array(gaps_s)

    def _true_body(self, body: Array) -> Array:
        if not self._turn[2]:
            return body
        turned: Array = matrix_from_rpy(0.0, 0.0, self._turn[2]) @ body
        return turned


@lru_cache(maxsize=8)
def _sources(reference: str, height_of_fix: bool) -> tuple[tuple[Input, int, Axes], ...]:
    """Return what a pose is interpolated from: input, kind of its variance, axes of the pose."""
    found: list[tuple[Input, int, Axes]] = [(Input.FIX, 0, (0, 1))]
    found.append((Input.FIX if height_of_fix else Input.HEIGHT, 0, (2,)))
    if reference != Reference.FIXED:
        found += [(Input.GIMBAL, 0, (3, 4)), (Input.GIMBAL, 1, (5,))]
    if reference != Reference.EARTH:
        found.append((Input.ATTITUDE, 1, (5,)))
    if reference not in (Reference.EARTH, Reference.HEADING):
        found.append((Input.ATTITUDE, 0, (3, 4)))
    return tuple(found)


def _horizontal(reported: Array) -> Array | None:
    """Return the East, North part (2, 2) of a fix's covariance; None if unusable."""
    plane = np.asarray(reported, dtype=np.float64)[:2, :2]
    (east, shared), (_, north) = plane.tolist()
    good = all_finite(plane) and east > 0.0 and north > 0.0 and shared * shared < east * north
    return plane if good else None
