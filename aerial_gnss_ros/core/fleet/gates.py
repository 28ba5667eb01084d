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
from aerial_gnss_ros.core.filter.update import linearise
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


def fitting(
    state: SharedState, seen: Sighting, view: CameraView, model: PlatformModel,
    slots: dict[int, int], speed: float,
) -> list[int]:  # fmt: skip
    """Return the boxes that fit their robots; widen the velocities of robots that may turn.

    Args:
        state: the filter, after `look` at this image.
        seen: the image.
        view: its camera.
        model: white noise of pose and boxes.
        slots: places of the robots by box.
        speed: one sigma of a sudden change of velocity, each axis, m/s.
    """
    joint, boxes = state.joint, list(slots)
    rays = seen.camera.rays(seen.pixels[boxes])[0] @ FLU_FROM_OPTICAL.T
    places, by_errors = relinearize(joint, view, rays)
    linear = linearise(view, joint.mean[:COUNT], places)
    white = white_on_water(linear, model, seen.level)
    pairs = pair_innovations(joint, places, by_errors, white, math.inf, math.inf)
    squared, _ = mahalanobis(pairs.offsets, pairs.spread)
    found: list[int] = []
    for p, (row, column) in enumerate(zip(pairs.rows, pairs.columns, strict=True)):
        box, fits = boxes[column], float(squared[p])
        if slots[box] != row:
            continue
        if fits > TUNING.gate:
            turned = (MOTION_MODEL.swerve_s * speed) ** 2 * np.eye(2)
            offset = pairs.offsets[p]
            fits = float(offset @ np.linalg.solve(pairs.spread[p] + turned, offset))
            if fits <= TUNING.gate:
                joint.inflate_velocities(np.array([row]), speed, MOTION_MODEL.swerve_s)
        if fits <= TUNING.gate:
            found.append(box)
    return found
