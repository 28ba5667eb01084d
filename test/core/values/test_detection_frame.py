# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values that pass between the parts."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.values.detection_frame import DetectionFrame, empty_detections
from aerial_gnss_ros.core.values.estimates import State


def test_kept_detections_keep_their_rows_together():
    frame = DetectionFrame(
        5, "cam", np.arange(6.0).reshape(3, 2), np.full((3, 2), 9.0), np.array([0.1, 0.9, 0.5]),
        ("a", "b", "c"),
    )  # fmt: skip
    kept = frame.keep(np.array([True, False, True]))
    assert (len(kept), kept.class_ids, kept.stamp_ns, kept.frame_id) == (2, ("a", "c"), 5, "cam")
    assert kept.centers.tolist() == [[0.0, 1.0], [4.0, 5.0]]
    assert kept.scores.tolist() == [0.1, 0.5]


def test_an_empty_image_has_arrays_of_the_right_shape():
    frame = empty_detections(7)
    assert len(frame) == 0
    assert (frame.centers.shape, frame.sizes.shape, frame.scores.shape) == ((0, 2), (0, 2), (0,))


def test_states_read_as_in_files():
    assert [str(state) for state in State] == ["tentative", "confirmed", "coasting", "lost"]
