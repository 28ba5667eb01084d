# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera data from a photo's EXIF."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

from aerial_gnss_ros.core.values.errors import InputError

SUFFIXES = (".jpg", ".jpeg")
_FORMATS = ("JPEG", "MPO")  # MPO: some drones append a second, smaller JPEG
_EXIF_IFD, _FOCAL_EQUIVALENT, _MODEL = 0x8769, 0xA405, 0x0110


@dataclass(frozen=True)
class Photo:
    """Camera data of a photo.

    Attributes:
        size: width and height, px.
        equivalent_mm: 35 mm equivalent focal length, mm.
        model: the camera's name, or "".
    """

    size: tuple[int, int]
    equivalent_mm: float
    model: str


def read_photo(path: Path) -> Photo:
    """Read a photo's EXIF.

    Raises:
        InputError: the file is missing or not an image, or its EXIF has no 35 mm focal length.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings(), Image.open(path, formats=_FORMATS) as image:
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            size, exif = image.size, image.getexif()  # neither decodes the pixels of a JPEG
            equivalent = exif.get_ifd(_EXIF_IFD).get(_FOCAL_EQUIVALENT, 0)
    except FileNotFoundError as error:
        raise InputError(f"{path} does not exist; give a photo of the camera.") from error
    except Exception as error:  # Pillow raises arbitrary exceptions on damage
        raise InputError(f"{path} is not a readable photo; give a JPEG.") from error
    if not isinstance(equivalent, int | float) or not equivalent > 0:
        raise InputError(
            f"the EXIF of {path} has no focal length in 35 mm (FocalLengthIn35mmFilm); give a "
            "photo straight from the camera's card, or --image-size, --focal-length-mm and "
            "--sensor-width-mm."
        )
    return Photo(size, float(equivalent), str(exif.get(_MODEL, "")).strip("\0 "))
