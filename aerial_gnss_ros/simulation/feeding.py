# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Feeds a simulated flight's telemetry to an estimator without a bag or a node."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.simulation.sensors import Sensors

Sample = Fix | Orientation | Scalar

AHEAD_S = 1.0
"""By how much telemetry is ahead of the images in `feed_in_time`, s; more than a sample's gap."""
EARTH_REFERENCED = (Input.FIX, Input.GIMBAL, Input.HEIGHT)
"""Inputs that the pose of an earth-referenced gimbal without a lever arm needs."""


class Receiver(Protocol):
    """Receives telemetry: an estimator or a calibration's recording."""

    def add_fix(self, fix: Fix) -> None:
        """Add a position of the drone."""

    def add_attitude(self, attitude: Orientation) -> None:
        """Add an orientation of the body."""

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Add an orientation of the camera."""

    def add_height(self, height: Scalar) -> None:
        """Add a height of the drone."""


def telemetry(
    sensors: Sensors, inputs: tuple[Input, ...] = EARTH_REFERENCED, true: bool = False
) -> Iterator[tuple[Input, Sample]]:
    """Yield the samples of some inputs, one input after the other, each in the order of time.

    Args:
        sensors: of the flight.
        inputs: names of the inputs.
        true: whether to omit errors.
    """
    sources: dict[Input, Callable[[bool], Iterator[Sample]]] = {
        Input.FIX: sensors.fixes,
        Input.ATTITUDE: sensors.attitudes,
        Input.GIMBAL: sensors.gimbals,
        Input.HEIGHT: sensors.heights,
    }
    for source in inputs:
        for sample in sources[source](true):
            yield source, sample


def deliver(receiver: Receiver, source: Input, sample: Sample) -> None:
    """Pass one sample to its method of the receiver."""
    getattr(receiver, f"add_{source.value}")(sample)


def feed(
    receiver: Receiver,
    sensors: Sensors,
    inputs: tuple[Input, ...] = EARTH_REFERENCED,
    true: bool = False,
) -> None:
    """Feed the telemetry of a whole flight to an estimator.

    Args:
        receiver: the estimator.
        sensors: of the flight.
        inputs: which of them; the order does not matter to the estimator.
        true: whether to omit errors.
    """
    for source, sample in telemetry(sensors, inputs, true):
        deliver(receiver, source, sample)


def feed_in_time(
    receiver: Receiver,
    sensors: Sensors,
    images: Iterable[DetectionFrame],
    each: Callable[[DetectionFrame], None],
    inputs: tuple[Input, ...] = EARTH_REFERENCED,
) -> None:
    """Feed a flight that is longer than the minute of telemetry that an estimator keeps.

    Args:
        receiver: the estimator.
        sensors: of the flight.
        images: their boxes, in the order of time.
        each: called with each of them when the telemetry until `AHEAD_S` after it has been fed.
        inputs: which of the sensors.
    """
    samples = sorted(telemetry(sensors, inputs), key=lambda one: one[1].stamp_ns)
    fed = 0
    for image in images:
        until_ns = image.stamp_ns + round(AHEAD_S * 1e9)
        while fed < len(samples) and samples[fed][1].stamp_ns <= until_ns:
            deliver(receiver, *samples[fed])
            fed += 1
        each(image)
