# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots that swim at known velocities, for tests of moored ones."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.models.platform_model import COUNT

KNOWN = 0.02**2


def swimming(*velocities):
    """Return a law of robots 10 m apart, whose velocities are known to 2 cm/s."""
    base = JointState(0.01 * np.eye(COUNT))
    n = len(velocities)
    state = np.zeros((n, 4))
    state[:, 0], state[:, 2:] = 10.0 * np.arange(n), velocities
    own = np.tile(np.diag([0.01, 0.01, KNOWN, KNOWN]), (n, 1, 1))
    base.append(np.arange(n), state, np.zeros((n, 4, COUNT)), own)
    return base
