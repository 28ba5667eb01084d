# SPDX-License-Identifier: Apache-2.0
"""Two robots that pass closer than their boxes are exact: who is who is decided afterwards."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.encounters import Encounters
from aerial_gnss_ros.core.track import Track
from aerial_gnss_ros.core.values import State

SECOND = 1_000_000_000
SIGMA = 0.1


def _meet(seed, closest, swap_from=None, seconds=10.0):
    """Two robots pass at 0.6 m/s; from a time on the association has the boxes the wrong way."""
    rng = np.random.default_rng(seed)
    meeting = Encounters(0.05)
    one = Track("aqua", 0, 0, State.CONFIRMED, "aqua_1", velocity=np.array([0.3, 0.0]))
    other = Track("aqua", 0, 0, State.CONFIRMED, "aqua_2", velocity=np.array([-0.3, 0.0]))
    white = np.repeat(SIGMA**2 * np.eye(2)[None], 2, axis=0)
    most = 0.0
    for i in range(round(10 * seconds)):
        t = 0.1 * i - 0.5 * seconds
        places = np.array([[0.3 * t, 0.0], [-0.3 * t, closest]])
        places += SIGMA * rng.standard_normal((2, 2)) + [100.0, 50.0 * np.sin(t)]
        shown = places[::-1] if swap_from is not None and t >= swap_from else places
        meeting.take([one, other], shown, white, i * SECOND // 10)
        doubt = meeting.doubts().get("aqua_1", np.zeros((2, 2)))
        assert np.linalg.eigvalsh(doubt).min() >= -1e-9
        most = max(most, float(np.trace(doubt)))
    return one.robot_id, other.robot_id, most


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("swap_from", [-0.2, 0.0, 0.3])
def test_names_exchanged_while_close_are_put_right(seed, swap_from):
    """From `swap_from` on, the first track gets the other robot's boxes, so the names must go."""
    assert _meet(seed, 0.3, swap_from)[:2] == ("aqua_2", "aqua_1")


@pytest.mark.parametrize("seed", range(4))
def test_names_that_are_right_stay(seed):
    assert _meet(seed, 0.3)[:2] == ("aqua_1", "aqua_2")


def test_doubt_is_published_only_while_there_is_some():
    far, near = _meet(1, 2.5)[2], _meet(1, 0.05)[2]
    assert far == 0.0
    assert near > 1e-3  # m²: half of (5 to 10 cm)²


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 6))
def test_names_stay_a_permutation(seed, count):
    """Whatever boxes come, no name is lost or given twice."""
    rng = np.random.default_rng(seed)
    meeting = Encounters(0.05)
    tracks = [Track("aqua", 0, 0, State.CONFIRMED, f"aqua_{i}") for i in range(count)]
    white = np.repeat(SIGMA**2 * np.eye(2)[None], count, axis=0)
    for i in range(20):
        shown = rng.permutation(count)[: rng.integers(1, count + 1)]
        places = 0.3 * rng.standard_normal((len(shown), 2))
        meeting.take([tracks[j] for j in shown], places, white[: len(shown)], i * SECOND // 10)
        assert sorted(track.robot_id for track in tracks) == [f"aqua_{j}" for j in range(count)]
