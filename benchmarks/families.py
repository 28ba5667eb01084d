# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The flights on which the estimation is judged: families, heights, receivers, robots' motion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.evaluation.bound import TrueFrame, bound
from aerial_gnss_ros.simulation.boxes import Boxes
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, Frame, default_camera
from aerial_gnss_ros.simulation.feeding import deliver, telemetry
from aerial_gnss_ros.simulation.flight import HOLETOWN, FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.robot_models import AQUA
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

Array = NDArray[np.float64]
Image = tuple[Frame, Boxes, DetectionFrame]
"""What an image shows, its true boxes and the detector's."""

ACCELERATION = 0.05
"""Random-walk rate of the moving robots' velocity, m/s^1.5: the default that the filter states."""
STILL_MPS = 0.01
"""Smallest `tracks.max_speed` that can be stated, m/s. Robots that stay drift by up to as much:
velocities even over the disc have the sigma that the filter assumes, half of that speed on each
axis."""
RTK_OFFSET_M = 0.02
OWN_S = 5.0
"""For so long after its first image a name is on its own robot, s."""
ORIGIN = MapDatum(HOLETOWN.latitude, HOLETOWN.longitude, 0.0)


@dataclass(frozen=True)
class Cell:
    """One kind of flight.

    Attributes:
        family: hover, orbit or transit (to and fro), past a point, looking at it.
        height_m: above the water.
        receiver: consumer (1.2 m slow offset) or rtk (2 cm); all else consumer grade in both.
        moving: robots swim at first 0.2 to 0.7 m/s with random accelerations, or stay but for a
            steady drift of `STILL_MPS` at most.
    """

    family: str
    height_m: float
    receiver: str
    moving: bool

    @property
    def words(self) -> str:
        """Return the cell in words."""
        motion = "moving" if self.moving else "still"
        return f"{self.family} {self.height_m:g} m {self.receiver} {motion}"


def cells() -> list[Cell]:
    """Return all families."""
    kinds = itertools.product(
        ("hover", "orbit", "transit"), (10.0, 30.0, 80.0), ("consumer", "rtk"), (False, True)
    )
    return [Cell(*kind) for kind in kinds]


@dataclass(frozen=True)
class Setting:
    """What may be wrong or different about a flight.

    Attributes:
        robots: how many.
        duration_s: s.
        latency_s: true one of the images.
        sigmas: true sensor errors that replace the set's, by the names of `core.config.noise`.
        stated: parameters of the estimator beside those of the cell.
        beacons: so many robots, the first ones, stay and are of the class beacon.
    """

    robots: int = 3
    duration_s: float = 60.0
    latency_s: float = 0.0
    sigmas: dict[str, float] = field(default_factory=dict)
    stated: dict[str, object] = field(default_factory=dict)
    beacons: int = 0


class RandomSwimmers:
    """Robots that move as the filter supposes: white acceleration. Stands in for `Swarm`."""

    STEP_S = 0.05

    def __init__(
        self, places: Array, moving: bool, seed: int, duration_s: float, beacons: int = 0
    ) -> None:
        rng = generator(seed, "random swimmers")
        count, dt = len(places), self.STEP_S
        self.class_names = ("beacon",) * beacons + ("aqua",) * (count - beacons)
        self.models = (AQUA,) * count
        self.names = tuple(f"{name}_{i + 1}" for i, name in enumerate(self.class_names))
        self.speeds = (
            rng.uniform(0.2, 0.7, count) if moving else STILL_MPS * np.sqrt(rng.random(count))
        )
        course = rng.uniform(-math.pi, math.pi, count)
        velocity = self.speeds[:, None] * np.column_stack([np.cos(course), np.sin(course)])
        self._t = np.arange(-4.0, duration_s + 4.0, dt)
        self._path = np.empty((len(self._t), count, 2))
        place = np.array(places, dtype=np.float64)
        for step in range(len(self._t)):
            self._path[step] = place
            one, two = rng.standard_normal((2, count, 2)) * ACCELERATION * moving
            # Exact for white acceleration: place and velocity are correlated within a step.
            drift = math.sqrt(dt**3) * (0.5 * one + two / math.sqrt(12.0))
            place = place + velocity * dt + drift
            velocity = velocity + math.sqrt(dt) * one
        self._path[:, :beacons] = self._path[0, :beacons]

    def positions(self, t: ArrayLike) -> Array:
        """Return East, North, up (n, m, 3) at times (m,), m."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        found = np.zeros((len(self.names), len(times), 3))
        for i in range(len(self.names)):
            for axis in (0, 1):
                found[i, :, axis] = np.interp(times, self._t, self._path[:, i, axis])
        return found

    def courses(self, t: ArrayLike) -> Array:
        """Return yaws (n, m); they do not matter to boxes' centres."""
        return np.zeros((len(self.names), len(np.atleast_1d(np.asarray(t)))))


