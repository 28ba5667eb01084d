# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Some cells of the fault matrix, whole flights: none died, none is wrong, names are kept."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

from fault_cases import cases, fly

CASES = {case.words: case for case in cases()}


@pytest.mark.parametrize(
    "words", ["gimbal: jump", "gimbal: jump of 5 deg", "camera_info: jump", "fix: jump of 8 m"]
)
def test_what_displaces_all_robots_takes_no_name(words):
    """Before: new names for one to three robots, up to 180 confident wrong positions."""
    verdict, run = fly(CASES[words], "orbit", 1)
    assert not run.died
    assert (verdict.wrong, verdict.kept, verdict.names) == (0, 3, 3)
    assert verdict.right_s < 3.0
    assert verdict.sigma < 2.0


def test_robots_are_in_doubt_as_soon_as_none_is_where_it_should_be():
    """The receiver drifts by 5 m and comes back at once. Before: 18 confident wrong positions."""
    verdict, _ = fly(CASES["fix: slow drift"], "orbit", 1)
    assert (verdict.wrong, verdict.kept) == (0, 3)


@pytest.mark.parametrize(
    "words", ["detections: frozen value", "fix + attitude + gimbal + height: frozen value"]
)
def test_what_repeats_itself_is_not_believed(words):
    """Before: 150 and 152 confident wrong positions."""
    verdict, run = fly(CASES[words], "orbit", 1)
    assert verdict.wrong == 0
    assert any("to the last bit" in event for event in run.engine.take_events())


def test_what_was_confirmed_while_robots_were_elsewhere_is_given_up():
    """Before: a robot 20 m from any, for as long as robots coast."""
    verdict, _ = fly(CASES["attitude in use: stuck low"], "orbit", 1)
    assert verdict.wrong <= 2
    assert verdict.kept == 3
    verdict, _ = fly(CASES["gimbal: stuck low"], "transit", 1)
    assert (verdict.wrong, verdict.kept) == (0, 3)


def test_an_orientation_that_jumped_with_the_position_is_in_doubt_as_well():
    """Before: 145 confident wrong positions, up to 47 m."""
    verdict, _ = fly(CASES["fix + attitude: jump"], "orbit", 1)
    assert verdict.wrong == 0


def test_a_receiver_that_jumps_back_is_right_at_once():
    """Before: 3.2 s after the end."""
    verdict, _ = fly(CASES["fix: jump"], "orbit", 1)
    assert (verdict.wrong, verdict.kept) == (0, 3)
    assert verdict.right_s < 0.5
