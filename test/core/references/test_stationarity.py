# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence of motion: the last seconds of a track alone, and all of its flight in a crowd."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.core.references.candidates import Motion
from aerial_gnss_ros.core.references.displacement import TUNING as DISPLACEMENT
from aerial_gnss_ros.core.references.stationarity import TUNING, StationarityTest

sys.path.insert(0, str(Path(__file__).parent))

from one_mark import SECOND, Filter, law, mark, tracks_of

RESTED = math.log(26.0)
"""What a span of 5 s at rest tells: 1.5 m that it would have swum, against box errors of 0.3 m."""


def moved(test, law, seconds, names=(), **more):
    """Return the motion of the first track if it is the mark."""
    tracks = tracks_of(law, seconds, names)
    (found,) = test.update([mark(**more)], tracks, law, round(seconds * SECOND))
    return found.get(0, Motion())


def swam(metres, seconds):
    """Return the log odds of a displacement that box errors of 0.3 m explain, or swimming."""
    wider = 0.09 + (DISPLACEMENT.swim_mps * seconds) ** 2
    return math.log(wider / 0.09) - 3.0 * math.log1p(metres**2 / 0.36) + 0.5 * metres**2 / wider


def test_one_track_alone_tells_nothing_by_rest_and_is_adrift_by_bayes_rule():
    """Something else stays, too: 3 m within 10 s."""
    for metres, adrift in ((3.0, -swam(3.0, 10.0)), (0.5, 0.0)):
        test = StationarityTest(Filter())
        assert moved(test, law((5, 0)), 0.0) == Motion()
        found = moved(test, law((5 + metres, 0)), 10.0)
        assert (found.nats, found.adrift) == (0.0, pytest.approx(adrift))
        assert found.metres == pytest.approx(metres if adrift else 0.0)
        assert found.misfit == pytest.approx(DISPLACEMENT.misfit**2 * (0.5 * metres**2 - 0.09))


def velocity_odds(mps, sigma_mps):
    """Return log odds of rest to swimming by a velocity."""
    speeds = (TUNING.rest_mps, DISPLACEMENT.swim_mps)
    rests, swims = (sigma_mps**2 + v**2 for v in speeds)
    return math.log(swims / rests) - 0.5 * mps**2 * (1.0 / rests - 1.0 / swims)


@pytest.mark.parametrize(("mps", "tells"), [(0.0, 1.0), (0.4, -1.0)])
def test_velocity_tells_what_stays_from_others_of_its_class_until_places_do(mps, tells):
    """After 5 s, one image that puts the velocity off does not make a swimmer of what stays."""
    test, steady = StationarityTest(Filter()), law((5, 0), mps=mps, sigma_mps=0.1)
    found = moved(test, steady, 0.0, crowded=True)
    assert found.nats == pytest.approx(velocity_odds(mps, 0.1))
    assert found.nats * tells > 1.0
    assert moved(test, steady, 4.8, crowded=True).nats == pytest.approx(swam(0.0, 4.8))
    assert moved(StationarityTest(Filter()), steady, 0.0) == Motion()


def rested(spans, test=None, places=((5, 0),)):
    """Return a test in which tracks of a crowd have rested for some spans of 5 s."""
    test = test or StationarityTest(Filter())
    for i in range(spans + 1):
        moved(test, law(*places), 5.0 * i, crowded=True)
    return test


def test_what_spans_tell_adds_up_and_each_of_them_once():
    test, still = StationarityTest(Filter()), law((5, 0))
    for seconds, former in ((0.0, 0), (5.0, 0), (10.0, 1), (12.0, 2)):
        found = moved(test, still, seconds, crowded=True)
        assert found.adrift == pytest.approx(former * RESTED)
        lately = {5.0: swam(0.0, 5.0), 10.0: swam(0.0, 5.0), 12.0: swam(0.0, 2.0)}
        expected = lately.get(seconds, velocity_odds(0.0, 1.0))
        assert found.nats == pytest.approx(former * RESTED + expected)


