# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated sensors of the drone: rates, latencies, white noise, slow drift.

Every error is stated in `core.config.noise`; a measured value is the true one plus its error.
Heading is one error: body and earth-referenced camera take their yaw from the same compass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.noise import SETS, Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.geodesy import geodetic_from_enu
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.simulation.chance import Drift, generator
from aerial_gnss_ros.simulation.flight import Flight

Array = NDArray[np.float64]

START_NS = 1_735_689_600_000_000_000
"""Stamp of every simulated flight's start: 2025-01-01T00:00:00Z, so that runs are comparable."""
VERTICAL_FACTOR = 1.5
"""Ratio of vertical to horizontal GNSS errors (a receiver's usual VDOP / HDOP)."""


@dataclass(frozen=True)
class SharedGnss:
    """What the receivers of several drones err by in common: ionosphere, the same satellites.

    Attributes:
        seed: of the common error, the same for all drones.
        share: part of the offset's variance that is common, 0 to 1.
        sigma_m: one sigma of the best receiver's offset, of which it is that part, m: what one
            receiver has removed is not common with the others.
    """

    seed: int
    share: float
    sigma_m: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.share <= 1.0:
            raise ConfigError(
                f"the receivers' common share must lie within 0 to 1, not {self.share:g}."
            )


@dataclass(frozen=True)
class SensorPlan:
    """Rates, latencies and errors.

    Attributes:
        noise: name of the set, `none`, or `consumer`/`rtk` with single values replaced.
        sigmas: one-sigma errors by the names of `core.config.noise.Noise`.
        fix_hz, attitude_hz, gimbal_hz, height_hz: samples a second.
        fix_latency_s, attitude_latency_s, gimbal_latency_s: from a sample's stamp to its arrival;
            harmless, because the stamp is right.
        height_latency_s: the same for height, which has no stamp: the value is this late.
        covariance: whether the fix states its covariance (offset and white noise together).
        shared: what the receiver errs by in common with other drones'; None: nothing.
    """

    noise: str
    sigmas: dict[str, float]
    fix_hz: float = 10.0
    attitude_hz: float = 50.0
    gimbal_hz: float = 50.0
    height_hz: float = 10.0
    fix_latency_s: float = 0.05
    attitude_latency_s: float = 0.01
    gimbal_latency_s: float = 0.02
    height_latency_s: float = 0.02
    covariance: bool = False
    shared: SharedGnss | None = None


def noise_sigmas(noise: Noise | None) -> dict[str, float]:
    """Return every standard deviation by name; None: all zero, a perfect drone."""
    if noise is None:
        return dict.fromkeys(SETS["consumer"], 0.0) | {"correlation_time_s": 300.0}
    return {name: noise.value(name) for name in SETS["consumer"]}


def sensor_plan(noise: str = "consumer", **replaced: float) -> SensorPlan:
    """Return the plan of a named noise set.

    Args:
        noise: `consumer`, `rtk` or `none`.
        replaced: single standard deviations, by the names of `core.config.noise.Noise`.
    """
    sigmas = noise_sigmas(None if noise == "none" else Noise(set=noise))
    return SensorPlan(noise, sigmas | replaced)


@dataclass(frozen=True)
class Ticks:
    """When a sensor samples.

    Attributes:
        stamps_ns: (n,) ns.
        t: (n,) the same in s since the flight's start.
    """

    stamps_ns: NDArray[np.int64]
    t: Array


def ticks(rate_hz: float, start_s: float, end_s: float) -> Ticks:
    """Return whole multiples of a period within a span; time 0 is always one of them."""
    index = np.arange(math.ceil(start_s * rate_hz - 1e-9), math.floor(end_s * rate_hz + 1e-9) + 1)
    offset = np.round(index * (1e9 / rate_hz)).astype(np.int64)
    return Ticks(START_NS + offset, np.asarray(offset * 1e-9))


