# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where a carried box is placed when only a part of the robot stands out."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.teaching.carry import _placed
from aerial_gnss_ros.teaching.tracks import extents, started, turning

BOX = np.array([200.0, 100.0, 80.0, 16.0])
ONCE = np.ones(2)


def _frames(outlines):
    """Return frames in which each rough box of a known size has its outline."""
    return SimpleNamespace(outline=lambda _frame, rough: outlines.get(round(float(rough[2]))))


def test_a_long_robot_has_one_extent_whichever_way_it_lies():
    """Also where the camera sees the water at a slant: up and down is half as many pixels."""
    upright = np.array([[0.0, 0.0, 16.0, 80.0]])
    assert extents(upright, np.eye(2)) == extents(BOX[None], np.eye(2))
    slanted = np.array([[0.0, 0.0, 16.0, 40.0]])
    plane = np.diag([1.0, 0.5])
    assert extents(slanted, plane) == pytest.approx(extents(BOX[None], np.eye(2)))
    track = started(0, slanted[0], np.zeros(1), plane)
    np.testing.assert_allclose(turning(track), np.hypot(80.0, 16.0) * np.array([1.0, 0.5]))


def test_the_outline_of_a_part_is_not_taken_for_the_robot():
    track = started(0, BOX, np.zeros(1), np.eye(2))
    bow = np.array([231.0, 101.0, 18.0, 14.0])
    whole = np.array([201.0, 99.0, 78.0, 30.0])
    around = round(float(turning(track)[0]))
    np.testing.assert_allclose(_placed(_frames({80: bow, around: whole}), track, bow, ONCE), whole)
    # Nowhere the whole: the box stays where it was expected, as the bow is in it,
    np.testing.assert_allclose(_placed(_frames({80: bow}), track, bow, ONCE), BOX)
    # and follows a part that leaves it no farther than needed.
    ahead = bow + np.array([10.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(
        _placed(_frames({80: ahead}), track, ahead, ONCE), BOX + np.array([10.0, 0.0, 0.0, 0.0])
    )