def test_others_displaced_alike_add_up_to_no_more_than_rest():
    """7 m within 5 s, which two tracks have in common: an error, but none that shows rest."""
    test = StationarityTest(Filter())
    moved(test, law((5, 0), (0, 4)), 0.0, crowded=True)
    after = law((12, 0), (7, 4))
    assert moved(test, after, 5.0, crowded=True).nats == pytest.approx(RESTED)
    assert moved(test, after, 6.0, crowded=True).adrift == pytest.approx(RESTED)


def test_a_bad_look_does_not_outweigh_that_a_track_has_rested():
    """1.5 m off within 5 s: log odds of -2.2 by itself, and a span at rest tells 3.3."""
    off = law((6.5, 0))
    assert swam(1.5, 5.0) == pytest.approx(-2.2, abs=0.05)
    for spans, nats in ((0, 0.0), (1, RESTED), (2, 2.0 * RESTED)):
        test = rested(spans)
        found = moved(test, off, 5.0 * spans + 5.0, crowded=True)
        assert found.nats == pytest.approx(nats + swam(1.5, 5.0))
        assert (found.nats > 0.0) == (spans > 0)
        later = moved(test, off, 5.0 * spans + 10.0, crowded=True)
        assert later.nats == pytest.approx(found.nats + RESTED)


def test_what_has_long_stayed_or_swum_may_do_otherwise_from_now_on():
    test = rested(9)
    found = moved(test, law((5, 0)), 50.0, crowded=True)
    assert (found.adrift, found.nats) == (TUNING.most_nats, pytest.approx(8.0 + RESTED))
    test = StationarityTest(Filter())
    for i in range(9):
        moved(test, law((5 + 3 * i, 0)), 5.0 * i, crowded=True)
    found = moved(test, law((29, 0)), 45.0, crowded=True)
    assert (found.adrift, found.nats) == (0.0, pytest.approx(-8.0 + RESTED))


def test_what_has_come_loose_is_told_from_what_has_always_swum():
    """Of 3 m within the last 5 s both are suspected; the one stayed until then."""
    loose, swims = rested(2), StationarityTest(Filter())
    for i in range(3):
        moved(swims, law((5 + 3 * i, 0)), 5.0 * i, crowded=True)
    one = moved(loose, law((8, 0)), 15.0, crowded=True)
    other = moved(swims, law((14, 0)), 15.0, crowded=True)
    assert one.adrift - one.nats == pytest.approx(-swam(3.0, 5.0))
    assert other.nats < -3.0
    assert (other.adrift, one.adrift) == (0.0, pytest.approx(2.0 * RESTED))


def test_what_comes_loose_slowly_is_suspected_more_with_each_span():
    """1.5 m within each span of 5 s: from when on it swims stays the same."""
    test = rested(2)
    for i in range(1, 4):
        found = moved(test, law((5 + 1.5 * i, 0)), 10.0 + 5.0 * i, crowded=True)
        assert found.adrift - found.nats == pytest.approx(-i * swam(1.5, 5.0))
    for i in range(4, 12):  # and may be the reference again, once it stays as long as before
        found = moved(test, law((9.5, 0)), 10.0 + 5.0 * i, crowded=True)
    assert found.adrift < found.nats


def test_spans_of_a_track_are_those_of_its_label():
    """The tracks of two labels may change their rows."""
    test, names = StationarityTest(Filter()), ("buoy_0", "buoy_1")
    both = mark(crowded=True, rows=(0, 1))
    for i in range(3):
        east = law((5, 0), (3 * i, 9))
        test.update([both], tracks_of(east, 5.0 * i, names), east, 5 * i * SECOND)
    swapped = law((6, 9), (5, 0))
    (found,) = test.update([both], tracks_of(swapped, 11, names[::-1]), swapped, 11 * SECOND)
    assert found[0].adrift == 0.0
    assert found[1].adrift > 3.0


def test_another_label_keeps_what_spans_have_told():
    for name, former in (("aqua_7", RESTED), ("buoy_0", 0.0)):
        test = rested(1)
        test.rename({"buoy_0": "aqua_7"})
        for seconds, spans in ((7.0, 0.0), (12.0, 0.0), (12.5, RESTED)):
            found = moved(test, law((5, 0)), seconds, (name,), crowded=True)
            assert found.adrift == pytest.approx(former + spans)


