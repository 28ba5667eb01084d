# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Some images of the last 15 s are kept."""

from __future__ import annotations

from itertools import pairwise

import pytest

from aerial_gnss_ros.core.estimation.recent_images import RecentImages, SeenImage


@pytest.mark.parametrize(("rate_hz", "apart_s"), [(60.0, 0.2), (1.0, 1.0)])
def test_five_images_a_second_of_the_last_seconds_are_kept(sea, rate_hz, apart_s):
    recent = RecentImages()
    for k in range(int(20.0 * rate_hz)):
        recent.add(SeenImage(sea.boxes(k / rate_hz, []), None))
    stamps = [one.frame.stamp_ns for one in recent.images]
    newest_ns = sea.stamp((20.0 * rate_hz - 1.0) / rate_hz)
    assert stamps[0] == pytest.approx(newest_ns - 15e9, abs=1e9 * apart_s)
    assert newest_ns - stamps[0] <= 15.2e9
    assert stamps[-1] == pytest.approx(newest_ns, abs=0.2e9)
    gaps = {round((b - a) * 1e-9, 2) for a, b in pairwise(stamps)}
    assert gaps == {apart_s}
