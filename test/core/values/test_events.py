# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sentences for the log, each as often as it should be said."""

from __future__ import annotations

from aerial_gnss_ros.core.values.events import MAX_KEPT, ErrorText, Events, WarningText


def test_sentences_are_reported_in_order_and_once():
    log = Events()
    log.add("one")
    log.error("two")
    log.warn_once("fix", "three")
    log.warn_once("fix", "never")
    log.warn_once("height", "four")
    reported = log.drain()
    assert reported == ["one", "two", "three", "four"]
    assert [type(one) for one in reported] == [str, ErrorText, WarningText, WarningText]
    log.warn_once("fix", "never")
    assert log.drain() == []


def test_the_oldest_go_when_nobody_listens():
    log = Events()
    for number in range(MAX_KEPT + 2):
        log.add(str(number))
    reported = log.drain()
    assert (len(reported), reported[0], reported[-1]) == (MAX_KEPT, "2", str(MAX_KEPT + 1))


def test_one_that_has_joined_another_speaks_in_its_name():
    log, trial = Events(), Events()
    log.warn_once("fix", "one")
    trial.add("never")
    trial.join(log)
    trial.warn_once("fix", "never")
    trial.add("two")
    trial.counts["found"] += 1
    assert log.drain() == ["one", "two"]
    trial.add("three")
    log.add("four")
    assert trial.drain() == ["three", "four"]
    assert log.counts["found"] == 1
