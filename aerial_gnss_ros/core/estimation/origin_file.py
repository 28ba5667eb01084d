# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keeps the origin of `map` over the restart of a node: `odom` goes on in the same frame."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from pathlib import Path

from aerial_gnss_ros.core.values.estimates import MapDatum

_MOST_BYTES = 10_000


class OriginKeeper:
    """Writes the origin when it changes; file errors are ignored.

    Args:
        session: file of this session's labels, beside which the origin's is; None: nothing is kept.
    """

    def __init__(self, session: Path | None) -> None:
        self._path = None if session is None else session.with_suffix(".origin.json")
        self._kept: MapDatum | None = None

    def load(self) -> MapDatum | None:
        """Return the origin from before the restart, or None."""
        if self._path is None:
            return None
        with suppress(OSError, ValueError, TypeError):
            with self._path.open(encoding="utf-8") as stream:
                latitude, longitude, altitude = json.loads(stream.read(_MOST_BYTES))
            altitude = math.nan if altitude is None else float(altitude)
            datum = MapDatum(math.radians(latitude), math.radians(longitude), altitude)
            if abs(latitude) <= 90.0 and abs(longitude) <= 180.0:
                self._kept = datum
        return self._kept

    def keep(self, datum: MapDatum | None) -> None:
        """Write the origin if it has changed."""
        if self._path is None or datum is None or datum is self._kept:
            return
        self._kept = datum
        altitude = datum.altitude if math.isfinite(datum.altitude) else None
        text = json.dumps([math.degrees(datum.latitude), math.degrees(datum.longitude), altitude])
        partial = self._path.with_suffix(".partial")
        with suppress(OSError):  # the labels' file reports write errors
            partial.write_text(text, encoding="utf-8")
            partial.replace(self._path)
