# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hears positions and the truth for as long as a soak lasts."""

from __future__ import annotations

import bisect
import math
import time
from collections import deque
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import NavSatFix

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.nodes import qos

WRONG_M, WRONG_SIGMAS = 5.0, 4.0
_LOOK_S = 1.0
_KEPT = 400  # of the truth of each robot: several seconds
_STEP_NS = 10_000_000_000  # a stamp farther ahead is of before a step of the clock
_BEHIND_NS = 1_000_000_000  # by then the truth of a position has arrived


class Listener(Node):  # type: ignore[misc]  # rclpy has no complete types
    """Compares each position with every true robot; `minute` tells and begins anew.

    Args:
        simulated_time: whether the time comes from /clock.

    Attributes:
        names: of all robots that were ever published.
        last: when each last came, by a clock that never jumps, s, and whether it was measured.
        silent_s: the longest time without any position, s.
        reported: when each node last published diagnostics, s.
    """

    def __init__(self, simulated_time: bool = False) -> None:
        simulated = Parameter("use_sim_time", value=simulated_time)
        super().__init__("soak", parameter_overrides=[simulated])
        self._known: set[str] = set()
        self._truth: dict[str, deque[tuple[int, float, float]]] = {}
        self._waiting: deque[tuple[int, float, float, float]] = deque()
        self.names: set[str] = set()
        self.last: dict[str, tuple[float, bool]] = {}
        self.silent_s = 0.0
        self.reported: dict[str, float] = {}
        self._clear()
        self.create_subscription(DiagnosticArray, "/diagnostics", self._diagnostics, 10)
        self.create_timer(_LOOK_S, self._look)
        self.create_timer(_LOOK_S, self._judge)

    def _clear(self) -> None:
        self._delays: list[float] = []
        self._controls: list[float] = []
        self._positions = self._wrong = self._predicted = 0

    @property
    def robots(self) -> int:
        """Number of true robots."""
        return len(self._truth)

    def minute(self) -> dict[str, Any]:
        """Return delays (ms), counts of positions, and forget them."""
        self._judge()
        found = {
            "delay_ms": _quantiles(self._delays),
            "control_ms": _quantiles(self._controls),
            "positions": self._positions,
            "predicted": self._predicted,
            "wrong": self._wrong,
        }
        self._clear()
        return found

    @property
    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def _look(self) -> None:
        for topic, _ in self.get_topic_names_and_types():
            if topic in self._known or not topic.endswith("/fix") or "robots/" not in topic:
                continue
            self._known.add(topic)
            name = topic.split("/")[-2]
            if topic.startswith("/truth/"):
                self._truth[name] = deque(maxlen=_KEPT)
                self.create_subscription(
                    NavSatFix, topic, lambda fix, name=name: self._true(name, fix), qos.sensor(50)
                )
            else:
                self.names.add(name)
                self.create_subscription(
                    NavSatFix,
                    topic,
                    lambda fix, name=name: self._position(name, fix),
                    qos.latched(),
                )

    def _diagnostics(self, array: Any) -> None:
        for status in array.status:
            self.reported[status.name.split(":")[0].strip("/")] = time.monotonic()

    def _true(self, name: str, fix: Any) -> None:
        stamp_ns = nanoseconds(fix.header.stamp)
        self._truth[name].append((stamp_ns, fix.latitude, fix.longitude))
        self._controls.append((self._now_ns - stamp_ns) * 1e-6)

    def _position(self, name: str, fix: Any) -> None:
        """Take in a position; the latched one of a robot that is long gone counts as predicted."""
        arrived_s = time.monotonic()
        before_s = max((at for at, _ in self.last.values()), default=arrived_s)
        self.silent_s = max(self.silent_s, arrived_s - before_s)
        self.last[name] = (arrived_s, fix.status.status >= 0)
        if fix.status.status < 0:
            self._predicted += 1
            return
        stamp_ns = nanoseconds(fix.header.stamp)
        self._delays.append((self._now_ns - stamp_ns) * 1e-6)
        cov = fix.position_covariance
        sigma = math.sqrt(float(np.linalg.eigvalsh([[cov[0], cov[1]], [cov[1], cov[4]]])[-1]))
        self._waiting.append((stamp_ns, fix.latitude, fix.longitude, sigma))

    def _judge(self) -> None:
        now_ns = self._now_ns
        while self._waiting and not now_ns - _BEHIND_NS < self._waiting[0][0] < now_ns + _STEP_NS:
            stamp_ns, latitude, longitude, sigma = self._waiting.popleft()
            self._positions += 1
            places = [place for row in self._truth.values() if (place := _at(row, stamp_ns))]
            if not places:
                continue
            lat, lon = np.radians(np.array(places)).T
            here = np.radians([latitude, longitude])
            apart = geodesic_inverse(
                np.full_like(lat, here[0]), np.full_like(lon, here[1]), lat, lon
            )
            self._wrong += bool(np.min(apart[0]) > max(WRONG_M, WRONG_SIGMAS * sigma))


def _at(row: deque[tuple[int, float, float]], stamp_ns: int) -> tuple[float, float] | None:
    """Return the true latitude and longitude at a time, degrees; None where it is not known."""
    stamps = [entry[0] for entry in row]
    place = bisect.bisect_left(stamps, stamp_ns)
    if not 0 < place < len(stamps):
        return None
    (t0, *first), (t1, *second) = row[place - 1], row[place]
    share = (stamp_ns - t0) / max(1, t1 - t0)
    latitude, longitude = (a + share * (b - a) for a, b in zip(first, second, strict=True))
    return latitude, longitude


def _quantiles(values: list[float]) -> tuple[float, float]:
    if not values:
        return math.nan, math.nan
    middle, high = np.percentile(values, (50, 95))
    return float(middle), float(high)
