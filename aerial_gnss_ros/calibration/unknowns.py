# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Indices of the constants among the unknowns, and of the processes.

Constants: latency, delay of fixes against orientations, logarithm of the focal scale, errors of
height, roll, pitch and heading.
"""

from __future__ import annotations

import math

LATENCY, FIX_DELAY, FOCAL, FIRST_ERROR = 0, 1, 2, 3
CONSTANTS = ("height", "gimbal_roll", "gimbal_pitch", "heading")
GLOBALS = FIRST_ERROR + len(CONSTANTS)
"""Number of constants; they come before all other unknowns."""
PRIOR_SIGMAS = (100.0, 0.5, 0.05, 5.0, math.radians(5.0), math.radians(5.0), math.radians(20.0))
"""Prior sigmas of the constants: s, s, 1, m, rad, rad, rad."""

POINTING, BOX, FIRST_ROBOT = 0, 1, 2
"""Processes whose sigma is estimated: pointing errors, errors of boxes, each robot's velocity."""
DRIFT, FIXED = -2, -1
"""Parts of the precision that do not depend on these sigmas: drifts, and other fixed parts."""
