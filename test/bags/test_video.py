# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Times of a video's frames are those of the file, where it has any."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.bags import video
from aerial_gnss_ros.bags.video import Video


class Capture:
    """Plays frames with the given stamps, s."""

    def __init__(self, stamps):
        self._stamps, self._index = stamps, -1

    def grab(self):
        self._index += 1
        return self._index < len(self._stamps)

    def get(self, wanted):
        assert wanted == cv2.CAP_PROP_POS_MSEC
        return 1000.0 * self._stamps[self._index]

    def retrieve(self):
        return True, np.zeros((2, 2, 3), np.uint8)

    def release(self):
        pass


VARIABLE = [*np.arange(30) / 30.0, *(1.0 + np.arange(30) / 5.0), *(7.0 + np.arange(30) / 30.0)]
COUNTED = (np.arange(90) / 11.25).tolist()


@pytest.mark.parametrize(
    ("stamps", "times"),
    [
        (VARIABLE, VARIABLE),  # a phone that films in the dark for a while; 11.25 Hz in the mean
        ([t + 3.0 for t in VARIABLE], VARIABLE),  # cut out of a longer one
        ([0.0] * 90, COUNTED),  # a stream without stamps
        ([math.nan] * 90, COUNTED),
        ([0.0, *(1e6 + t for t in VARIABLE[1:])], COUNTED),  # damaged
    ],
)
def test_a_frame_has_its_own_time(monkeypatch, stamps, times):
    monkeypatch.setattr(video, "_open", lambda _path: Capture(stamps))
    found = [time for time, _ in Video(Path("dive.mp4"), 2, 2, 11.25, 90).frames()]
    assert found == pytest.approx(times)
