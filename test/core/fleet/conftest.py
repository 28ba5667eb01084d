# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Several simulated drones, each with its own estimator, and the fleet that joins them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.sighting import SightingTap
from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
)
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.samples import Orientation
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.feeding import AHEAD_S, feed, feed_in_time
from aerial_gnss_ros.simulation.flight import FlightPlan
from aerial_gnss_ros.simulation.formation import Formation, together
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan


class Turned:
    """Passes telemetry on with the compass turned, after some time."""

    def __init__(self, estimator, angle, after_s=-1.0):
        self._estimator, self._turn = estimator, matrix_from_rpy(0.0, 0.0, angle)
        self._after_ns = START_NS + round(after_s * 1e9)

    def __getattr__(self, name):
        return getattr(self._estimator, name)

    def add_gimbal(self, sample):
        if sample.stamp_ns > self._after_ns:
            turned = self._turn @ matrix_from_quaternion(sample.quaternion)
            sample = Orientation(sample.stamp_ns, quaternion_from_matrix(turned[None])[0])
        self._estimator.add_gimbal(sample)


class Shifted:
    """Passes telemetry on with all fixes displaced to the North."""

    def __init__(self, estimator, north):
        self._estimator, self._north = estimator, north

    def __getattr__(self, name):
        return getattr(self._estimator, name)

    def add_fix(self, fix):
        self._estimator.add_fix(replace(fix, latitude=fix.latitude + self._north / 6.37e6))


@dataclass
class Flown:
    """Drones that have flown.

    Attributes:
        made: their flights, by name.
        configs: of their estimators.
        local: the frame `map`.
        sightings: of each.
        alone: results of each drone's own estimator.
    """

    made: dict
    configs: dict
    local: LocalMap
    sightings: dict
    alone: dict

    def together(self, share=0.5, order=None):
        """Return the fleet, and its updates with the drone and the sighting of each."""
        fleet = Fleet(self.configs, self.local, share)
        told = [(s.pose.stamp_ns, name, s) for name, of in self.sightings.items() for s in of]
        told.sort(key=lambda one: one[:2] if order is None else (one[0], order.index(one[1])))
        return fleet, [(name, s, fleet.update(name, s)) for _, name, s in told]

    def errors(self, estimates):
        """Return the distance of each estimate from the nearest true robot, and which that is."""
        found = {}
        for one in estimates:
            t = (one.stamp_ns - START_NS) * 1e-9
            true = self.made["a"].swarm.positions([t])[:, 0, :2]
            place = self.local.positions([one.latitude], [one.longitude])[0]
            apart = np.linalg.norm(true - place, axis=1)
            found[one.robot_id] = float(apart.min()), int(apart.argmin())
        return found

    def rms(self, results, after_s):
        """Return the root mean square error of results (their estimates) after some time, m."""
        squares = [
            error**2
            for estimates in results
            if estimates and (estimates[0].stamp_ns - START_NS) * 1e-9 >= after_s
            for error, _ in self.errors(estimates).values()
        ]
        return math.sqrt(float(np.mean(squares)))


def flown_by(estimator, receiver, sensors, images, duration):
    """Return an estimator's results; it keeps a minute of telemetry."""
    results = []
    if duration < 50.0:
        feed(receiver, sensors)
        for boxes in images:
            estimator.add_detections(boxes)
        results = estimator.advance(START_NS + 10**12)
    else:

        def see(boxes):
            estimator.add_detections(boxes)
            results.extend(estimator.advance(boxes.stamp_ns + round(AHEAD_S * 1e9)))

        feed_in_time(receiver, sensors, images, see)
    return results + estimator.flush()


def fly(
    *, kind="hover", formation="opposite", count=2, share=0.5, noises=("consumer", "consumer"),
    seed=1, robots=3, speed=0.0, places=None, duration=12.0, images=5.0, spoil=None,
    missed=0.0, set_=None, **plan,
):  # fmt: skip
    """Fly several drones.

    `images` are those a second, `spoil` changes the telemetry that an estimator gets, `set_` are
    parameters of all of them.
    """
    plans = [sensor_plan(noise) for noise in noises[:count]]

    def first(flight, others):
        return Experiment(
            flight, default_camera(1280, 720), plans[0], CameraClock(images), robots=robots,
            places=places, swim=SwimPlan(speed, speed), seed=seed, others=others,
            detector=DetectorPlan(2.0, missed, 0.0),
        )  # fmt: skip

    flown = FlightPlan(kind=kind, duration_s=duration, **plan)
    made = together(first, flown, Formation(formation, count, share), seed, plans)
    configs, sightings, alone = {}, {}, {}
    for (name, one), noise in zip(made.items(), noises, strict=False):
        settings = {
            "noise.set": noise,
            "fix.altitude_datum": "ellipsoid",
            "tracks.find_moored": False,
            # Covariances of a drone alone contain these, a fleet's none.
            "camera.find_latency": False,
            "fix.find_latency": False,
        }
        configs[name] = estimator_config(settings | (set_ or {}))
        estimator, taps = Estimator(configs[name]), []

        def tapped(tracker, taps=taps):
            taps.append(taps[0] if taps else SightingTap(tracker))
            taps[0].follow(tracker)
            return taps[0]

        estimator.wrap_tracking(tapped)
        receiver = estimator if spoil is None else spoil(name, estimator)
        estimator.add_camera(START_NS - 10**9, one.camera)
        boxes = (boxes for _, _, boxes in one.detections())
        alone[name] = flown_by(estimator, receiver, one.sensors, boxes, duration)
        sightings[name] = taps[0].drain()
    return Flown(made, configs, LocalMap(made["a"].flight.origin), sightings, alone)


@pytest.fixture(scope="session")
def fleet_of():
    """Return `fly`."""
    return fly


@pytest.fixture(scope="session")
def two_rtk():
    """Two drones with RTK hover on opposite sides of three robots that stay."""
    places = 0.3 * 15.0 * np.array([[0.6, 0.5], [-1.0, 0.2], [0.4, -0.8]])
    return fly(noises=("rtk", "rtk"), places=places, duration=20.0, seed=4)


@pytest.fixture(scope="session")
def turned():
    """Return `Turned`."""
    return Turned


@pytest.fixture(scope="session")
def shifted():
    """Return `Shifted`."""
    return Shifted
