# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parts that are left out are those of the program, and come back."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import safety_cost
import scaling

from aerial_gnss_ros.core.estimation import guard
from aerial_gnss_ros.core.estimation.snapshot import Snapshot


def flown(images=12):
    """Return labels of three robots at the end of a flight, and their positions."""
    engine, shown = scaling.flight(3, images)
    for stamp_ns, boxes in shown:
        engine.add_detections(boxes)
        last = engine.advance(stamp_ns)[-1]
    return [one.robot_id for one in last.estimates], [one.position for one in last.estimates]


def test_without_a_fault_nothing_is_missed():
    """But centimetres: the level of noise is weighed by every image."""
    whole, places = flown()
    with safety_cost.left_out(tuple(safety_cost.PARTS)):
        assert guard.Snapshot is not Snapshot
        bare, bare_places = flown()
    assert bare == whole
    np.testing.assert_allclose(bare_places, places, atol=0.05)
    assert guard.Snapshot is Snapshot
    assert len(whole) == 3


def test_a_part_comes_back_after_an_error():
    with pytest.raises(ZeroDivisionError), safety_cost.left_out(("snapshot",)):
        1 / 0  # noqa: B018
    assert guard.Snapshot is Snapshot


def test_a_row_has_a_share_for_each_part():
    cells = safety_cost.row(3, 12, 1).strip("| ").split(" | ")
    assert len(cells) == len(safety_cost.PARTS) + 3
    assert int(cells[0]) == 3
    assert int(cells[1]) > 0
