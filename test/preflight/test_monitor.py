# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which stamps `aerial-gnss check` believes: the same as the estimator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.values.samples import Orientation
from aerial_gnss_ros.preflight.monitor import InputMonitor

DAY = 86_400.0
TELEMETRY = ("attitude", "fix", "gimbal", "height")


class Player:
    """Plays a hover into a watch, 10 messages of each input a second; stamps may be off."""

    def __init__(self, sea):
        self.sea, self.world = sea, sea.World()
        self.monitor = InputMonitor(EstimatorConfig())
        self.t = self.now = 0.0

    def send(self, name, off=0.0):
        ns = self.sea.stamp(self.t + off)
        self.monitor.arriving(name, self.sea.stamp(self.now))
        if name == "attitude":
            self.monitor.add_attitude(Orientation(ns, np.array([0.0, 0.0, 0.0, 1.0])))
        elif name == "detections":
            self.monitor.add_detections(replace(self.world.frame(self.t), stamp_ns=ns))
        else:
            value = getattr(self.world, name)(self.t)
            getattr(self.monitor, f"add_{name}")(replace(value, stamp_ns=ns))
        self.monitor.advance()

    def play(self, seconds, off=None, names=(*TELEMETRY, "detections")):
        for _ in range(round(seconds * 10)):
            for name in names:
                self.send(name, (off or {}).get(name, 0.0))
            self.t += 0.1
            self.now += 0.1
        return self

    def seconds(self, what="pose"):
        """Return the times since the start at which something was known."""
        self.monitor.advance(final=True)
        known = [m.stamp_ns for m in self.monitor.states if getattr(m, what) is not None]
        return [round((ns - self.sea.stamp(0.0)) * 1e-9, 1) for ns in known]


@pytest.fixture
def player(sea):
    return Player(sea)


def every(begin, end):
    """Return the times of the moments from one to another."""
    return [round(0.2 * i, 1) for i in range(round(begin * 5), round(end * 5))]


@pytest.mark.parametrize("images", [True, False])
@pytest.mark.parametrize("off", [DAY, -DAY])
@pytest.mark.parametrize("name", TELEMETRY)
def test_one_wrong_stamp_costs_nothing(player, name, off, images):
    names = (*TELEMETRY, "detections") if images else TELEMETRY
    player.play(3.0, names=names).send(name, off)
    player.play(3.0, names=names)
    assert player.seconds() == player.seconds("body") == every(0.0, 6.0)
    assert player.monitor.records[name].bad == 1
    assert player.monitor.records[name].trouble.startswith("its stamp is 86")
    (reported,) = player.monitor.events
    assert f"1 message on {name} refused" in reported


@pytest.mark.parametrize("off", [DAY, -DAY])
def test_5_s_of_wrong_stamps_cost_these_5_s(player, off):
    player.play(3.0).play(5.0, off={"fix": off}).play(3.0)
    assert player.seconds() == every(0.0, 3.0) + every(8.0, 11.0)
    assert player.monitor.records["fix"].bad == 50
    (reported,) = player.monitor.events
    assert "50 messages on fix refused" in reported


@pytest.mark.parametrize("images", [True, False])
def test_time_that_begins_anew_is_followed(player, images):
    names = (*TELEMETRY, "detections") if images else TELEMETRY
    player.play(60.0, names=names)
    player.t = 0.0
    player.play(4.0, names=names)
    assert player.seconds() == every(0.0 if images else 0.2, 4.0)
    assert all(record.bad == 0 for record in player.monitor.records.values())
    if images:
        (reported,) = player.monitor.events
        assert reported.startswith("Time went backward by 60.")
    else:  # all clocks were set, or time restarted: not known
        assert player.monitor.events == [f"The clock of {name} was set." for name in TELEMETRY]


def test_a_pause_is_none(player):
    player.play(3.0)
    player.t += 100.0
    player.now += 100.0
    player.play(3.0)
    assert player.seconds()[:14] == every(0.0, 2.8)
    assert player.seconds()[-14:] == every(103.2, 106.0)
    assert player.monitor.events == []
    assert all(record.bad == 0 for record in player.monitor.records.values())
