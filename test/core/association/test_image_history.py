# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How often robots are detected, and how many boxes are of no robot."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.association.image_history import TUNING, Seen, detection_rates


def seen(sea, boxes, *names):
    """Return an image with so many boxes, the first of which measured robots."""
    named = dict(enumerate(names))
    return Seen(0, np.zeros((boxes, 2)), ("aqua",) * boxes, named, sea.camera, 20.0)


def test_misses_and_other_boxes_are_counted(sea):
    history = [seen(sea, 2, "a", "b"), seen(sea, 3, "a"), seen(sea, 1, "b")]
    share, density = detection_rates(history)
    hits = TUNING.prior_hits + 4
    assert share == pytest.approx(hits / (2 * 3 + TUNING.prior_hits + TUNING.prior_misses))
    camera = sea.camera
    area = camera.width * camera.height / (camera.K[0, 0] * camera.K[1, 1])
    assert density * area == pytest.approx(TUNING.prior_new_boxes + 2 / 3)
    assert detection_rates([seen(sea, 1, "a")] * 1000)[0] == 0.99
