# SPDX-License-Identifier: Apache-2.0
"""Fits the platform's errors to a recording.

The latency is searched first on a coarse grid, for it is the one unknown whose errors reach beyond
what a straight line tells. An error that the data leave open gets the noise set's own sigma as its
prior in a second fit, so that the others are as unsure as its being unknown makes them.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from aerial_gnss_ros.calibration.fit import UNKNOWNS, Fit
from aerial_gnss_ros.calibration.problem import Problem
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.errors import InputError
from aerial_gnss_ros.core.words import counted

LEAST_IMAGES = 20


def calibrate(
    recording: Recording,
    config: EstimatorConfig,
    *,
    focal: bool = False,
    robot_speed: float = 0.0,
    progress: Callable[[int], None] = lambda _done: None,
) -> Fit:
    """Fit all constants.

    Args:
        recording: after the replay.
        config: that it was made with.
        focal: estimate the focal length too.
        robot_speed: how fast robots may move, m/s; 0: each stays where it is.
        progress: called with a growing number.

    Raises:
        InputError: too few robots were seen.
    """
    if len(recording.sightings) < LEAST_IMAGES:
        raise InputError(
            f"robots were confirmed in {counted(len(recording.sightings), 'image')}, and a "
            f"calibration needs {LEAST_IMAGES} at least; record a robot that is seen for longer."
        )
    names = tuple(one.name for one in UNKNOWNS if focal or one.name != "focal")
    problem = Problem(recording, config, names, robot_speed)
    start = problem.search(progress)
    first = problem.fit(start, frozenset())
    open_ones = frozenset(name for name in names if not first.determined(name))
    if not open_ones or open_ones == set(names):
        return first
    second = problem.fit(problem.last, open_ones)
    # What is open stays as open as the wide prior found it.
    return _opened(second, first, open_ones)


def _opened(second: Fit, first: Fit, open_ones: frozenset[str]) -> Fit:
    covariance = second.covariance.copy()
    for name in open_ones:
        at = second.names.index(name)
        ratio = math.sqrt(first.covariance[at, at] / covariance[at, at])
        covariance[at] *= ratio
        covariance[:, at] *= ratio
    return Fit(second.names, second.mean, covariance, second.residual_px, second.boxes,
               second.outliers, second.images, second.robots)  # fmt: skip
