# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Height of mean sea level above the WGS84 ellipsoid: the EGM96 geoid on its 15' grid."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError

GRID = Path(__file__).parent / "data" / "egm96_15min.npz"
_STEP_DEG = 0.25


def undulation(latitude: float, longitude: float) -> float:
    """Return the height of mean sea level above the ellipsoid, m.

    Add it to an altitude above mean sea level to get one above the ellipsoid. Cubic convolution
    (Keys 1981) over the 16 grid points around. NGA's own interpolation of the same grid differs by
    up to 1.2 cm on its six published points; the model itself is good to 0.5 to 1 m (rms).

    Args:
        latitude: rad.
        longitude: rad, any turn.

    Raises:
        InputError: the grid is missing from the installation, or the position is not on Earth.
    """
    if not (abs(latitude) <= 0.5 * math.pi and math.isfinite(longitude)):
        raise InputError(f"{latitude}, {longitude} rad is not on Earth; it has no sea level.")
    grid = _grid()
    row = (math.degrees(latitude) + 90.0) / _STEP_DEG
    column = (math.degrees(longitude) + 180.0) % 360.0 / _STEP_DEG
    top, left = math.floor(row), math.floor(column)
    rows = np.clip(np.arange(top - 1, top + 3), 0, grid.shape[0] - 1)
    columns = np.arange(left - 1, left + 3) % grid.shape[1]
    patch = grid[np.ix_(rows, columns)].astype(np.float64)
    return 0.01 * float(_weights(row - top) @ patch @ _weights(column - left))


def _weights(t: float) -> NDArray[np.float64]:
    """Return the weights of the points at -1, 0, 1, 2 for a position `t` (0 to 1)."""
    return np.array(
        [
            t * (-0.5 + t * (1.0 - 0.5 * t)),
            1.0 + t * t * (1.5 * t - 2.5),
            t * (0.5 + t * (2.0 - 1.5 * t)),
            t * t * (0.5 * t - 0.5),
        ]
    )


@lru_cache(maxsize=1)
def _grid() -> NDArray[np.int16]:
    """Return centimetres (721, 1440): from the South Pole north, from 180 deg west eastward."""
    try:
        with np.load(GRID) as file:
            differences = file["differences"]
    except OSError as error:
        raise InputError(
            f"{GRID} is missing, so altitudes above mean sea level cannot be converted; install "
            "the package again."
        ) from error
    # Differences along and across compress to a third; int16 wraps back to the true sum.
    rows = np.cumsum(differences, axis=0, dtype=np.int16)
    return np.cumsum(rows, axis=1, dtype=np.int16)
