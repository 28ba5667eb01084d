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

SELDOM = 1.5
"""Samples farther apart than this many images come more seldom than images: not one is missing now
and then."""


def stamp_sigma_s(images: Sequence[int], inputs: Iterable[Sequence[int]]) -> float:
    """Return the standard deviation of the stamps of telemetry, s; 0 if they are its own.

    Telemetry was written down with images if each of its stamps is that of an image, and it comes
    more seldom: with one for each image nobody can tell.

    Args:
        images: stamps of images, ascending, ns.
        inputs: stamps of each input's samples between the first and the last of these, ns.
    """
    if len(images) <= LEAST_SAMPLES:
        return 0.0
    of_images, interval = set(images), float(np.median(np.diff(images)))
    some = False
    for stamps in inputs:
        some = True
        if len(stamps) < LEAST_SAMPLES or not of_images.issuperset(stamps):
            return 0.0
        if float(np.median(np.diff(stamps))) < SELDOM * interval:
            return 0.0
    return interval * 1e-9 / math.sqrt(12.0) if some else 0.0
