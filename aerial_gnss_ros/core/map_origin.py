# SPDX-License-Identifier: Apache-2.0
"""Where the origin of the frame `map` lies: a parameter, or the first accepted fix."""

from __future__ import annotations

import math

from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.datum import ellipsoidal_altitude, explained
from aerial_gnss_ros.core.events import Events
from aerial_gnss_ros.core.local_map import LocalMap
from aerial_gnss_ros.core.values import Fix, MapDatum


class MapOrigin:
    """Sets the origin once; it stays for as long as the program runs.

    Args:
        config: the origin, where it is given, and the altitude's datum.
        constant: the position of a camera on a mast.
        log: is told where the origin lies.

    Attributes:
        local: the frame `map`, None before the first accepted fix.
    """

    def __init__(self, config: EstimatorConfig, constant: Fix | None, log: Events) -> None:
        self._config = config
        self._log = log
        self._explained = False
        self.local: LocalMap | None = None
        given = config.map
        if not math.isnan(given.latitude_deg):
            latitude, longitude = (
                math.radians(given.latitude_deg),
                math.radians(given.longitude_deg),
            )
            self._set(MapDatum(latitude, longitude, given.altitude_m), "as configured")
        elif constant is not None:
            self._set(self._at(constant), "the constant position")
        if constant is not None:
            self._explained = True
            log.add(explained(constant, config.fix, config.height))

    @property
    def datum(self) -> MapDatum | None:
        """The origin, None before the first accepted fix."""
        return None if self.local is None else self.local.datum

    def accept(self, fix: Fix) -> None:
        """Take a usable fix: the first one becomes the origin where none is configured."""
        if not self._explained:
            self._explained = True
            self._log.add(explained(fix, self._config.fix, self._config.height))
        if self.local is None:
            self._set(self._at(fix), "the first accepted fix")

    def _at(self, fix: Fix) -> MapDatum:
        altitude = ellipsoidal_altitude(fix, self._config.fix)
        return MapDatum(fix.latitude, fix.longitude, altitude)

    def _set(self, datum: MapDatum, source: str) -> None:
        self.local = LocalMap(datum)
        place = f"{math.degrees(datum.latitude):.7f}, {math.degrees(datum.longitude):.7f}"
        self._log.add(f"The origin of map is {place} ({source}).")
