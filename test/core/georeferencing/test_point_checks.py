# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Area and size as reasons for a refusal, and an area that lies elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing.localization import locate
from aerial_gnss_ros.core.georeferencing.point_checks import PointChecks
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason


def square(longitude_deg, latitude_deg, half_deg=0.01):
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half_deg
    return ((np.array([longitude_deg, latitude_deg]) + corners,),)


@pytest.fixture(name="image")
def _image(sea):
    """An image of four boxes: the last one above the horizon, and where they see the water."""
    world = sea.World(rpy_deg=lambda _t: (0.0, 15.0, 90.0))
    boxes = sea.boxes(0.0, [[640, 300], [640, 400], [200, 700], [640, 20]])
    pose = world.pose(0.0)
    frame = PosedFrame(boxes, world.camera, pose, MapPose.of(pose, world.local))
    config = estimator_config({})
    return frame, locate(frame.pose, frame.camera, boxes.centers, config.noise, config)


HERE = (-59.6415, 13.194)


@pytest.mark.parametrize(
    ("polygons", "lengths", "reasons"),
    [
        (square(*HERE), {}, [None, None, None, Reason.ABOVE_HORIZON]),
        (square(*HERE), {"length_m": [40, 50]}, [*[Reason.WRONG_SIZE] * 3, Reason.ABOVE_HORIZON]),
        (
            square(HERE[0], HERE[1] + 0.005, 0.001),
            {"length_m": [40, 50]},
            [*[Reason.OUTSIDE_AREA] * 3, Reason.ABOVE_HORIZON],
        ),
    ],
)
def test_the_first_reason_is_reported_and_nothing_is_left_of_the_point(
    image, polygons, lengths, reasons
):
    frame, points = image
    config = estimator_config({"classes": {"aqua": lengths}} if lengths else {})
    checks = PointChecks(config, polygons, Events())
    assert checks.used
    checked = checks.apply(frame, points)
    assert list(checked.reasons) == reasons
    refused = np.array([reason is not None for reason in reasons])
    assert np.isnan(checked.latitude).tolist() == refused.tolist()
    assert np.isnan(checked.covariance[:, 0, 0]).tolist() == refused.tolist()
    assert (checked.sizes is not None) is bool(lengths)


def test_without_area_and_lengths_nothing_is_checked():
    config = estimator_config({"classes": {"aqua": {"max_speed": 1.0}}})
    assert not PointChecks(config, (), Events()).used


@pytest.mark.parametrize(
    ("polygons", "sentence"),
    [
        (square(*HERE[::-1]), "latitudes and longitudes are swapped: GeoJSON has longitude first."),
        (square(-59.0, 14.0), "is 111 km from the drone"),
        (square(-159.0, 14.0), "give the area of this site, or leave it out."),
    ],
)
def test_an_area_elsewhere_is_reported_once(image, polygons, sentence):
    log = Events()
    checks = PointChecks(estimator_config({}), polygons, log)
    for _ in range(2):
        assert checks.apply(*image).reasons[:3] == (Reason.OUTSIDE_AREA,) * 3
    assert len(log.sentences) == 1
    assert sentence in log.sentences[0]


def test_the_area_that_the_drone_looks_into_from_outside_is_not_elsewhere(image):
    log = Events()
    near = square(HERE[0], HERE[1] + 9_000 / 111_000 + 0.01)
    PointChecks(estimator_config({}), near, log).apply(*image)
    assert log.sentences == []
    assert math.isfinite(image[1].latitude[0])
