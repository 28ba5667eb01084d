# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests on boxes whether the image is turned or mirrored against its camera's pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aerial_gnss_ros.core.faults.image_orientation import PosedBoxes, judged
from aerial_gnss_ros.preflight.verdict import SignTest, Verdict


def image_test(images: Sequence[PosedBoxes], fastest: float) -> SignTest:
    """Return whether boxes go where the camera's motion moves them.

    Args:
        images: in the order of time.
        fastest: greatest speed of a robot, m/s.
    """
    name, rule = "image", "what floats moves through the image as the camera's motion says"
    found = judged(images)
    right, other = found.missed
    if np.isnan(right):
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            "boxes and the camera's pose hardly came together: fly over something that floats",
        )  # fmt: skip
    seen = f"boxes are {right:.1%} of the image's width from where they should be"
    if found.way is None:
        return SignTest(
            name, rule, Verdict.NOT_TESTED,
            "boxes hardly moved through the image, or would in a turned one as well: fly past what "
            "floats, or turn the camera",
        )  # fmt: skip
    if not found.way:
        return SignTest(name, rule, Verdict.PASS, seen)
    seen = (
        f"{seen}, and {other:.1%} if the image is {found.way}: turn it back in the camera's "
        "driver, or state how the camera is mounted"
    )
    if found.speed > fastest:
        return SignTest(name, rule, Verdict.FAIL, seen)
    swim = f"; right as it is if what floats moved at {found.speed:.1f} m/s"
    return SignTest(name, rule, Verdict.LOOK, seen + swim)