def experiment(cell: Cell, seed: int, setting: Setting) -> Experiment:
    """Return the flight of a cell; equal arguments give equal flights."""
    plan = FlightPlan(
        kind=cell.family, duration_s=setting.duration_s, height_m=cell.height_m, speed_mps=5.0
    )
    sigmas = dict(setting.sigmas)
    if cell.receiver == "rtk":
        sigmas.setdefault("gnss_offset_m", RTK_OFFSET_M)
    made = Experiment(
        GeneratedFlight(plan, seed),
        default_camera(1280, 720),
        sensor_plan("consumer", **sigmas),
        CameraClock(latency_s=setting.latency_s),
        robots=setting.robots,
        swim=SwimPlan(0.0, 0.0, roam_m=1e3, apart_m=1.5),
        seed=seed,
    )
    assert made.places is not None  # noqa: S101 - it places the robots itself
    swimmers = RandomSwimmers(made.places, cell.moving, seed, setting.duration_s, setting.beacons)
    made.swarm = swimmers  # type: ignore[assignment]
    return made


def config(cell: Cell, setting: Setting) -> EstimatorConfig:
    """Return the estimator's parameters: the noise and motion of the flight, as stated."""
    values: dict[str, object] = {
        "map.latitude_deg": math.degrees(ORIGIN.latitude),
        "map.longitude_deg": math.degrees(ORIGIN.longitude),
        "fix.altitude_datum": "ellipsoid",
    }
    if cell.receiver == "rtk":
        values["noise.gnss_offset_m"] = RTK_OFFSET_M
    if not cell.moving:
        values |= {"noise.robot_acceleration": 0.0, "tracks.max_speed": STILL_MPS}
    return estimator_config(values | setting.stated)


def results(
    made: Experiment,
    stated: EstimatorConfig,
    images: list[Image] | None = None,
    tracking: Tracking | None = None,
    watch: Callable[[Estimator, list[FrameResult]], None] | None = None,
) -> list[FrameResult]:
    """Return what the estimator makes of a flight, its images made already or not.

    Args:
        made: the flight.
        stated: the estimator's parameters.
        images: of the flight, where they are made already.
        tracking: another tracker than the estimator's own.
        watch: is shown the estimator after each of its results.
    """
    engine = Estimator(stated, tracking)
    engine.add_camera(START_NS - 10_000_000_000, made.camera)
    arriving: list[tuple[int, Callable[[], None]]] = [
        (sample.stamp_ns, partial(deliver, engine, source, sample))
        for source, sample in telemetry(made.sensors)
    ]
    for _, _, frame in images or made.detections():
        # Late telemetry belongs to earlier images: an image waits for what brackets its scene.
        arriving.append((frame.stamp_ns, partial(engine.add_detections, frame)))
    arriving.sort(key=lambda item: item[0])
    found: list[FrameResult] = []
    for stamp_ns, add in arriving:
        add()
        new = engine.advance(stamp_ns)
        if new and watch is not None:
            watch(engine, new)
        found += new
    return found + engine.flush()


def truth(made: Experiment, images: list[Image]) -> list[TrueFrame]:
    """Return the true camera and robots of each image."""
    paths = made.swarm.positions(np.array([frame.t for frame, _, _ in images]))[:, :, :2]
    return [
        TrueFrame(
            made.true_pose(frame),
            paths[:, k],
            np.array([name in boxes.names for name in made.swarm.names]),
        )
        for k, (frame, boxes, _) in enumerate(images)
    ]


def bounds(
    made: Experiment,
    stated: EstimatorConfig,
    true: list[TrueFrame],
    known: dict[int, float] | None = None,
) -> Array:
    """Return the posterior Cramér-Rao bounds (images, n, 4, 4)."""
    return bound(stated, made.camera, true, LocalMap(ORIGIN), known)


_NEVER = 1e12  # m², of a name and a robot that its class rules out


def robots_of(
    found: list[FrameResult], true: list[TrueFrame], singular: Mapping[str, int] | None = None,
    own_s: float = OWN_S,
) -> dict[str, int]:  # fmt: skip
    """Return which true robot each name is: two names may share one.

    It is the nearest over the name's first seconds: should the name go to another robot later, it
    still is the first one's, and where that is, is what the covariance has to hold. The best
    assignment over all names comes first, by squared distances, so that an error which all share
    does not matter; names beyond the robots take their nearest.

    Args:
        found: results.
        true: truth of the same images.
        singular: the only robot of a class, by class, where there is one.
        own_s: these first seconds, s.
    """
    from scipy.optimize import linear_sum_assignment

    singular = singular or {}
    alone = {*singular.values()}
    total: dict[str, Array] = {}
    images: dict[str, int] = {}
    since: dict[str, int] = {}
    for result, frame in zip(found, true, strict=True):
        for estimate in result.estimates:
            now = frame.pose.stamp_ns
            if now - since.setdefault(estimate.robot_id, now) > own_s * 1e9:
                continue
            apart = np.sum((frame.positions - estimate.position) ** 2, axis=1)
            only = singular.get(estimate.class_id)
            others = [k != only if only is not None else k in alone for k in range(len(apart))]
            apart[others] = _NEVER
            total[estimate.robot_id] = total.get(estimate.robot_id, 0.0) + apart
            images[estimate.robot_id] = images.get(estimate.robot_id, 0) + 1
    names = sorted(total)
    if not names:
        return {}
    cost = np.array([total[name] / images[name] for name in names])
    rows, columns = linear_sum_assignment(cost)
    given = {name: int(np.argmin(cost[i])) for i, name in enumerate(names)}
    pairs = zip(rows, columns, strict=True)
    given.update({names[row]: int(column) for row, column in pairs if cost[row, column] < _NEVER})
    return given
