# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How exact stamps of telemetry are that was written down with images.

Subtitles of a video, and tables made of them, state telemetry for each image; a new value first
shows in the image after it was measured. So its stamp is that of an image, and late by anything up
to the time between two images.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

LEAST_SAMPLES = 5
"""Fewer samples may have stamps of images by chance."""


def stamp_sigma_s(images: Sequence[int], inputs: Iterable[Sequence[int]]) -> float:
    """Return the standard deviation of the stamps of telemetry, s; 0 if they are its own.

    Telemetry was written down with images if each of its stamps is that of an image and some images
    have none: with one for each image nobody can tell.

    Args:
        images: stamps of images, ascending, ns.
        inputs: stamps of each input's samples between the first and the last of these, ns.
    """
    of_images, some = set(images), False
    for stamps in inputs:
        some = True
        if not LEAST_SAMPLES <= len(stamps) < len(images) or not of_images.issuperset(stamps):
            return 0.0
    if not some:
        return 0.0
    return float(np.median(np.diff(images))) * 1e-9 / math.sqrt(12.0)
