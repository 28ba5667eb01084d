# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the monitor says, and when it stops saying it; on whole flights what it notices."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.consistency import InnovationMonitor
from aerial_gnss_ros.core.models.platform_model import PUBLISHED

STATED = np.diag([1.44, 1.44, 0.09, *[math.radians(0.4) ** 2] * 2, math.radians(1.5) ** 2, 0.0])


def fed(monitor: InnovationMonitor, ratio: float, images: int = 100) -> list[str]:
    """Return what it says to images of one robot that fit so well."""
    said = [monitor.update(2.0 * ratio, 2) for _ in range(images)]
    return [sentence for sentence in said if sentence]


def test_complains_while_boxes_lie_too_far_off():
    monitor = InnovationMonitor()
    assert math.isnan(monitor.fit.ratio)
    assert fed(monitor, 1.0) == []
    assert monitor.fit.ratio == pytest.approx(1.0)
    assert monitor.complaints == ()
    (begin,) = fed(monitor, 4.0)
    assert "Boxes are" in begin
    # Standing complaints follow the present figure: sqrt(4) times as far.
    assert monitor.fit.ratio == pytest.approx(4.0)
    assert monitor.fit.sigmas == pytest.approx(30.0)  # (4 - 1) / sqrt(2 / 200)
    assert [c.split(" as far")[0] for c in monitor.complaints] == ["Boxes are 2.0 times"]
    (end,) = fed(monitor, 1.0)
    assert "again" in end
    assert monitor.complaints == ()


def test_says_where_the_filter_allows_for_noise_larger_than_stated():
    monitor = InnovationMonitor()
    said = [monitor.update(2.0, 2, 4.0) for _ in range(100)]
    (begin,) = filter(None, said)
    assert "Boxes are 2.0 times" in begin
    assert "less certain than published" not in begin
    assert "noise is assumed 2.0 times" in begin
    assert monitor.fit.ratio == pytest.approx(4.0)  # by the stated noise


def test_names_an_error_beyond_what_is_stated_until_it_is_credible_again():
    monitor = InnovationMonitor()
    errors = np.zeros(len(PUBLISHED))
    heading = PUBLISHED.index("heading")
    errors[heading] = math.radians(6.0)  # four times 1.5 deg
    said = monitor.check_platform(errors, STATED)
    assert said is not None
    assert "heading seems to need a correction of +6 deg, which is 4.0 times" in said
    assert monitor.check_platform(errors, STATED) is None  # reported once
    assert monitor.complaints == (said,)  # but it stands
    errors[heading] = math.radians(4.6)  # 3.07 times: not yet credible
    monitor.check_platform(errors, STATED)
    assert len(monitor.complaints) == 1
    errors[heading] = math.radians(3.0)
    monitor.check_platform(errors, STATED)
    assert monitor.complaints == ()


def test_several_errors_at_once_are_reported_one_after_the_other():
    monitor, errors = InnovationMonitor(), np.zeros(len(PUBLISHED))
    errors[:2] = 9.0
    reported = [monitor.check_platform(errors, STATED) for _ in range(3)]
    assert ["east" in (reported[0] or ""), "north" in (reported[1] or ""), reported[2]] == [
        True,
        True,
        None,
    ]
    assert len(monitor.complaints) == 2


def test_boxes_just_outside_their_gates_are_a_complaint_while_they_are_many():
    monitor = InnovationMonitor()
    for _ in range(50):
        monitor.update_matches(97, 3)
    assert monitor.complaints == ()  # three in a hundred, and no more
    for _ in range(50):
        monitor.update_matches(5, 5)
    (words,) = monitor.complaints
    assert "400 of 5500 boxes are outside" in words
    for _ in range(100):
        monitor.update_matches(10, 0)
    assert monitor.complaints == ()


def test_a_camera_that_may_have_turned_is_a_complaint_while_it_may_and_reported_once():
    monitor, said = InnovationMonitor(), []
    for degrees in (0.0, 20.0, 30.0, 0.0, 20.0):
        reported = monitor.update_rotation(math.radians(degrees))
        words = f"by {degrees:.0f} deg or more"
        assert [words in one for one in monitor.complaints] == [True] * (degrees > 0.0)
        said.append(reported is not None and words in reported)
    assert said == [False, True, False, False, True]
