# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The newest item goes from one thread to another; older ones are counted."""

from __future__ import annotations

import threading

from aerial_gnss_ros.nodes.newest import Newest


def test_an_item_that_waits_is_replaced_and_counted():
    newest = Newest()
    for item in "abc":
        newest.put(item)
    assert newest.pop() == "c"
    assert newest.dropped == 2
    newest.put("d")
    assert (newest.pop(), newest.dropped) == ("d", 2)


def test_who_waits_gets_the_next_item_and_none_when_it_is_closed():
    newest, got, taken = Newest(), [], threading.Event()

    def work():
        while (item := newest.pop()) is not None:
            got.append(item)
            taken.set()

    thread = threading.Thread(target=work)
    thread.start()
    newest.put("a")
    assert taken.wait(60.0)
    newest.close()
    thread.join(60.0)
    assert not thread.is_alive()
    newest.put("b")
    assert got == ["a"]
    assert newest.pop() is None
