# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of the published frames, and the height at which z of the map frame is 0."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.config.processing import MapConfig
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, RobotEstimate

EARTH = "earth"
"""Earth-centred, earth-fixed, as REP 105 calls it."""

WAVES_M2 = 0.25
"""Variance of z where z is 0 on the water by definition: half a metre of waves and body."""

ALTITUDE_M2 = 25.0
"""Variance of a known altitude, which is the drone's GNSS altitude less its height above the water:
five metres is the vertical error of a receiver without corrections. It is not estimated; message
fields that contain it say `approximated`."""

UNKNOWN_LENGTH_M2 = 1e6
"""Variance of an unknown coordinate: one sigma is a kilometre."""


@dataclass(frozen=True)
class Frames:
    """Names of frames, and the height of `map`.

    Attributes:
        map: the local frame, x east and y north.
        prefix: of robots' frames, such as `drone1/`.
        on_water: z is 0 on the water; False: at the configured altitude.
    """

    map: str = "map"
    prefix: str = ""
    on_water: bool = True

    def course(self, robot_id: str) -> str:
        """Return the frame at a robot whose x axis points along its course over ground."""
        return f"{self.prefix}{robot_id}/course"

    def up(self, estimate: RobotEstimate, datum: MapDatum | None) -> tuple[float, float]:
        """Return a robot's z in `map`, m, and its variance, m²; never NaN: viewers drop it."""
        if self.on_water:
            return 0.0, WAVES_M2
        up = estimate.altitude - (math.nan if datum is None else datum.altitude)
        return (0.0, UNKNOWN_LENGTH_M2) if math.isnan(up) else (up, ALTITUDE_M2)


def frames(config: MapConfig, namespace: str = "") -> Frames:
    """Return the frames of a node.

    Args:
        config: with `frame`, and the origin's altitude if given.
        namespace: of the node, so that frames of two drones differ.
    """
    inner = namespace.strip("/")
    prefix = f"{inner}/" if inner else ""
    return Frames(config.frame or f"{prefix}map", prefix, math.isnan(config.altitude_m))


class OnWater:
    """Places the published origin on the water, at the altitude that the first pose gives.

    The altitude then stays fixed like the origin; the receiver's altitude drifts by metres.

    Args:
        names: if `on_water` is False, nothing is changed.
    """

    def __init__(self, names: Frames) -> None:
        self._names = names
        self._place = (math.nan, math.nan)
        self._altitude = math.nan
        self._begun = False

    def leveled(self, result: FrameResult) -> FrameResult:
        """Return a result whose origin is on the water; without one until a pose is known."""
        if result.datum is None or not self._names.on_water:
            return result
        place = (result.datum.latitude, result.datum.longitude)
        if place != self._place:  # the core moves an origin only while no robot is published
            self._place, self._altitude, self._begun = place, math.nan, False
        if result.pose is not None:
            self._begun = True
            if math.isnan(self._altitude):
                self._altitude = result.pose.altitude - result.pose.height
        datum = replace(result.datum, altitude=self._altitude) if self._begun else None
        return replace(result, datum=datum)
