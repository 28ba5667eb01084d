# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""True motion of the simulated drone: hover, orbit or transit, with body and camera.

The world of a simulated flight is a flat chart: East and North of the origin on the water, z the
height above it. Latitude and longitude follow from the tangent plane at the origin; at a kilometre
the chart's axes deviate by 0.1 mrad from true East and North, so keep flights shorter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.numerics.columns import columns
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.simulation.chance import Wander, generator

Array = NDArray[np.float64]

GRAVITY = 9.81
DRAG_PER_S = 0.3
"""Air drag of a small multicopter per mass and airspeed, 1/s: at 5 m/s it leans by 9 deg."""
HOLETOWN = MapDatum(math.radians(13.1939), math.radians(-59.6415), -40.0)
"""Site of the paper's trials; the water is about 40 m below the ellipsoid there."""
NADIR_TILT = math.radians(80.0)
"""Tilt above which the gimbal holds its pitch, rad: following a point below would spin its yaw."""
KINDS = ("hover", "orbit", "transit")


@dataclass(frozen=True)
class Motion:
    """True pose of drone and camera at n times.

    Attributes:
        t: (n,) s since the flight's start.
        antenna: (n, 3) GNSS antenna, East, North, height above the water, m.
        camera: (n, 3) optical centre, likewise.
        enu_from_flu: (n, 3, 3) the body.
        enu_from_camera: (n, 3, 3) the camera (FLU).
    """

    t: Array
    antenna: Array
    camera: Array
    enu_from_flu: Array
    enu_from_camera: Array


class Flight(Protocol):
    """A true flight; `sample` accepts times a little before 0 and after the end."""

    @property
    def origin(self) -> MapDatum:
        """Origin of the chart; its altitude is that of the water above the ellipsoid."""

    @property
    def duration_s(self) -> float:
        """Length of the flight, s."""

    @property
    def words(self) -> str:
        """Description of the flight in words."""

    def sample(self, t: ArrayLike) -> Motion:
        """Return the true motion at times (n,) in s since the start."""


@dataclass(frozen=True)
class FlightPlan:
    """Parameters of a generated flight around a point on the water, the origin of the chart.

    Attributes:
        kind: hover, orbit or transit (legs back and forth past the point).
        duration_s: s.
        height_m: above the water, m.
        tilt: angle below the horizon at which the camera sees the point from the stand-off, rad;
            pi/2 looks straight down.
        stand_off_m: horizontal distance to the point (the orbit's radius; on a transit, of the
            nearest pass), m; None: from `tilt`, which then centres the point in the image.
        speed_mps: along the orbit or the transit, m/s.
        leg_m: length of a transit's leg, m; None: twice the height, at least 30 m.
        track: True: the gimbal follows the point; False: it keeps the angle `tilt`.
        wind_mps: steady wind that the body leans against, m/s.
        camera_offset_m: optical centre relative to the GNSS antenna, body FLU, m.
        origin: the point looked at, and the altitude of the water.
        bearing: direction from the drone to the point at the start, ENU, rad; None: from the seed.
        turn: 1 or -1: an orbit counter-clockwise or clockwise; None: from the seed.
    """

    kind: str = "hover"
    duration_s: float = 60.0
    height_m: float = 15.0
    tilt: float = math.radians(55.0)
    stand_off_m: float | None = None
    speed_mps: float = 2.0
    leg_m: float | None = None
    track: bool = True
    wind_mps: float = 3.0
    camera_offset_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    origin: MapDatum = HOLETOWN
    bearing: float | None = None
    turn: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ConfigError(f"a flight is one of {', '.join(KINDS)}, not {self.kind!r}.")
        ranges = (
            ("height", self.height_m, 0.5, 500.0, "m"),
            ("duration", self.duration_s, 0.1, 7200.0, "s"),
            ("speed", self.speed_mps, 0.0, 30.0, "m/s"),
            ("stand-off", self.stand_off_m or 0.0, 0.0, 5000.0, "m"),
            ("camera tilt", math.degrees(self.tilt), 5.0, 90.0, "deg below the horizon"),
        )
        for name, value, low, high, unit in ranges:
            if not low <= value <= high:
                raise ConfigError(
                    f"the flight's {name} must lie within {low:g} to {high:g} {unit}, not "
                    f"{value:g}."
                )

    @property
    def stand_off(self) -> float:
        """Horizontal distance to the point, m."""
        if self.stand_off_m is not None:
            return self.stand_off_m
        return self.height_m / math.tan(self.tilt)

    @property
    def leg(self) -> float:
        """Length of a transit's leg, m."""
        return max(30.0, 2.0 * self.height_m) if self.leg_m is None else self.leg_m