class Sensors:
    """All telemetry of one flight over a span of time; `true` gives the noise-free truth."""

    def __init__(
        self, flight: Flight, plan: SensorPlan, seed: int, start_s: float, end_s: float
    ) -> None:
        """Draw the slow errors.

        Args:
            flight: the true motion.
            plan: rates, latencies, errors.
            seed: of the errors.
            start_s: first time of telemetry, s since the flight's start.
            end_s: last one.
        """
        self._flight, self.plan, self._seed = flight, plan, seed
        self._span = (start_s, end_s)
        self._drifts = {
            name: self._drift(name, k * self._own_sigma(key), seed) for name, key, k in _SLOW
        }
        self._common: dict[str, Drift] = {}
        if plan.shared is not None:
            sigma = math.sqrt(plan.shared.share) * plan.shared.sigma_m
            self._common = {
                name: self._drift(name, k * sigma, plan.shared.seed)
                for name, key, k in _SLOW
                if key == "gnss_offset_m"
            }

    def fixes(self, true: bool = False) -> Iterator[Fix]:
        """Yield the positions; altitude is above the ellipsoid."""
        at = ticks(self.plan.fix_hz, *self._span)
        antenna = self._flight.sample(at.t).antenna
        covariance = None
        if not true:
            antenna = antenna + self._fix_errors(at.t)
            covariance = self._covariance() if self.plan.covariance else None
        latitude, longitude, altitude = geodetic(self._flight.origin, antenna)
        for i, stamp in enumerate(at.stamps_ns):
            yield Fix(
                int(stamp), float(latitude[i]), float(longitude[i]), float(altitude[i]), covariance
            )

    def attitudes(self, true: bool = False) -> Iterator[Orientation]:
        """Yield the body's orientations, FLU in ENU."""
        at = ticks(self.plan.attitude_hz, *self._span)
        matrices = self._flight.sample(at.t).enu_from_flu
        if not true:
            white = self._white("attitude_white_deg", (len(at.t), 3), "attitude")
            matrices = self._turned(at.t, matrices) @ _rotations(np.radians(white))
        yield from _orientations(at, matrices)

    def gimbals(self, true: bool = False) -> Iterator[Orientation]:
        """Yield the camera's orientations, FLU in ENU (earth-referenced)."""
        at = ticks(self.plan.gimbal_hz, *self._span)
        matrices = self._flight.sample(at.t).enu_from_camera
        if not true:
            white = np.radians(self._white("gimbal_white_deg", (len(at.t), 3), "gimbal"))
            matrices = self._misread(at.t, matrices) @ _rotations(white)
        yield from _orientations(at, matrices)

    def heights(self, true: bool = False) -> Iterator[Scalar]:
        """Yield the heights above the water; the stamp is the time of validity."""
        at = ticks(self.plan.height_hz, *self._span)
        height = self._flight.sample(at.t).antenna[:, 2]
        if not true:
            white = self._white("height_white_m", (len(at.t), 1), "height")[:, 0]
            height = height + self.error("height", at.t) + white
        for stamp, value in zip(at.stamps_ns, height, strict=True):
            yield Scalar(int(stamp), float(value))

    def error(self, name: str, t: Array) -> Array:
        """Return a slow error (n,) at times (n,): m, or deg for angles.

        Args:
            name: gnss_east, gnss_north, gnss_up, heading, gimbal_pitch, gimbal_roll or height.
            t: s since the flight's start.
        """
        own = self._drifts[name](t)
        return own + self._common[name](t) if name in self._common else own

    def _drift(self, name: str, sigma: float, seed: int) -> Drift:
        rng = generator(seed, f"slow {name}")
        return Drift(rng, sigma, self.plan.sigmas["correlation_time_s"], *self._span)

    def _own_sigma(self, key: str) -> float:
        """Return one sigma of the error that is this drone's own."""
        shared, sigma = self.plan.shared, self.plan.sigmas[key]
        if shared is None or key != "gnss_offset_m":
            return sigma
        return math.sqrt(max(sigma**2 - shared.share * shared.sigma_m**2, 0.0))

    def _white(self, key: str, shape: tuple[int, int], name: str) -> Array:
        rng = generator(self._seed, f"white {name}")
        return np.asarray(self.plan.sigmas[key] * rng.standard_normal(shape))

    def _fix_errors(self, t: Array) -> Array:
        slow = [self.error(f"gnss_{axis}", t) for axis in ("east", "north", "up")]
        white = self._white("gnss_white_m", (len(t), 3), "gnss") * (1.0, 1.0, VERTICAL_FACTOR)
        return np.column_stack(slow) + white

    def _turned(self, t: Array, matrices: Array) -> Array:
        """Turn about the vertical by the heading's error, counter-clockwise as yaw counts."""
        error = np.radians(self.error("heading", t))
        return np.asarray(matrix_from_rpy(0.0, 0.0, error) @ matrices)

    def _misread(self, t: Array, matrices: Array) -> Array:
        """Turn cameras about the axes of `core.geometry.gimbal.error_axes` by their slow errors."""
        names = ("gimbal_roll", "gimbal_pitch", "heading")
        errors = np.radians(np.column_stack([self.error(name, t) for name in names]))
        axes = np.array([error_axes(matrix) for matrix in matrices]).reshape(-1, 3, 3)
        return np.asarray(axes @ _rotations(errors) @ axes.swapaxes(1, 2) @ matrices)

    def _covariance(self) -> Array:
        sigmas = self.plan.sigmas
        level = sigmas["gnss_offset_m"] ** 2 + sigmas["gnss_white_m"] ** 2
        return np.diag([level, level, VERTICAL_FACTOR**2 * level])


_SLOW = (
    ("gnss_east", "gnss_offset_m", 1.0),
    ("gnss_north", "gnss_offset_m", 1.0),
    ("gnss_up", "gnss_offset_m", VERTICAL_FACTOR),
    ("heading", "heading_deg", 1.0),
    ("gimbal_pitch", "gimbal_pitch_deg", 1.0),
    ("gimbal_roll", "gimbal_roll_deg", 1.0),
    ("height", "height_m", 1.0),
)


def geodetic(origin: MapDatum, points: Array) -> tuple[Array, Array, Array]:
    """Return latitude, longitude (rad), altitude (m) of points (..., 3): East, North, height.

    Height is above the water, which is at the origin's altitude everywhere.
    """
    latitude, longitude, _ = geodetic_from_enu(
        points[..., 0], points[..., 1], 0.0, origin.latitude, origin.longitude, origin.altitude
    )
    return latitude, longitude, origin.altitude + points[..., 2]


def _rotations(rpy: Array) -> Array:
    """Return small rotations (n, 3, 3) about a frame's own axes from angles (n, 3) in rad."""
    return matrix_from_rpy(rpy[:, 0], rpy[:, 1], rpy[:, 2])


def _orientations(at: Ticks, matrices: Array) -> Iterator[Orientation]:
    quaternions = quaternion_from_matrix(matrices)
    for stamp, quaternion in zip(at.stamps_ns, quaternions, strict=True):
        yield Orientation(int(stamp), quaternion)
