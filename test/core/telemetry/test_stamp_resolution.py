# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Telemetry that was written down with images is known by its stamps."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.stamp_resolution import stamp_sigma_s

IMAGES = [500_000_000 * k for k in range(21)]
EVERY_SECOND = IMAGES[::2]


def test_telemetry_with_stamps_of_images_is_late_by_up_to_their_interval():
    sigma_s = stamp_sigma_s(IMAGES, [EVERY_SECOND, [*EVERY_SECOND[:-1], IMAGES[-2]]])
    assert sigma_s == pytest.approx(0.5 / 12.0**0.5)


@pytest.mark.parametrize(
    "inputs",
    [
        [EVERY_SECOND, [*EVERY_SECOND[:-1], IMAGES[-1] - 1]],  # one stamp is of no image
        [EVERY_SECOND, IMAGES],  # one for each image
        [IMAGES[3:-2], IMAGES[:9] + IMAGES[10:]],  # the first ones came later, one is missing
        [EVERY_SECOND, EVERY_SECOND[:4]],  # too few
        [],
    ],
)
def test_others_have_stamps_of_their_own(inputs):
    assert stamp_sigma_s(IMAGES, inputs) == 0.0
