# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is counted of an input, and its state."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.telemetry.input_status import InputState, MessageCounter

SECOND = 1_000_000_000


def _counter(*messages):
    counter = MessageCounter()
    for stamp_s, trouble in messages:
        counter.add(stamp_s * SECOND, trouble)
    return counter


def test_messages_are_counted_by_what_is_wrong_with_them():
    counter = _counter((1, ""), (2, "NaN"), (2, ""), (1, "NaN"), (3, ""))
    assert (counter.count, counter.bad, counter.unordered) == (5, 2, 2)
    assert (counter.last_stamp_ns, counter.trouble) == (3 * SECOND, "")
    counter.refuse("unreadable")
    assert (counter.count, counter.bad, counter.trouble) == (6, 3, "unreadable")
    assert (counter.last_stamp_ns, counter.unordered) == (3 * SECOND, 2)
    counter.undo_refusal()
    assert (counter.count, counter.bad, counter.trouble) == (5, 2, "")


@pytest.mark.parametrize(
    ("messages", "newest_s", "state"),
    [
        ((), 9, InputState.WAITING),
        (((1, ""),), None, InputState.OK),
        (((1, ""),), 3, InputState.OK),  # just not too old
        (((1, ""),), 4, InputState.STALE),
        (((1, ""), (2, "NaN")), 3, InputState.BAD),
        (((1, ""), (2, "NaN")), 9, InputState.STALE),
        (((1, "NaN"), (2, "")), 3, InputState.OK),
    ],
)
def test_its_state_is_what_is_worst_for_the_newest_image(messages, newest_s, state):
    newest_ns = None if newest_s is None else newest_s * SECOND
    found = _counter(*messages).status("fix", newest_ns, 2 * SECOND)
    assert found.state is state
    assert str(found.state) == state.value
    assert (found.name, found.count) == ("fix", len(messages))


def test_an_input_whose_stamps_are_refused_is_bad_however_old():
    counter = _counter((1, ""))
    counter.refuse("its stamp is 9.0 s behind")
    assert counter.status("fix", 99 * SECOND, SECOND).state is InputState.BAD
    counter.undo_refusal()
    assert counter.status("fix", 99 * SECOND, SECOND).state is InputState.STALE
    counter.refuse("again")
    counter.reset_stamps()  # as if no message had ever had a stamp
    assert counter.status("fix", 99 * SECOND, SECOND).state is InputState.BAD
    counter.add(99 * SECOND)
    assert counter.status("fix", 99 * SECOND, SECOND).state is InputState.OK


def test_it_says_for_how_long_messages_have_been_of_no_use():
    assert _counter().bad_s == 0.0
    assert _counter((1, ""), (3, "")).bad_s == 0.0
    assert _counter((1, ""), (3, "NaN"), (8, "NaN")).bad_s == 7.0
    assert _counter((2, "NaN"), (8, "NaN")).bad_s == 6.0  # since the first one
    assert _counter((1, "NaN"), (2, ""), (8, "NaN")).bad_s == 6.0
    counter = _counter((1, ""), (3, "NaN"))
    counter.reset_stamps()
    assert counter.bad_s == 0.0
    assert counter.status("fix", SECOND, 0).state is InputState.WAITING