def test_two_tracks_may_exchange_their_labels():
    test, places = rested(2, places=((5, 0), (9, 0))), law((5, 0), (9, 0))
    former = moved(test, places, 11.0, crowded=True).adrift
    test.rename({"buoy_0": "buoy_1", "buoy_1": "buoy_0"})
    found = moved(test, places, 11.2, ("buoy_1", "buoy_0"), crowded=True)
    assert found.adrift == former > 6.0
    assert found.metres == 0.0
    assert moved(test, places, 11.4, ("buoy_0", "buoy_1"), crowded=True).adrift == 0.0


def test_another_position_of_the_reference_ends_what_spans_have_told_of_it():
    for name, former, at in (("mark", 0.0, (4.0, 0.0)), ("pier", 2.0 * RESTED, (0.0, 0.0))):
        test = rested(2)
        test.forget(name)
        for seconds in (12.0, 14.0):
            found = moved(test, law((5, 0)), seconds, at=at, crowded=True)
            assert found.adrift == pytest.approx(former)
        assert found.nats == pytest.approx(former + swam(0.0, 2.0))


@pytest.mark.parametrize("change", ["jump", "restart"])
def test_an_accepted_jump_or_another_calibration_only_begins_a_new_span(change):
    """Which has 6 m between it and the former one."""
    filtering = Filter()
    test, after = rested(1, StationarityTest(filtering)), law((11, 0))
    if change == "jump":
        filtering.believed = np.array([6.0, 0.0])
    else:
        test.restart()
    found = moved(test, after, 7.0, crowded=True)
    assert found.nats == pytest.approx(RESTED + velocity_odds(0.0, 1.0))
    formers = [moved(test, after, t, crowded=True).adrift for t in (10.5, 11.5, 12.5)]
    assert formers == pytest.approx([RESTED, RESTED, RESTED])
    found = moved(test, after, 13.0, crowded=True)
    assert found.adrift == pytest.approx(RESTED + swam(0.0, 5.5))


def test_spans_count_in_a_crowd_only_though_they_add_up_before():
    test = StationarityTest(Filter())
    for i in range(3):
        assert moved(test, law((5, 0)), 5.0 * i) == Motion()
    assert moved(test, law((5, 0)), 11.0, crowded=True).adrift == pytest.approx(2.0 * RESTED)


def test_one_that_stays_from_then_on_may_be_the_reference_again():
    test, far = StationarityTest(Filter()), law((9, 0), (0, 4))
    moved(test, law((5, 0), (0, 4)), 0.0)
    assert moved(test, law((5, 0), (0, 4)), 1.0) == Motion()
    found = [moved(test, far, t) for t in range(5, 40, 5)]
    assert found[0].adrift > 5.0
    assert found[-1] == Motion()


def test_what_moves_is_not_asked_to_stay():
    test = StationarityTest(Filter())
    for t in range(0, 20, 5):
        assert moved(test, law((5 + t, 0), mps=1.0), t, stays=False, crowded=True) == Motion()
    assert moved(test, law((20, 0)), 21.0, crowded=True).adrift == 0.0


def test_an_accepted_jump_another_position_or_calibration_is_no_motion():
    for change in ("jump", "forget", "restart"):
        test = StationarityTest(filtering := Filter())
        moved(test, law((5, 0)), 0.0)
        if change == "jump":
            filtering.believed = np.array([6.0, 0.0])
        elif change == "forget":
            test.forget("mark")
        else:
            test.restart()
        assert moved(test, law((11, 0)), 1.0) == Motion()


def test_a_swimmer_that_has_turned_back_is_still_one():
    """It is where it was 16 s ago, and was 4 m off 8 s ago."""
    test = StationarityTest(Filter())
    for t in range(0, 16, 2):
        moved(test, law((5 + 4 * np.sin(t * np.pi / 16), 0), (0, 4)), t)
    found = moved(test, law((5, 0), (0, 4)), 16.0)
    assert found.adrift > 5.0
    assert found.metres == pytest.approx(4.0)
