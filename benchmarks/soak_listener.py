# SPDX-License-Identifier: Apache-2.0
"""Hears positions and the truth for as long as a soak lasts."""

from __future__ import annotations

import bisect
import math
from collections import deque
from typing import Any

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import NavSatFix

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.geodesy import geodesic_inverse
from aerial_gnss_ros.nodes import qos

WRONG_M, WRONG_SIGMAS = 5.0, 4.0
_LOOK_S = 1.0
_KEPT = 400  # of the truth of each robot: several seconds
_BEHIND_NS = 1_000_000_000  # by then the truth of a position has arrived


class Listener(Node):  # type: ignore[misc]  # rclpy has no complete types
    """Compares each position with every true robot; `minute` tells and begins anew."""

    def __init__(self) -> None:
        super().__init__("soak")
        self._known: set[str] = set()
        self._truth: dict[str, deque[tuple[int, float, float]]] = {}
        self._waiting: deque[tuple[int, float, float, float]] = deque()
        self.names: set[str] = set()
        self._clear()
        self.create_timer(_LOOK_S, self._look)
        self.create_timer(_LOOK_S, self._judge)

    def _clear(self) -> None:
        self._delays: list[float] = []
        self._controls: list[float] = []
        self._positions = self._wrong = self._predicted = 0

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
                self.create_subscription(NavSatFix, topic, self._position, qos.latched())

    def _true(self, name: str, fix: Any) -> None:
        stamp_ns = nanoseconds(fix.header.stamp)
        self._truth[name].append((stamp_ns, fix.latitude, fix.longitude))
        self._controls.append((self._now_ns - stamp_ns) * 1e-6)

    def _position(self, fix: Any) -> None:
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
        while self._waiting and self._waiting[0][0] < now_ns - _BEHIND_NS:
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
