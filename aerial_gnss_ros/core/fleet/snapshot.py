# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One image of one drone by itself: where its robots are for any errors of the drone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.shared_state import white_on_water
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.models.measurement_model import on_water, pose_jacobian

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Placed:
    """Robots of an image, linearised at some errors.

    Attributes:
        places: (m, 2) East, North, m, at these errors.
        by_errors: (m, 2, 9) derivatives.
        white: (m, 2, 2) covariances that white noise causes, m².
    """

    places: Array
    by_errors: Array
    white: Array

    def some(self, rows: NDArray[np.intp]) -> Placed:
        """Return some of them."""
        return Placed(self.places[rows], self.by_errors[rows], self.white[rows])


class Snapshot:
    """The boxes of the robots that a drone's last image measured.

    Args:
        drone: with a last sighting.
        labels: those of its robots that count.
    """

    def __init__(self, drone: Drone, labels: list[str]) -> None:
        seen, view = drone.last, drone.view
        assert seen is not None  # noqa: S101 - the caller's part
        assert view is not None  # noqa: S101 - comes with it
        boxes = [seen.labels.index(label) for label in labels]
        self.drone, self.labels = drone, labels
        self.class_ids = [seen.class_ids[k] for k in boxes]
        self.scene_ns = seen.pose.stamp_ns
        self._view: CameraView = view
        self._level = seen.level
        self._rays = seen.camera.rays(seen.pixels[boxes])[0] @ FLU_FROM_OPTICAL.T

    def placed(self, errors: Array) -> Placed:
        """Return the robots for errors (9,) of the drone."""
        view, pose = self._view, self._view.pose(errors)
        places = on_water(pose, self._rays @ pose.rotation.T)
        points = on_water_surface(places)
        points[:, 2] -= errors[2]
        by_errors = pose_jacobian(points - view.standpoint(errors)) @ view.by_errors
        white = white_on_water(linearise(view, errors, places), self.drone.model, self._level)
        return Placed(places, by_errors, white)
