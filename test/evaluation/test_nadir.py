# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How near to straight down a simulated camera looked, from telemetry alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.evaluation.nadir import nearest_view
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.sensors import sensor_plan


@pytest.mark.parametrize("tilt_deg", [40.0, 60.0, 90.0])
def test_the_lower_edge_of_the_image_is_what_is_nearest(tmp_path, tilt_deg):
    plan = FlightPlan("orbit" if tilt_deg < 90.0 else "hover", 4.0, tilt=math.radians(tilt_deg))
    camera = default_camera(1280, 720)
    experiment = Experiment(
        GeneratedFlight(plan, 3), camera, sensor_plan("none"), CameraClock(2.0), robots=1,
        places=np.zeros((1, 2)), seed=2,
    )  # fmt: skip
    write_bag(tmp_path / "bag", experiment, None)
    with open_bag([tmp_path / "bag"]) as bag:
        nearest = math.degrees(nearest_view(bag, EstimatorConfig()))
        unknown = nearest_view(bag, estimator_config({"fix.topic": "elsewhere"}))
    half_view = math.degrees(math.atan(359.5 / camera.K[1, 1]))
    assert nearest == pytest.approx(max(90.0 - tilt_deg - half_view, 0.0), abs=2.5)
    assert math.isnan(unknown)
