# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Slow errors of the platform that are larger than stated, or change as the drone turns."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.values.samples import Orientation, Scalar
from test.core.conftest import World

pytestmark = pytest.mark.flights

RTK = {
    "noise.gnss_offset_m": 0.02,
    "camera.find_latency": False,  # on an even circle images tell nothing of it
}
ORBIT = {
    "drone": lambda t: (28.0 * math.cos(0.15 * t), 20.0 + 28.0 * math.sin(0.15 * t), 30.0),
    "rpy_deg": lambda t: (0.0, 47.0, math.degrees(0.15 * t) + 180.0),
    "pixel_sigma": 2.0,
}
ROBOTS = {
    name: lambda _t, place=place: place
    for name, place in {"a": (2.0, 21.0), "b": (-3.0, 18.0), "c": (1.0, 15.0)}.items()
}


class WrongTelemetry(World):
    """A heading that errs otherwise on each heading, and a height that errs by a constant."""

    deviation_deg, too_high_m = 0.0, 0.0

    def gimbal(self, t: float) -> Orientation:
        yaw = self.rpy_deg(t)[2]
        self.rpy_bias_deg = (0.0, 0.0, self.deviation_deg * math.sin(math.radians(yaw)))
        return super().gimbal(t)

    def height(self, t: float) -> Scalar:
        return replace(super().height(t), value=super().height(t).value + self.too_high_m)


@pytest.mark.parametrize(
    ("wrong", "left_m"), [({"deviation_deg": 5.0}, 0.25), ({"too_high_m": 2.0}, 0.1)]
)
def test_errors_far_beyond_what_is_stated_are_contained(sea, wrong, left_m):
    """Of 1.5 deg and 0.3 m, in an orbit around robots that stay: and found, but for a rest."""
    world = WrongTelemetry(robots=ROBOTS, seed=2, **ORBIT)
    vars(world).update(wrong)
    results = sea.play(sea.estimator(RTK), world, 45.0)
    sizes, far = [], []
    for result in results[10:]:
        for one in result.estimates:
            off = min((one.position - np.array(place(0.0)) for place in world.robots.values()),
                      key=lambda d: float(d @ d))  # fmt: skip
            far.append(float(np.hypot(*off)))
            sizes.append(float(off @ np.linalg.solve(one.covariance[:2, :2], off)))
    assert len(sizes) > 500
    assert np.mean(np.array(sizes) > 13.8) < 0.02
    assert np.median(far[-60:]) < left_m
