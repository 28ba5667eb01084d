# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""True motion of the simulated robots: constant speed, smooth turns, near the surface."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.geometry.frames import wrap_angle
from aerial_gnss_ros.core.numerics.columns import columns
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.chance import Wander, generator
from aerial_gnss_ros.simulation.hexapod import LENGTH, LIVERIES, RobotState
from aerial_gnss_ros.simulation.robot_models import AQUA, robot_model

Array = NDArray[np.float64]

STEP_S = 0.05
MOST_TURN = 0.5
"""rad/s."""


@dataclass(frozen=True)
class SwimPlan:
    """Parameters of the robots' motion.

    Attributes:
        slowest_mps, fastest_mps: bounds of each robot's constant speed; both 0: they stay.
        roam_m: distance from its start at which a robot turns back; None: from the view.
        apart_m: distance below which robots turn away from each other; None: from the view.
        depth_m: mean depth of the hull's middle; 0 is half out of the water.
        heave_m: root mean square of the depth's slow variation.
        dives: whether each robot dives out of sight from time to time.
        dive_depth_m: depth of a dive.
        dive_s: duration of a dive.
        dive_every_s: from the middle of one dive to that of the next.
        shortest_dive_s: None: each dive lasts `dive_s`, at regular intervals. Otherwise its length
            is uniform between the two, and its start uniform within its interval of `dive_every_s`,
            so that dives are unpredictable.
        class_name: what a detector calls them; also the stem of their names; empty: their model.
        beacons: so many of them, the first ones, stay and are called `beacon_class`.
        beacon_class: what a detector calls these; also the stem of their names; empty: their
            model.
        models: their shapes, names for `robot_models.robot_model`; the robots take turns.
    """

    slowest_mps: float = 0.15
    fastest_mps: float = 0.6
    roam_m: float | None = None
    apart_m: float | None = None
    depth_m: float = 0.0
    heave_m: float = 0.01
    dives: bool = False
    dive_depth_m: float = 3.0
    dive_s: float = 12.0
    dive_every_s: float = 40.0
    shortest_dive_s: float | None = None
    class_name: str = ""
    beacons: int = 0
    beacon_class: str = "beacon"
    models: tuple[str, ...] = (AQUA,)

    def __post_init__(self) -> None:
        if not self.models:
            raise ConfigError("robots need a model; name at least one.")
        if not 0.0 <= self.slowest_mps <= self.fastest_mps <= 3.0:
            raise ConfigError(
                "robots swim between 0 and 3 m/s, the slowest not faster than the fastest; not "
                f"{self.slowest_mps:g} to {self.fastest_mps:g} m/s."
            )
        if not 0.0 < (self.shortest_dive_s or self.dive_s) <= self.dive_s <= self.dive_every_s:
            raise ConfigError(
                "dives last longer than 0 s and end before the next; not "
                f"{self.shortest_dive_s or self.dive_s:g} to {self.dive_s:g} s every "
                f"{self.dive_every_s:g} s."
            )

    def shapes(self, count: int) -> tuple[str, ...]:
        """Return the models of so many robots."""
        return tuple(self.models[i % len(self.models)] for i in range(count))

    def classes(self, count: int) -> tuple[str, ...]:
        """Return the classes of so many robots."""
        shapes = self.shapes(count)
        return tuple(
            (self.beacon_class if i < self.beacons else self.class_name) or robot_model(shape).name
            for i, shape in enumerate(shapes)
        )


def fitted(plan: SwimPlan, view_width_m: float) -> SwimPlan:
    """Return a plan with its open distances chosen for a view of some width, m."""
    roam = min(max(0.12 * view_width_m, 0.8), 4.0) if plan.roam_m is None else plan.roam_m
    longer = max(1.0, *(robot_model(name).length / LENGTH for name in plan.models))
    apart = plan.apart_m
    if apart is None:
        apart = min(max(0.1 * view_width_m, 0.9 * longer), 2.5)
    return replace(plan, roam_m=roam, apart_m=apart)


