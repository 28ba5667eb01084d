# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Samples of telemetry, as adapters pass them to the estimator, independent of message types."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fix:
    """The drone's GNSS position.

    Attributes:
        stamp_ns: time of validity, ns.
        latitude: rad, WGS84.
        longitude: rad, WGS84.
        altitude: m in the datum `fix.altitude_datum`; NaN if unknown.
        covariance: (3, 3) East, North, Up in m², or None if the message has none.
        valid: False if the receiver reports no fix (NavSatFix status -1).
        jumped: East and North by which the receiver has jumped so far, m; empty: it has not.
    """

    stamp_ns: int
    latitude: float
    longitude: float
    altitude: float
    covariance: Array | None = None
    valid: bool = True
    jumped: tuple[float, ...] = ()


@dataclass(frozen=True)
class Orientation:
    """Body FLU or camera FLU relative to the frame that the input's reference names.

    Attributes:
        stamp_ns: time of validity, ns.
        quaternion: (4,) x, y, z, w.
        reference: of this sample if the message states it (`earth`, `heading`, `body`); empty: as
            configured.
        jumped: angle by which the sensor has jumped so far, rad; empty: it has not.
    """

    stamp_ns: int
    quaternion: Array
    reference: str = ""
    jumped: tuple[float, ...] = ()


@dataclass(frozen=True)
class Scalar:
    """Height of the drone or level of the water.

    Attributes:
        stamp_ns: time of validity, ns.
        value: m, up positive.
        jumped: by how much the sensor has jumped so far, m; empty: it has not.
    """

    stamp_ns: int
    value: float
    jumped: tuple[float, ...] = ()
