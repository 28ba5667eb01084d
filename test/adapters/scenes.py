# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Physical scenes: a drone, its camera and a robot on the water, by scipy and pymap3d alone.

Everything is in the words of a compass and a spirit level: heading clockwise from north, degrees
below the horizon. Nothing of the package is used, so its conversions cannot be wrong twice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymap3d
from scipy.spatial.transform import Rotation

FOCAL, WIDTH, HEIGHT = 900.0, 1280, 720
HIGH = 30.0  # the drone above the water, m; the water is where it took off
NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_TO_FLU = np.diag([1.0, -1.0, -1.0])
OPTICAL_FROM_FLU = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Scene:
    """One instant.

    Attributes:
        latitude_deg: of the drone.
        longitude_deg: of the drone.
        water_m: the water above the ellipsoid.
        heading_deg: of the nose.
        nose_up_deg: pitch of the body.
        right_down_deg: roll of the body.
        camera_heading_deg: where the camera looks, or the top of its image when it looks down.
        down_deg: of the camera below the horizon.
        camera_roll_deg: right side down.
    """

    latitude_deg: float
    longitude_deg: float
    water_m: float
    heading_deg: float
    nose_up_deg: float
    right_down_deg: float
    camera_heading_deg: float
    down_deg: float
    camera_roll_deg: float = 0.0

    @property
    def ned_body(self):
        """FRD of the body in NED, (3, 3)."""
        return _ned(self.heading_deg, self.nose_up_deg, self.right_down_deg)

    @property
    def ned_camera(self):
        """FRD of the camera in NED, (3, 3)."""
        return _ned(self.camera_heading_deg, -self.down_deg, self.camera_roll_deg)

    @property
    def level_camera(self):
        """FRD of the camera in level axes along the nose, (3, 3): MAVLink's vehicle frame."""
        return _ned(
            self.camera_heading_deg - self.heading_deg, -self.down_deg, self.camera_roll_deg
        )

    @property
    def body_camera(self):
        """FRD of the camera in the body's FRD, (3, 3)."""
        return self.ned_body.T @ self.ned_camera

    @property
    def altitude_m(self):
        """The drone above the ellipsoid, m."""
        return self.water_m + HIGH

    def robot(self):
        """Return latitude, longitude (deg) of a robot in view, and its pixel."""
        enu_camera = NED_TO_ENU @ self.ned_camera @ FRD_TO_FLU
        # near a chosen pixel below the middle, as on a plane; then exactly, on the ellipsoid
        ray = enu_camera @ OPTICAL_FROM_FLU.T @ [60.0 / FOCAL, 280.0 / FOCAL, 1.0]
        east, north = HIGH * ray[:2] / -ray[2]
        drone = self.latitude_deg, self.longitude_deg, self.altitude_m
        latitude, longitude, _ = pymap3d.enu2geodetic(east, north, -HIGH, *drone)
        to_robot = pymap3d.geodetic2enu(latitude, longitude, self.water_m, *drone)
        x, y, z = OPTICAL_FROM_FLU @ enu_camera.T @ to_robot
        assert z > 0.0
        pixel = FOCAL * x / z + WIDTH / 2, FOCAL * y / z + HEIGHT / 2
        assert 0.0 < pixel[0] < WIDTH
        assert 0.0 < pixel[1] < HEIGHT
        return latitude, longitude, pixel


def _ned(heading_deg, up_deg, right_down_deg):
    angles = [heading_deg, up_deg, right_down_deg]
    return Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()


BARBADOS = (13.194, -59.6415, -47.0)
PLACES = [
    (-33.85, 151.27, 22.0),
    (89.5, -20.0, 15.0),
    (-89.2, 100.0, -28.0),
    (-16.5, 179.9999, 55.0),  # the robot may lie on the other side
    (-16.5, -179.9999, 55.0),
    (0.001, 0.0, 17.0),  # a fix of 0, 0 is none
]


def scenes():
    """Yield scenes with their names: every quadrant, every depression, then every place."""
    tilts = [(0.0, 0.0), (-15.0, 0.0), (0.0, 15.0), (10.6, -10.6)]
    for i, heading in enumerate((33.0, 140.0, 231.0, 318.0)):
        for j, down in enumerate((0.0, 45.0, 85.0, 90.0)):
            nose_up, right_down = tilts[(i + j) % 4]
            aside = 40.0 if (i + j) % 2 else -40.0
            yield (
                f"nose{heading:.0f}_down{down:.0f}",
                Scene(*BARBADOS, heading, nose_up, right_down, heading + aside, down),
            )
    for place in PLACES:
        for heading, down, roll in ((200.0, 45.0, 3.0), (290.0, 0.0, 0.0)):
            yield (
                f"{place[0]:g},{place[1]:.0f}_down{down:.0f}",
                Scene(*place, heading, -15.0, 4.0, heading + 40.0, down, roll),
            )
