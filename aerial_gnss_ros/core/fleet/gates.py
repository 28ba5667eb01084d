# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes fit the robots that their drone says they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.innovation import pair_innovations
from aerial_gnss_ros.core.filter.linearization import CameraView, relinearize
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.shared_state import SharedState, white_on_water
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.models.motion_model import TUNING as MOTION_MODEL
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel
from aerial_gnss_ros.core.numerics.gaussian import mahalanobis

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GatesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    gate: float = 27.6
    """Squared Mahalanobis distance beyond which a box is only used if its robot may have turned:
    one in a million. Nearer outliers are down-weighted by the update."""


TUNING = GatesTuning()


@dataclass(frozen=True)
class Fit:
    """How a box fits its robot.

    Attributes:
        squared: squared Mahalanobis distance.
        offset: (2,) from the robot to the box, East, North, m.
        spread: (2, 2) covariance of that, m².
    """

    squared: float
    offset: Array
    spread: Array

    def after_turn(self, speed: float) -> float:
        """Return the squared Mahalanobis distance from a robot that may have turned.

        Args:
            speed: one sigma of the change of velocity, each axis, m/s.
        """
        turned = (MOTION_MODEL.swerve_s * speed) ** 2 * np.eye(2)
        return float(self.offset @ np.linalg.solve(self.spread + turned, self.offset))


def fitting(
    state: SharedState, seen: Sighting, view: CameraView, model: PlatformModel,
    slots: dict[int, int],
) -> dict[int, Fit]:  # fmt: skip
    """Return how each box fits its robot.

    Args:
        state: the filter, after `look` at this image.
        seen: the image.
        view: its camera.
        model: white noise of pose and boxes.
        slots: places of the robots by box.
    """
    joint, boxes = state.joint, list(slots)
    rays = seen.camera.rays(seen.pixels[boxes])[0] @ FLU_FROM_OPTICAL.T
    places, by_errors = relinearize(joint, view, rays)
    linear = linearise(view, joint.mean[:COUNT], places)
    white = white_on_water(linear, model, seen.level)
    own = np.array([slots[box] for box in boxes])
    pairs = pair_innovations(joint, places, by_errors, white, math.inf, math.inf)
    wanted = np.flatnonzero(pairs.rows == own[pairs.columns])
    offsets, spreads = pairs.offsets[wanted], pairs.spread[wanted]
    squared, _ = mahalanobis(offsets, spreads)
    fits = zip(pairs.columns[wanted].tolist(), squared.tolist(), offsets, spreads, strict=True)
    return {boxes[column]: Fit(*fit) for column, *fit in fits}


def usable(
    joint: JointState, robots: list[FleetRobot], fits: dict[int, Fit], slots: dict[int, int],
    speed: float, threshold: float,
) -> list[int]:  # fmt: skip
    """Return the boxes that can be used; widen the velocities of robots that may have turned.

    As a drone's own estimator does (see `Matcher`), so that one drone's fleet is that estimator.

    Args:
        joint: the state; velocities are widened in place.
        robots: of it.
        fits: by box.
        slots: places of the robots by box.
        speed: one sigma of a sudden change of velocity, each axis, m/s.
        threshold: squared Mahalanobis distance beyond which a robot has turned.
    """
    found: list[int] = []
    for box, fit in fits.items():
        turned = fit.squared > threshold and not robots[slots[box]].tentative
        if (fit.after_turn(speed) if turned else fit.squared) > TUNING.gate:
            continue
        if turned:
            joint.inflate_velocities(np.array([slots[box]]), speed, MOTION_MODEL.swerve_s)
        found.append(box)
    return found
