# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Samples of telemetry, as adapters hand them to the estimator; none knows a message type."""

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
        altitude: m in the datum that `fix.altitude_datum` names; NaN when unknown.
        covariance: (3, 3) East, North, Up in m², or None when the message gives none.
        valid: False when the receiver reports no fix (NavSatFix status -1).
    """

    stamp_ns: int
    latitude: float
    longitude: float
    altitude: float
    covariance: Array | None = None
    valid: bool = True


@dataclass(frozen=True)
class Orientation:
    """Body FLU or camera FLU relative to the frame that the input's reference names.

    Attributes:
        stamp_ns: time of validity, ns.
        quaternion: (4,) x, y, z, w.
        reference: of this sample, where the message itself says it (`earth`, `heading`, `body`);
            empty: as the configuration says.
    """

    stamp_ns: int
    quaternion: Array
    reference: str = ""


@dataclass(frozen=True)
class Scalar:
    """Height of the drone or level of the water.

    Attributes:
        stamp_ns: time of validity, ns.
        value: m, up positive.
    """

    stamp_ns: int
    value: float
