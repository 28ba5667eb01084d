# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights of several drones: how they are made, flown by each drone's own estimator, and judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.fleet.sighting import Sighting, SightingTap
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate
from aerial_gnss_ros.core.values.samples import Fix
from aerial_gnss_ros.evaluation.bound import TrueDrone, TrueFrame
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import feed
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.formation import Formation, together
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

Array = NDArray[np.float64]

LAST_S = 10.0
"""Length of the end of each flight that is judged, s."""
SHARES = (0.0, 0.5, 1.0)
"""Of the receivers' variance that is common, in truth."""
OFTEN_ENOUGH_HZ = 3.0
"""Images a second where many flights are flown: errors are those of the platforms, which last, so
that more images of a flight tell little more, and more flights do."""
TWO, RTK = ("consumer",) * 2, ("rtk",) * 2


@dataclass(frozen=True)
class Cell:
    """One kind of flight.

    Attributes:
        kind: of the first drone's flight.
        formation: of the others.
        height_m: above the water.
        noises: set of each drone.
        speed: of the robots, m/s; 0: they stay.
        told: whether the filter is told that they stay.
        robots: number of them.
        duration_s: length.
        rate_hz: images of each drone a second.
        lasts_s: correlation time of slow errors, s; the filter is told 300 s.
        survey_m: one sigma with which the place of a beacon is known, of which only the last drone
            has boxes, m; 0: there is none.
    """

    kind: str
    formation: str
    height_m: float
    noises: tuple[str, ...]
    speed: float = 0.0
    told: bool = False
    robots: int = 3
    duration_s: float = 24.0
    rate_hz: float = 10.0
    survey_m: float = 0.0
    lasts_s: float = 300.0

    @property
    def beacons(self) -> int:
        """Number of beacons."""
        return int(self.survey_m > 0.0)

    @property
    def words(self) -> str:
        """Return the cell in words."""
        sets = self.noises[0] if len(set(self.noises)) == 1 else " and ".join(self.noises)
        drones = "" if len(self.noises) == 2 else f"{len(self.noises)} drones, "
        robots = "one robot, " if self.robots == 1 else ""
        motion = "swimming" if self.speed else "told to stay" if self.told else "still"
        known = f", the other one sees a reference of {self.survey_m:g} m" if self.beacons else ""
        return (
            f"{drones}{self.kind}, {self.formation}, {self.height_m:g} m, {sets}, {robots}{motion}"
            f"{known}"
        )


def drones_of(cell: Cell, seed: int, share: float) -> dict[str, Experiment]:
    """Return the drones of a flight whose receivers have a share in common."""
    plans = [sensor_plan(noise, correlation_time_s=cell.lasts_s) for noise in cell.noises]

    def first(flight: GeneratedFlight, others: Sequence[GeneratedFlight]) -> Experiment:
        return Experiment(
            flight, default_camera(1280, 720), plans[0], robots=cell.robots + cell.beacons,
            swim=SwimPlan(cell.speed, cell.speed, beacons=cell.beacons),
            detector=DetectorPlan(2.0, 0.0, 0.0), seed=seed, others=others,
            survey_m=cell.survey_m, clock=CameraClock(cell.rate_hz),
        )  # fmt: skip

    plan = FlightPlan(kind=cell.kind, duration_s=cell.duration_s, height_m=cell.height_m)
    return together(first, plan, Formation(cell.formation, len(plans), share), seed, plans)


def config_of(
    cell: Cell, noise: str, reference: Fix | None = None, find_moored: bool = False
) -> EstimatorConfig:
    """Return the configuration of a drone's estimator; without a reference it sees no beacon."""
    known: dict[str, Any] = {"detections.classes": ["aqua"]} if cell.beacons else {}
    if reference is not None:
        place = [math.degrees(reference.latitude), math.degrees(reference.longitude)]
        pier = {"class": "beacon", "position": place, "sigma_m": cell.survey_m}
        known = {"references": {"pier": pier}}
    stay = {"noise.robot_acceleration": 0.001, "tracks.max_speed": 0.05} if cell.told else {}
    return estimator_config(
        {"noise.set": noise, "fix.altitude_datum": "ellipsoid", "tracks.find_moored": find_moored}
        | stay
        | known
    )


def own(
    one: Experiment, config: EstimatorConfig, through: Callable[[Estimator], Any] | None = None
) -> tuple[list[FrameResult], list[Sighting]]:
    """Return what a drone's own estimator gives, and what it tells the fleet.

    Args:
        one: the drone.
        config: of its estimator.
        through: makes what spoils the telemetry that the estimator gets.
    """
    estimator, taps = Estimator(config), list[SightingTap]()

    def tapped(tracker: Tracking) -> SightingTap:
        assert isinstance(tracker, Tracker)  # noqa: S101 - the default one
        taps.append(taps[0] if taps else SightingTap(tracker))
        taps[0].follow(tracker)
        return taps[0]

    estimator.wrap_tracking(tapped)
    feed(estimator if through is None else through(estimator), one.sensors)
    estimator.add_camera(START_NS - 10**9, one.camera)
    for _, _, boxes in one.detections():
        estimator.add_detections(boxes)
    results = estimator.advance(START_NS + 10**12) + estimator.flush()
    return results, taps[0].drain()


def errors_at_end(
    one: Experiment,
    local: LocalMap,
    published: Sequence[tuple[RobotEstimate, ...]],
    beacons: int = 0,
    robots: Mapping[str, int] | None = None,
) -> tuple[float, float]:
    """Return mean squared error, m², and mean NEES of a degree of freedom at the flight's end.

    Args:
        one: the flight.
        local: the frame `map`.
        published: positions by image.
        beacons: so many of the first robots do not count.
        robots: number of the robot that a name stands for; of others it is the nearest one.
    """
    begin_ns = START_NS + round((one.flight.duration_s - LAST_S) * 1e9)
    squares, normalised = list[float](), list[float]()
    for estimates in published:
        if not estimates or estimates[0].stamp_ns < begin_ns:
            continue
        true = one.swarm.positions([(estimates[0].stamp_ns - START_NS) * 1e-9])[:, 0, :2]
        for estimate in estimates:
            if estimate.class_id == "beacon":
                continue
            place = local.positions([estimate.latitude], [estimate.longitude])[0]
            nearest = beacons + int(np.square(true[beacons:] - place).sum(axis=1).argmin())
            error = place - true[(robots or {}).get(estimate.robot_id, nearest)]
            squares.append(float(error @ error))
            normalised.append(
                0.5 * float(error @ np.linalg.solve(estimate.covariance[:2, :2], error))
            )
    return float(np.mean(squares)), float(np.mean(normalised))


def true_drone(one: Experiment, config: EstimatorConfig, unseen: int = 0) -> TrueDrone:
    """Return a drone for the bound, which does not see so many of the first robots."""
    frames = [
        TrueFrame(
            one.true_pose(frame),
            one.swarm.positions([frame.t])[:, 0, :2],
            np.isin(one.swarm.names, one.projected(frame).names)
            & (np.arange(len(one.swarm.names)) >= unseen),
        )
        for frame in one.frames()
    ]
    return TrueDrone(config, one.camera, frames)


def trace(limits: Array) -> float:
    """Return the mean variance of positions, m²."""
    return float(np.nanmean(np.trace(limits[:, :, :2, :2], axis1=2, axis2=3)))
