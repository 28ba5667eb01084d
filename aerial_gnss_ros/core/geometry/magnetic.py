# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Magnetic declination (World Magnetic Model), for headings measured from magnetic north."""

from __future__ import annotations

import datetime as dt
import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from pygeomag import GeoMag

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.core.values.errors import InputError

Array = NDArray[np.float64]

_FIRST_YEAR, _END_YEAR = 2010.0, 2030.0


def decimal_year(stamp_ns: int) -> float:
    """Return the UTC year with its fraction of a time in ns since 1970."""
    moment = dt.datetime.fromtimestamp(stamp_ns // 1_000_000_000, tz=dt.timezone.utc)
    begin = dt.datetime(moment.year, 1, 1, tzinfo=dt.timezone.utc)
    end = dt.datetime(moment.year + 1, 1, 1, tzinfo=dt.timezone.utc)
    return moment.year + (moment - begin) / (end - begin)


def declination(latitude: float, longitude: float, stamp_ns: int, altitude: float = 0.0) -> float:
    """Return the angle of magnetic north east of true north, rad.

    Within a day and about a kilometre it changes by less than 0.01 deg (away from the magnetic
    poles), so one value suffices.

    Args:
        latitude: rad.
        longitude: rad.
        stamp_ns: ns since 1970 UTC.
        altitude: m; 1000 m change it by a few thousandths of a degree. NaN counts as 0.

    Raises:
        InputError: the time lies outside the years that the model covers.
    """
    year = decimal_year(stamp_ns)
    if not _FIRST_YEAR <= year < _END_YEAR:
        raise InputError(
            f"The World Magnetic Model at hand covers {_FIRST_YEAR:.0f} to {_END_YEAR:.0f}, but "
            f"the telemetry is stamped {year:.1f}; use a clock that shows the date, or correct the "
            "heading at its source and set attitude.north to true."
        )
    height = 0.0 if math.isnan(altitude) else altitude
    return _cached(
        round(math.degrees(latitude), 2),
        round(math.degrees(longitude), 2),
        round(height / 1000.0),
        round(year * 365.0),
    )


@lru_cache(maxsize=256)
def _cached(latitude_deg: float, longitude_deg: float, altitude_km: int, day: int) -> float:
    year = min(day / 365.0, _END_YEAR - 0.001)
    field = _model(int(year) // 5 * 5).calculate(
        glat=latitude_deg, glon=longitude_deg, alt=altitude_km, time=year
    )
    return math.radians(field.d)


@lru_cache(maxsize=4)
def _model(base_year: int) -> GeoMag:
    return GeoMag(base_year=base_year)


def true_from_magnetic(magnetic_from_flu: Array, declination_rad: float) -> Array:
    """Return a body's orientation in ENU from one whose north is magnetic, (3, 3).

    True heading is magnetic heading plus declination; yaw counts the other way round.
    """
    turn = matrix_from_rpy(0.0, 0.0, -declination_rad)
    turned: Array = turn @ magnetic_from_flu
    return turned
