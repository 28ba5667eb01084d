# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Origin of the frame `map`: a parameter, or where fixes agree."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.telemetry.plausibility import distance
from aerial_gnss_ros.core.telemetry.vertical_datum import describe_datums, ellipsoidal_altitude
from aerial_gnss_ros.core.values.estimates import MapDatum
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.samples import Fix

AGREED_S = 3.0
"""Time for which fixes must agree to settle the origin, s."""


class MapOrigin:
    """Sets the origin, which stays for as long as the program runs.

    The first accepted fix is a provisional origin, so that tracking starts at once. It is settled,
    and only then published, once fixes have agreed for `AGREED_S` or a robot is published. Until
    then, and if the drone turns out to be far away while no robot is known, the origin moves.

    Args:
        config: the origin, if given, and the altitude's datum.
        constant: the position of a camera on a mast.
        log: receives a sentence about the origin.
        former: the origin from before a restart of the node.

    Attributes:
        local: the frame `map`, None before the first accepted fix.
        trouble: why the configured origin is unusable, a sentence; empty if it is usable.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        constant: Fix | None,
        log: Events,
        former: MapDatum | None = None,
    ) -> None:
        self._config = config
        self._log = log
        self._explained = False
        self._settled = False
        self._given = not math.isnan(config.map.latitude_deg)
        self.local: LocalMap | None = None
        self._too_far_m = 0.0
        self.trouble = ""
        given = config.map
        if self._given:
            latitude, longitude = (
                math.radians(given.latitude_deg),
                math.radians(given.longitude_deg),
            )
            self._set(MapDatum(latitude, longitude, given.altitude_m))
            self._settle("as configured")
        elif constant is not None:
            self._set(self._at(constant))
            self._settle("the constant position")
        elif former is not None:
            self._set(former)
            self._settle("as before the restart")
        if constant is not None:
            self._explained = True
            log.add(describe_datums(constant, config.fix, config.height))

    @property
    def datum(self) -> MapDatum | None:
        """The origin, None until it is settled."""
        return None if self.local is None or not self._settled else self.local.datum

    def accept(self, fix: Fix, agreed_s: float, robots: bool) -> str:
        """Process a usable fix; return why it is too far from the origin, else empty.

        Args:
            fix: an accepted fix.
            agreed_s: time for which fixes have agreed, s.
            robots: whether robots are published.
        """
        if not self._explained:
            self._explained = True
            self._log.add(describe_datums(fix, self._config.fix, self._config.height))
        if self.local is None:
            self._set(self._at(fix))
        assert self.local is not None  # noqa: S101 - set above
        datum = self.local.datum
        away = distance((datum.latitude, datum.longitude), (fix.latitude, fix.longitude))
        most = self._config.limits.origin_distance_m
        if away > most and not self._given and not robots:
            if self._settled:
                self._log.add(f"The drone is {_km(away)} from the origin of map, which moves.")
            self._settled = False
            self._set(self._at(fix))
            away = 0.0
        if away <= most:
            self._too_far_m = 0.0
            if not self._settled and agreed_s >= AGREED_S:
                self._settle("where fixes agree")
            return ""
        self._too_far_m = away
        if agreed_s >= AGREED_S:
            self._refuse()
        return f"it is {_km(away)} from the origin of map (limits.origin_distance_m: {_km(most)})"

    def settle(self) -> None:
        """Settle the present origin: a robot is published in `map`, or the input has ended."""
        if self._too_far_m:
            self._refuse()
        if self.local is not None and not self._settled:
            self._settle("the first accepted fix")

    def covers(self, latitude: float, longitude: float) -> bool:
        """Return whether a position (rad) is close enough to the origin for `map` to be valid."""
        assert self.local is not None  # noqa: S101 - set by the first fix
        datum = self.local.datum
        away = distance((datum.latitude, datum.longitude), (latitude, longitude))
        return away <= self._config.limits.origin_distance_m

    def _refuse(self) -> None:
        """Report a configured origin that is too far from the last fix."""
        if self.trouble or not self._given or not self._too_far_m:
            return
        given = self._config.map
        self.trouble = (
            f"The origin of map ({given.latitude_deg:.7g}, {given.longitude_deg:.7g}) is "
            f"{_km(self._too_far_m)} from the drone, so no position can be given: correct "
            "map.latitude_deg and map.longitude_deg, or leave them out."
        )
        self._log.error(self.trouble)

    def _at(self, fix: Fix) -> MapDatum:
        altitude = ellipsoidal_altitude(fix, self._config.fix)
        return MapDatum(fix.latitude, fix.longitude, altitude)

    def _set(self, datum: MapDatum) -> None:
        self.local = LocalMap(datum)

    def _settle(self, source: str) -> None:
        assert self.local is not None  # noqa: S101 - settled after it is set
        self._settled = True
        datum = self.local.datum
        place = f"{math.degrees(datum.latitude):.7f}, {math.degrees(datum.longitude):.7f}"
        self._log.add(f"The origin of map is {place} ({source}).")


def _km(metres: float) -> str:
    return f"{metres * 1e-3:,.0f} km"
