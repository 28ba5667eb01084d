# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When a video began in the flight's log: as marked, as stated, or not at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_flight import DjiLog
from aerial_gnss_ros.bags.alignment import align
from aerial_gnss_ros.core.values.errors import InputError


def log(*recordings, seconds=400.0, of_video=False):
    """Return a flight of ten rows a second in which videos were recorded."""
    stamps = np.arange(0, round(seconds * 1e9) + 1, 100_000_000)
    nothing = np.zeros(0)
    return DjiLog(
        Path("log.csv"), stamps, nothing, nothing, nothing, nothing, nothing, (), (),
        recordings_s=recordings, of_video=of_video,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("recordings", "duration", "start"),
    [
        (((5.0, 65.0),), 60.0, 5.0),
        (((5.0, 65.0), (100.0, 190.0)), 91.9, 100.0),  # good to 2 s
        (((5.0, 305.0), (310.0, 320.0)), 305.9, 5.0),  # or to 2 % of the video
    ],
)
def test_the_one_recording_that_lasts_as_long_is_the_video(recordings, duration, start):
    found = align(log(*recordings), duration)
    assert found.start_s == start
    assert "accurate to about 1 s" in found.how


def test_of_two_that_fit_the_user_chooses():
    twice = log((5.0, 65.0), (100.0, 160.0))
    with pytest.raises(InputError, match=r"1 and 2 of the log both fit .* choose with --recording"):
        align(twice, 60.0)
    assert align(twice, 60.0, recording=2).start_s == 100.0
    with pytest.raises(InputError, match=r"--recording 3: the log marks 2: 1: 60.0 s from 5.0 s, "):
        align(twice, 60.0, recording=3)
    with pytest.raises(InputError, match="contradict each other"):
        align(twice, 60.0, offset_s=1.0, recording=1)


@pytest.mark.parametrize("duration", [57.9, 62.1, 600.0])
def test_a_recording_of_another_length_is_of_another_flight(duration):
    with pytest.raises(InputError, match="log and video are of different flights"):
        align(log((5.0, 65.0)), duration)


def test_a_log_without_marks_needs_an_offset():
    with pytest.raises(InputError, match=r"does not mark when .* give --offset SECONDS"):
        align(log(), 60.0)
    assert align(log(), 60.0, offset_s=12.5).start_s == 12.5


def test_subtitles_have_the_times_of_their_video():
    assert align(log(of_video=True), 400.0).start_s == 0.0


@pytest.mark.parametrize(
    ("offset", "duration", "fits"),
    [(-2.0, 60.0, True), (-2.1, 60.0, False), (341.9, 60.0, True), (342.1, 60.0, False)],
)
def test_a_video_lies_within_the_log(offset, duration, fits):
    if fits:
        assert align(log(), duration, offset_s=offset).start_s == offset
    else:
        with pytest.raises(InputError, match=r"covers 0\.0 to 400\.0 s"):
            align(log(), duration, offset_s=offset)