class GeneratedFlight:
    """A smooth flight by a plan; the same plan and seed give the same flight.

    Attributes:
        plan: its plan.
        bearing: direction from the drone to the point at the start, ENU, rad.
        turn: 1 or -1, see `FlightPlan`.
    """

    def __init__(self, plan: FlightPlan, seed: int) -> None:
        self.plan = plan
        rng = generator(seed, "flight")
        bearing, turn = rng.uniform(-math.pi, math.pi), rng.choice((-1.0, 1.0))
        self.bearing = bearing if plan.bearing is None else plan.bearing
        self.turn = turn if plan.turn is None else plan.turn
        wind = rng.uniform(-math.pi, math.pi)
        self._wind = plan.wind_mps * np.array([math.cos(wind), math.sin(wind), 0.0])
        self._drift = [Wander(rng, rms, 0.02, 0.12) for rms in (0.25, 0.25, 0.12)]
        self._yaw = Wander(rng, math.radians(0.8), 0.03, 0.2)
        self._shake = [Wander(rng, math.radians(0.5), 0.3, 1.5) for _ in range(2)]
        self._gimbal = [Wander(rng, math.radians(rms), 0.05, 0.8) for rms in (0.1, 0.1, 0.2)]
        self._gaze = [Wander(rng, 0.02 * plan.height_m, 0.02, 0.1) for _ in range(2)]
        self._path: Callable[[Array], Array] = {
            "hover": self._hover,
            "orbit": self._orbit,
            "transit": self._transit,
        }[plan.kind]

    @property
    def origin(self) -> MapDatum:
        """Origin of the chart: the point looked at."""
        return self.plan.origin

    @property
    def duration_s(self) -> float:
        """Length of the flight, s."""
        return self.plan.duration_s

    @property
    def words(self) -> str:
        """Description of the flight in words."""
        plan = self.plan
        how = {
            "hover": f"hover {plan.stand_off:.1f} m beside the robots",
            "orbit": f"orbit of {plan.stand_off:.1f} m radius at {plan.speed_mps:g} m/s",
            "transit": f"transit in legs of {plan.leg:.0f} m, {plan.stand_off:.1f} m beside the "
            f"robots at {plan.speed_mps:g} m/s",
        }[plan.kind]
        look = (
            "follows a point" if self._tracks else f"looks {math.degrees(plan.tilt):.0f} deg down"
        )
        return f"{how}, {plan.height_m:g} m above the water; the camera {look}"

    def sample(self, t: ArrayLike) -> Motion:
        """Return the true motion at times (n,) in s since the start."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        antenna = self._position(times)
        yaw = self._nose(times)
        body = self._body(times, yaw)
        camera = antenna + body @ np.array(self.plan.camera_offset_m)
        return Motion(times, antenna, camera, body, self._camera(times, camera, yaw))

    @property
    def _tracks(self) -> bool:
        nearest = math.atan2(self.plan.height_m, self.plan.stand_off)
        return self.plan.track and nearest < NADIR_TILT

    def _position(self, t: Array) -> Array:
        nominal = np.column_stack([self._path(t), np.full(len(t), self.plan.height_m)])
        return nominal + np.column_stack([drift(t) for drift in self._drift])

    def _hover(self, t: Array) -> Array:
        return -self.plan.stand_off * _direction(np.full(len(t), self.bearing))

    def _orbit(self, t: Array) -> Array:
        rate = self.turn * self.plan.speed_mps / max(self.plan.stand_off, 0.1)
        return -self.plan.stand_off * _direction(self.bearing + rate * t)

    def _transit(self, t: Array) -> Array:
        """Back and forth: a triangle wave with rounded corners."""
        plan, round_off = self.plan, 0.97
        period = 2.0 * plan.leg / max(plan.speed_mps, 1e-6)
        wave = np.arcsin(round_off * np.sin(2.0 * np.pi * (t / period - 0.25)))
        along = 0.5 * plan.leg * wave / math.asin(round_off)
        forward = _direction(np.array([self.bearing + 0.5 * math.pi]))
        beside = -plan.stand_off * _direction(np.array([self.bearing]))
        return np.asarray(beside + along[:, None] * self.turn * forward)

    def _nose(self, t: Array) -> Array:
        """Yaw: towards the point from the planned position (drift does not turn it)."""
        if self.plan.stand_off < 0.2 * self.plan.height_m:
            yaw = np.full(len(t), self.bearing)
        else:
            nominal = self._path(t)
            yaw = np.arctan2(-nominal[:, 1], -nominal[:, 0])
        return np.asarray(yaw + self._yaw(t))

    def _body(self, t: Array, yaw: Array) -> Array:
        """Attitude: thrust carries a multicopter, accelerates it and balances air drag."""
        h = 0.05
        before, here, after = (self._position(t + s) for s in (-h, 0.0, h))
        velocity, acceleration = (after - before) / (2 * h), (after - 2 * here + before) / h**2
        thrust = acceleration + DRAG_PER_S * (velocity - self._wind)
        thrust[:, 2] += GRAVITY
        up = thrust / np.linalg.norm(thrust, axis=1, keepdims=True)
        left = np.cross(up, np.column_stack([_direction(yaw), np.zeros(len(t))]))
        left /= np.linalg.norm(left, axis=1, keepdims=True)
        leaning = np.stack([np.cross(left, up), left, up], axis=-1)
        shake = matrix_from_rpy(self._shake[0](t), self._shake[1](t), np.zeros(len(t)))
        return np.asarray(leaning @ shake)

    def _camera(self, t: Array, camera: Array, yaw: Array) -> Array:
        pan, pitch = yaw, np.full(len(t), self.plan.tilt)
        if self._tracks:
            east, north, height = columns(camera)
            east, north = self._gaze[0](t) - east, self._gaze[1](t) - north
            pan, pitch = np.arctan2(north, east), np.arctan2(height, np.hypot(east, north))
        roll, nod, sway = (wander(t) for wander in self._gimbal)
        return matrix_from_rpy(roll, pitch + nod, pan + sway)


def _direction(yaw: Array) -> Array:
    return np.column_stack([np.cos(yaw), np.sin(yaw)])
