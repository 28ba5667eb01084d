# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A place on the water has one pixel in each frame, by an independent projection."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL, matrix_from_rpy
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.teaching.geometry import View, moved, view_of

CAMERA = CameraModel(
    640, 480, "plumb_bob", np.array([[610.0, 0, 322], [0, 607, 238], [0, 0, 1]]),
    np.array([-0.1, 0.03, 0.001, -0.0007, 0.0]),
)  # fmt: skip
PLACES = np.array([[3.0, 1.0], [-2.0, 4.0], [0.5, -1.0]])


def _view(down, yaw, position):
    rotation = np.asarray(matrix_from_rpy(0.03, np.radians(down), np.radians(yaw)))
    return View(CAMERA, np.array(position), rotation @ FLU_FROM_OPTICAL)


ONE, TWO = _view(80.0, 10.0, (0.0, 0.0, 14.0)), _view(65.0, 70.0, (-2.0, -4.0, 17.0))
LEVEL = _view(0.0, 0.0, (0.0, 0.0, 14.0))


def _opencv(view, places):
    points = np.column_stack([places, np.zeros(len(places))])
    turn, _ = cv2.Rodrigues(view.rotation.T)
    shift = -view.rotation.T @ view.position
    pixels, _ = cv2.projectPoints(points, turn, shift, CAMERA.K, np.asarray(CAMERA.D))
    return pixels.reshape(-1, 2) + 0.5  # to pixel edges


def test_a_pixel_moves_to_the_same_place_on_the_water():
    found = moved([ONE, TWO], 0, 1, _opencv(ONE, PLACES))
    np.testing.assert_allclose(found, _opencv(TWO, PLACES), atol=1e-3)
    np.testing.assert_allclose(ONE.place(_opencv(ONE, PLACES)), PLACES, atol=1e-5)


def test_without_a_camera_or_water_there_is_no_place():
    pixels = _opencv(ONE, PLACES)
    assert moved([ONE, None], 0, 1, pixels) is None
    assert np.isnan(moved([LEVEL, TWO], 0, 1, np.array([[320.0, 10.0]]))).all()
    behind = _view(80.0, 10.0, (0.0, 0.0, 14.0))
    assert np.isnan(behind.pixel(np.array([[0.0, -500.0], [-900.0, 0.0]]))).any()


def test_a_view_survives_json_and_a_damaged_one_is_refused():
    again = view_of(json.loads(json.dumps(TWO.as_dict())))
    np.testing.assert_allclose(again.pixel(PLACES), TWO.pixel(PLACES), atol=1e-9)
    assert view_of(None) is None
    with pytest.raises(InputError, match="camera of a frame is damaged"):
        view_of({**TWO.as_dict(), "rotation": [[1.0]]})
