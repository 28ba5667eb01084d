# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cameras of common drones, from published data: equivalent focal length, photo size.

Sources are the makers' specification pages (section Camera). The equivalent focal length is a whole
number of millimetres and no lens distortion is published, so a calibration is better: against the
calibrated cameras of github Theta-Limited/DroneModels these differ by 1 % (Mavic 3, Mini 3 Pro,
Mavic 3T), 3 % (Phantom 4 Pro, Mavic 2 Pro) and, the worst one found, 8 % (Mini 4 Pro).
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass

from aerial_gnss_ros.core.camera.equivalent_focal_length import from_equivalent
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import CameraError

_FULL_4_3, _MINI_4_3, _ONE_INCH = (4000, 3000), (4032, 3024), (5472, 3648)


@dataclass(frozen=True)
class KnownCamera:
    """A drone's camera.

    Attributes:
        name: as on the command line.
        product: the product's name.
        equivalent_mm: focal length of photos, equivalent on 35 mm film, mm, at zoom 1.
        photo: width and height of the full photo, px.
        video_equivalent_mm: for video, if the maker states a different one.
        zooms: whether it has an optical zoom.
    """

    name: str
    product: str
    equivalent_mm: float
    photo: tuple[int, int]
    video_equivalent_mm: float | None = None
    zooms: bool = False

    @property
    def source(self) -> str:
        """Source of the figures."""
        maker = self.product.split(" ", 1)[0]
        return f"{maker}'s specifications of the {self.product}"

    def is_cropped(self, image: tuple[int, int]) -> bool:
        """Whether an image has another aspect ratio than the photo."""
        return abs(image[0] * self.photo[1] / (image[1] * self.photo[0]) - 1.0) > 0.01

    def camera(self, image: tuple[int, int] | None = None, zoom: float = 1.0) -> CameraModel:
        """Return the camera for an image size, by default the photo's.

        Raises:
            CameraError: a size or zoom that is not positive.
        """
        size = image or self.photo
        video = self.is_cropped(size) and self.video_equivalent_mm is not None
        focal = self.video_equivalent_mm if video else self.equivalent_mm
        assert focal is not None  # noqa: S101 - as `video` says
        return from_equivalent(focal, self.photo, size, zoom)


KNOWN = {
    camera.name: camera
    for camera in (
        KnownCamera("dji_phantom_4", "DJI Phantom 4", 20.0, _FULL_4_3),
        KnownCamera("dji_phantom_4_pro", "DJI Phantom 4 Pro", 24.0, _ONE_INCH),
        KnownCamera("dji_phantom_4_rtk", "DJI Phantom 4 RTK", 24.0, _ONE_INCH),
        KnownCamera("dji_mavic_pro", "DJI Mavic Pro", 26.0, _FULL_4_3),
        KnownCamera("dji_mavic_2_pro", "DJI Mavic 2 Pro", 28.0, _ONE_INCH),
        KnownCamera("dji_mavic_2_zoom", "DJI Mavic 2 Zoom", 24.0, _FULL_4_3, zooms=True),
        KnownCamera("dji_mavic_air_2", "DJI Mavic Air 2", 24.0, _FULL_4_3),
        KnownCamera("dji_air_2s", "DJI Air 2S", 22.0, _ONE_INCH),
        KnownCamera("dji_mavic_mini", "DJI Mavic Mini", 24.0, _FULL_4_3),
        KnownCamera("dji_mini_2", "DJI Mini 2", 24.0, _FULL_4_3),
        KnownCamera("dji_mini_3_pro", "DJI Mini 3 Pro", 24.0, _MINI_4_3),
        KnownCamera("dji_mini_4_pro", "DJI Mini 4 Pro", 24.0, _MINI_4_3),
        KnownCamera("dji_mavic_3", "DJI Mavic 3 (wide camera)", 24.0, (5280, 3956)),
        KnownCamera("dji_mavic_3e", "DJI Mavic 3 Enterprise (wide camera)", 24.0, (5280, 3956)),
        KnownCamera("dji_mavic_3t", "DJI Mavic 3 Thermal (wide camera)", 24.0, _FULL_4_3),
        KnownCamera("dji_m30", "DJI Matrice 30 (wide camera)", 24.0, _FULL_4_3),
        KnownCamera("dji_h20_wide", "DJI Zenmuse H20 (wide camera)", 24.0, (4056, 3040)),
        KnownCamera("parrot_anafi", "Parrot ANAFI", 23.0, (5344, 4016), 26.0, zooms=True),
    )
}


def known_camera(name: str) -> KnownCamera:
    """Return a camera by its name, ignoring spaces, dashes and capitals.

    Raises:
        CameraError: no camera of that name; the message lists them.
    """
    wanted = "_".join(name.lower().replace("-", " ").replace("_", " ").split())
    if wanted in KNOWN:
        return KNOWN[wanted]
    near = difflib.get_close_matches(wanted, KNOWN, n=1)
    meant = f" (did you mean {near[0]}?)" if near else ""
    raise CameraError(
        f"{name!r} is not a known camera{meant}; known are {', '.join(KNOWN)}. Otherwise give a "
        "CameraInfo YAML, or focal length and sensor width."
    )
