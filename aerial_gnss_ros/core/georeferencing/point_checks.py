# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Geometric checks of boxes: size, and position inside the area of operation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.area_of_operation import Polygon
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.georeferencing.apparent_size import SizeCheck, wrong_size
from aerial_gnss_ros.core.georeferencing.area import AreaOfOperation
from aerial_gnss_ros.core.georeferencing.localization import WaterPoints, mask_refused
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason

ELSEWHERE_M = 10_000.0
"""Distance of the drone beyond which its area of operation must be wrong, m."""

_TOPIC = "area"


class PointChecks:
    """Refuses points whose position or size excludes a robot.

    Args:
        config: `classes.<name>.length_m`.
        polygons: the area of operation; none: everywhere.
        log: receives a warning about a distant area.

    Attributes:
        used: whether anything is checked.
    """

    def __init__(self, config: EstimatorConfig, polygons: tuple[Polygon, ...], log: Events) -> None:
        self._area = AreaOfOperation(polygons) if polygons else None
        self._polygons = polygons
        self._size = SizeCheck(config)
        self.used = self._area is not None or self._size.used
        self._log = log

    def apply(self, frame: PosedFrame, points: WaterPoints) -> WaterPoints:
        """Return the points with `outside_area` and `wrong_size` as reasons where they apply.

        Where a length is stated, they have the sizes of their boxes as well.
        """
        if self._size.used:
            points = replace(points, sizes=self._size.fit(frame, points))
        reasons = list(points.reasons)
        for reason, wrong in self._wrong(frame, points):
            for row in np.flatnonzero(wrong).tolist():
                reasons[row] = reasons[row] or reason
        if tuple(reasons) == points.reasons:
            return points
        return mask_refused(replace(points, reasons=tuple(reasons)))

    def _wrong(
        self, frame: PosedFrame, points: WaterPoints
    ) -> list[tuple[Reason, NDArray[np.bool_]]]:
        found = []
        if self._area is not None:
            outside = self._area.outside(points)
            found.append((Reason.OUTSIDE_AREA, outside))
            # A drone that sees any box inside is not far from it.
            every = np.count_nonzero(outside) == points.reasons.count(None)
            if every and not self._log.warned(_TOPIC):
                self._tell_elsewhere(self._area, frame.pose)
        if points.sizes is not None:
            found.append((Reason.WRONG_SIZE, wrong_size(points.sizes, points.valid)))
        return found

    def _tell_elsewhere(self, area: AreaOfOperation, pose: CameraPose) -> None:
        """Report once that the drone is far from its area."""
        away = area.distance(pose.latitude, pose.longitude)
        if away <= ELSEWHERE_M:
            return
        swapped = False
        if _swappable(self._polygons):
            near = AreaOfOperation(_swapped(self._polygons))
            swapped = near.distance(pose.latitude, pose.longitude) <= ELSEWHERE_M
        self._log.warn_once(
            _TOPIC,
            f"The area of operation (detections.area) is {away * 1e-3:,.0f} km from the drone, so "
            "all boxes are refused as outside_area; "
            + (
                "its latitudes and longitudes are swapped: GeoJSON has longitude first."
                if swapped
                else "give the area of this site, or leave it out."
            ),
        )


def _swappable(polygons: tuple[Polygon, ...]) -> bool:
    """Return whether latitudes and longitudes could have been swapped."""
    return bool(polygons) and all(
        (np.abs(ring[:, 0]) <= 90.0).all() for polygon in polygons for ring in polygon
    )


def _swapped(polygons: tuple[Polygon, ...]) -> tuple[Polygon, ...]:
    return tuple(tuple(ring[:, ::-1] for ring in polygon) for polygon in polygons)
