# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera on the command line: CameraInfo YAML, photo, known drone, or focal length and sensor."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from aerial_gnss_ros.adapters.camera_files import read_camera_file
from aerial_gnss_ros.adapters.photo_files import SUFFIXES, read_photo
from aerial_gnss_ros.core.camera.catalogue import KnownCamera, known_camera
from aerial_gnss_ros.core.camera.equivalent_focal_length import from_equivalent
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.paths import typed_path

_MM = 1e-3
_STABILISATION = (
    "Electronic stabilisation (RockSteady, HorizonSteady, EIS) crops and shifts every frame, "
    "which no CameraInfo can describe: switch it off. The gimbal's own stabilisation is fine."
)
_CROP = (
    "The sensor width must be that of the part which the image covers: a video that crops the "
    "sensor needs the smaller width."
)
_ZOOM = (
    "A zoom changes the focal length: fly at the zoom given here, or publish a CameraInfo that "
    "follows it."
)


@dataclass(frozen=True)
class ChosenCamera:
    """A camera and its warnings.

    Attributes:
        camera: the model.
        name: for a file.
        source: origin of the figures, in words.
        warnings: sentences about possible errors.
    """

    camera: CameraModel
    name: str
    source: str
    warnings: list[str] = field(default_factory=list)


def add_numbers(group: argparse._ArgumentGroup) -> None:
    """Add the arguments that describe a camera by numbers."""
    group.add_argument("--image-size", metavar="WxH", help="image size, px, such as 1920x1080")
    group.add_argument(
        "--focal-length-mm", type=float, metavar="MM", help="focal length at the zoom used, mm"
    )
    group.add_argument(
        "--sensor-width-mm",
        type=float,
        metavar="MM",
        help="width of the sensor that the image covers, mm",
    )


def chosen_camera(
    args: argparse.Namespace,
    given: str | None,
    size: tuple[int, int] | None = None,
    zoom: float = 1.0,
) -> ChosenCamera | None:
    """Return the camera that the arguments describe, or None.

    Args:
        args: with those of `add_numbers`.
        given: path of a CameraInfo YAML or of a photo, or the name of a known camera.
        size: of the images if already known (from a video), else None.
        zoom: factor on a known camera's focal length.

    Raises:
        InputError: arguments are missing, or contradict each other or the image size.
        CameraError: the description cannot be used.
    """
    asked = _size(args.image_size) if args.image_size else None
    if asked and size and asked != size:
        raise InputError(
            f"--image-size is {asked[0]}x{asked[1]}, but the video's frames are {size[0]}x{size[1]}"
            "; leave it out."
        )
    size = size or asked
    numbers = (args.focal_length_mm, args.sensor_width_mm)
    if given is None:
        return _from_numbers(args, size, asked is not None)
    if any(number is not None for number in numbers):
        raise InputError(
            f"a camera is given twice, as {given} and by focal length or sensor width; give one."
        )
    path = typed_path(given)
    if path.suffix.lower() in SUFFIXES:
        return _from_photo(path, size, zoom)
    if path.suffix in (".yaml", ".yml") or path.exists():
        return _from_file(path, size)
    return _from_table(known_camera(given), size, zoom)


def _from_numbers(
    args: argparse.Namespace, size: tuple[int, int] | None, asked: bool
) -> ChosenCamera | None:
    given = {
        "--image-size": size,
        "--focal-length-mm": args.focal_length_mm,
        "--sensor-width-mm": args.sensor_width_mm,
    }
    missing = [flag for flag, value in given.items() if value is None]
    if not asked and args.focal_length_mm is None and args.sensor_width_mm is None:
        return None
    if missing or size is None:
        raise InputError(f"a camera needs {', '.join(missing)} too; give all three or none.")
    camera = CameraModel.from_focal_length(
        args.focal_length_mm * _MM, args.sensor_width_mm * _MM, None, *size
    )
    source = f"{args.focal_length_mm:g} mm on a sensor {args.sensor_width_mm:g} mm wide, no lens"
    return ChosenCamera(
        camera,
        "camera",
        source + " distortion",
        [_CROP, _ZOOM, _STABILISATION],
    )


def _from_file(path: Path, size: tuple[int, int] | None) -> ChosenCamera:
    read = read_camera_file(path)
    camera = read.camera
    if size and size != (camera.width, camera.height):
        raise InputError(
            f"{path} describes images of {camera.width}x{camera.height}, but these are "
            f"{size[0]}x{size[1]}; calibrate with this image size."
        )
    return ChosenCamera(
        camera, read.name or "camera", f"{path}", [*_doubts(camera), _ZOOM, _STABILISATION]
    )


def _from_table(known: KnownCamera, size: tuple[int, int] | None, zoom: float) -> ChosenCamera:
    camera = known.camera(size, zoom)
    rounded = (
        f"From {known.source}: the equivalent focal length is a whole number, good to about 3 %, "
        "and no lens distortion is published. Calibrate for better."
    )
    warnings = [rounded]
    if known.is_cropped((camera.width, camera.height)):
        warnings.append(
            f"{camera.width}x{camera.height} has another aspect ratio than the photo "
            f"({known.photo[0]}x{known.photo[1]}): assumed to use the full sensor width with rows "
            "cut off. Modes that also crop the width (high frame rates, some 4K modes) have a "
            "longer focal length: compare with a photo."
        )
    if known.zooms or zoom != 1.0:
        warnings.append(_ZOOM)
    return ChosenCamera(camera, known.name, f"{known.product}, table", [*warnings, _STABILISATION])


def _from_photo(path: Path, size: tuple[int, int] | None, zoom: float) -> ChosenCamera:
    photo = read_photo(path)
    camera = from_equivalent(photo.equivalent_mm, photo.size, size or photo.size, zoom)
    guessed = (
        "Guessed from EXIF: the 35 mm focal length is taken by the photo's diagonal and is a whole "
        "number, good to about 3 %, and no lens distortion is published. Calibrate for better."
    )
    warnings = [guessed]
    if camera.width * photo.size[1] != camera.height * photo.size[0]:
        warnings.append(
            f"{camera.width}x{camera.height} has another aspect ratio than the photo "
            f"({photo.size[0]}x{photo.size[1]}): assumed to be cropped from it without scaling."
        )
    source = f"EXIF of {path}: {photo.equivalent_mm:g} mm in 35 mm, {photo.model or 'no model'}"
    return ChosenCamera(camera, photo.model or "camera", source, [*warnings, _ZOOM, _STABILISATION])


def _doubts(camera: CameraModel) -> list[str]:
    """Return sentences about implausible values in a calibration."""
    fx, fy, cx, cy = camera.K[0, 0], camera.K[1, 1], camera.K[0, 2], camera.K[1, 2]
    doubts = []
    if abs(fx / fy - 1.0) > 0.02:
        doubts.append(f"fx {fx:.1f} and fy {fy:.1f} px differ: are the images stretched?")
    off = max(abs(cx / camera.width - 0.5), abs(cy / camera.height - 0.5))
    if off > 0.05:
        doubts.append(
            f"The principal point ({cx:.0f}, {cy:.0f}) is far from the image centre: was this "
            "calibrated at another image size, or on a cropped image?"
        )
    if not np.any(camera.D):
        doubts.append(
            "It has no lens distortion: plausible for a simulation, rare for a real lens."
        )
    return doubts


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)[xX](\d+)", text)
    if match is None:
        raise InputError(f"--image-size must be such as 1920x1080, not {text!r}.")
    return int(match[1]), int(match[2])
