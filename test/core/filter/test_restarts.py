# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots begin anew while the latency is unknown, once it is known, and after a new calibration."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.filter import restarts
from aerial_gnss_ros.core.filter.restarts import TUNING, Restarts
from aerial_gnss_ros.core.models.platform_model import COUNT

SLOTS = np.array([0, 2])


@pytest.fixture
def begun(monkeypatch):
    """Return a function that applies restarts to an image: what begins anew, at which speeds."""
    told = []
    monkeypatch.setattr(restarts, "relinearize", lambda *_: None)
    monkeypatch.setattr(
        restarts, "restore_priors", lambda *of: told.append(("calibration", of[-1]))
    )
    group = SimpleNamespace(
        motion=lambda *_: SimpleNamespace(speed_sigma=0.5),
        forget=lambda *of: told.append(("latency", of[-1])),
    )
    laws = SimpleNamespace(
        restart=lambda: told.append("laws"),
        times=SimpleNamespace(restart=lambda: told.append("times")),
    )

    def image(which):
        told.clear()
        which.apply(group, SLOTS, None, np.eye(COUNT), None)
        which.done()
        return list(told)

    image.restarts = Restarts(laws)
    return image


def test_with_a_known_latency_nothing_begins_anew(begun):
    one = begun.restarts
    one.reset(TUNING.sure_s**2)
    assert not one.late
    assert begun(one) == []


def test_an_unknown_latency_feigns_speeds_until_it_is_found_and_once_more_none(begun):
    one = begun.restarts
    one.reset(0.3**2)
    assert one.late
    unknown = ["laws", ("latency", 0.5 + TUNING.feigned_mps)]
    assert [begun(one), begun(one)] == [unknown, unknown]
    one.note_latency(TUNING.sure_s)
    assert not one.late
    assert [begun(one), begun(one)] == [["laws", ("latency", 0.5)], []]


def test_a_latency_is_not_lost_as_soon_as_it_is_found(begun):
    one = begun.restarts
    one.reset(0.3**2)
    late = []
    for sigma in (0.15, 0.1, 0.15, 0.2, 0.21, 0.15):
        one.note_latency(sigma)
        late.append(one.late)
    assert late == [True, False, False, False, True, True]


def test_after_a_new_calibration_robots_begin_anew_once(begun):
    one = begun.restarts
    one.note_recalibration()
    assert [begun(one), begun(one)] == [["times", ("calibration", 0.5)], []]