class Swarm:
    """True motion of all robots; the same plan, positions and seed give the same motion.

    Attributes:
        names: n names, `<class>_<i>`, each class from 1.
        class_names: n names of their classes.
        models: n names of their shapes.
        speeds: (n,) m/s.
    """

    def __init__(
        self, places: Array, plan: SwimPlan, seed: int, start_s: float, end_s: float
    ) -> None:
        """Simulate the robots over a span of time.

        Args:
            places: (n, 2) East, North position of each at `start_s`, m.
            plan: how they swim; open distances suit a wide view.
            seed: of their random numbers.
            start_s: first time needed, s since the flight's start.
            end_s: last time.
        """
        self.plan = plan
        wide = fitted(plan, math.inf)
        self._roam, self._apart = wide.roam_m or 0.0, wide.apart_m or 0.0
        self._places = np.asarray(places, dtype=np.float64).reshape(-1, 2)
        count = len(self._places)
        beacons = min(plan.beacons, count)
        self.class_names, self.models = plan.classes(count), plan.shapes(count)
        self.names = tuple(
            f"{name}_{self.class_names[: i + 1].count(name)}"
            for i, name in enumerate(self.class_names)
        )
        rng = generator(seed, "robots")
        self.speeds = rng.uniform(plan.slowest_mps, plan.fastest_mps, count)
        self.speeds[:beacons] = 0.0
        self._course0 = rng.uniform(-math.pi, math.pi, count)
        self._turning = [Wander(rng, 0.12, 0.01, 0.08) for _ in range(count)]
        self._heave = [Wander(rng, plan.heave_m, 0.05, 0.4) for _ in range(count)]
        self._lean = [Wander(rng, math.radians(2.5), 0.2, 0.8) for _ in range(2 * count)]
        self._dive_phase = rng.uniform(0.0, 1.0, count)
        turns = math.ceil(max(end_s, 0.0) / plan.dive_every_s) + 2
        # Two numbers for each dive: of its length and of its beginning.
        streams = [generator(seed, f"dives {i}") for i in range(count)]
        self._dives = [stream.uniform(0.0, 1.0, (turns, 2)) for stream in streams]
        self._beat = rng.uniform(0.0, 2.0 * math.pi, count)
        liveries = rng.permutation(sorted(LIVERIES))
        self._liveries = [str(liveries[i % len(liveries)]) for i in range(count)]
        self._times = np.arange(start_s, end_s + 2.0 * STEP_S, STEP_S)
        self._path, self._course = self._swim()

    def __len__(self) -> int:
        return len(self.names)

    def positions(self, t: ArrayLike) -> Array:
        """Return East, North, up (n robots, m times, 3) of the hulls' middles, m."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        result = np.empty((len(self), len(times), 3))
        for i in range(len(self)):
            result[i, :, 0] = np.interp(times, self._times, self._path[:, i, 0])
            result[i, :, 1] = np.interp(times, self._times, self._path[:, i, 1])
            result[i, :, 2] = -self._depth(i, times)
        return result

    def courses(self, t: ArrayLike) -> Array:
        """Return yaws (n robots, m times), ENU, rad, not wrapped."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        rows = [np.interp(times, self._times, self._course[:, i]) for i in range(len(self))]
        return np.array(rows).reshape(len(self), len(times))

    def states(self, t: float) -> list[RobotState]:
        """Return the robots as they are to be rendered at one time in s."""
        times = np.array([t])
        positions, courses = self.positions(times)[:, 0], self.courses(times)[:, 0]
        return [
            RobotState(
                robot_id=self.names[i],
                east=float(positions[i, 0]),
                north=float(positions[i, 1]),
                course=float(wrap_angle(courses[i])),
                depth=float(-positions[i, 2]),
                speed=float(self.speeds[i]),
                phase=float(self._beat[i] + 2.0 * math.pi * (0.6 + self.speeds[i]) * t),
                roll=float(self._lean[2 * i](times)[0]),
                pitch=float(self._lean[2 * i + 1](times)[0]),
                class_name=self.class_names[i],
                livery=self._liveries[i],
                model=self.models[i],
            )
            for i in range(len(self))
        ]

    def _depth(self, i: int, t: Array) -> Array:
        depth = self.plan.depth_m + self._heave[i](t)
        if self.plan.dives:
            period = self.plan.dive_every_s
            since = (t / period + self._dive_phase[i]) % 1.0 * period - 0.5 * period
            length: Array | float = self.plan.dive_s
            if self.plan.shortest_dive_s is not None:
                turn = np.floor(t / period + self._dive_phase[i]).astype(np.intp)
                short, late = self._dives[i][np.clip(turn, 0, len(self._dives[i]) - 1)].T
                length = length - short * (length - self.plan.shortest_dive_s)
                since = since - (late - 0.5) * (period - length)
            share = np.clip(1.0 - np.abs(since) / (0.5 * length), 0.0, 1.0)
            depth = depth + self.plan.dive_depth_m * (3.0 - 2.0 * share) * share**2
        return np.asarray(depth)

    def _swim(self) -> tuple[Array, Array]:
        """Return positions (steps, n, 2) and courses (steps, n)."""
        turns = [turn(self._times) for turn in self._turning]
        wander = np.array(turns).reshape(len(self), len(self._times))
        path = np.empty((len(self._times), len(self), 2))
        courses = np.empty((len(self._times), len(self)))
        place, course = self._places.copy(), self._course0.copy()
        for step in range(len(self._times)):
            path[step], courses[step] = place, course
            rate = wander[:, step] + self._steering(place, course)
            course = course + STEP_S * np.clip(rate, -MOST_TURN, MOST_TURN)
            ahead = np.column_stack([np.cos(course), np.sin(course)])
            place = place + STEP_S * self.speeds[:, None] * ahead
        return path, courses

    def _steering(self, place: Array, course: Array) -> Array:
        """Turn rates (n,) that steer back to the start from afar, and away from other robots."""
        home = self._places - place
        far = np.linalg.norm(home, axis=1)
        pull = np.where(far > self._roam, 1.0, 0.0)[:, None] * home
        away = place[:, None, :] - place[None, :, :]
        gap = np.linalg.norm(away, axis=2)
        np.fill_diagonal(gap, np.inf)
        push = np.where(gap < self._apart, 12.0 / np.maximum(gap, 0.05) ** 2, 0.0)
        wish = pull + (push[:, :, None] * away).sum(axis=1)
        east, north = columns(wish)
        error = wrap_angle(np.arctan2(north, east) - course)
        return np.where(np.linalg.norm(wish, axis=1) > 0.0, 0.8 * error, 0.0)
