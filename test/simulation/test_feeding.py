# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every sample of a simulated flight reaches the input that it belongs to, once."""

from __future__ import annotations

from types import SimpleNamespace

from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.simulation.feeding import EARTH_REFERENCED, feed, feed_in_time, telemetry
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.sensors import START_NS, Sensors, sensor_plan


class Heard:
    """Remembers what came over each input."""

    def __init__(self) -> None:
        self.came: dict[str, list[object]] = {}

    def __getattr__(self, name: str):
        return self.came.setdefault(name, []).append


def test_all_samples_arrive_at_their_inputs():
    flight = GeneratedFlight(FlightPlan("orbit", 3.0), 1)
    sensors = Sensors(flight, sensor_plan("consumer"), 1, -1.0, 4.0)
    heard = Heard()
    feed(heard, sensors, tuple(Input))
    stamps = {name: [one.stamp_ns for one in values] for name, values in heard.came.items()}
    for name, values in (
        ("add_fix", sensors.fixes()),
        ("add_attitude", sensors.attitudes()),
        ("add_gimbal", sensors.gimbals()),
        ("add_height", sensors.heights()),
    ):
        expected = list(values)
        assert stamps[name] == [one.stamp_ns for one in expected]
        assert [type(one) for one in heard.came[name]] == [type(one) for one in expected]
    some = {source for source, _ in telemetry(sensors)}
    assert some == set(EARTH_REFERENCED)
    assert Input.ATTITUDE not in some


def test_telemetry_is_never_far_ahead_of_the_images():
    flight = GeneratedFlight(FlightPlan("orbit", 3.0), 1)
    sensors = Sensors(flight, sensor_plan("consumer"), 1, -1.0, 4.0)
    heard, latest = Heard(), []
    images = [SimpleNamespace(stamp_ns=START_NS + 10**9 * k) for k in (0, 2)]

    def see(image):
        found = [one.stamp_ns for values in heard.came.values() for one in values]
        latest.append(max(found) - image.stamp_ns)
        expected = [one for one in sensors.gimbals() if one.stamp_ns <= image.stamp_ns + 10**9]
        assert len(heard.came["add_gimbal"]) == len(expected)

    feed_in_time(heard, sensors, images, see)
    assert len(latest) == 2
    assert all(0.9e9 < ahead <= 1e9 for ahead in latest)
