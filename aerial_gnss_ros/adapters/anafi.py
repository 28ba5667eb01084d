# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parrot ANAFI (anafi_ros). Orientations are canonical messages in NWU axes, angles in degrees."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.core.config.telemetry import FixConfig
from aerial_gnss_ros.core.values.samples import Fix


def fix(msg: Any, stamp_ns: int, _config: FixConfig) -> Fix:
    """Return `drone/gps/location`, whose variances are in the order latitude, longitude.

    An unknown position is NaN, which the core refuses.
    """
    read = canonical.fix(msg, stamp_ns)
    if read.covariance is None:
        return read
    east_first = [1, 0, 2]
    return replace(read, covariance=read.covariance[east_first][:, east_first])
