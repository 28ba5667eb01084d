# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values that are sent again until the next is measured: as if each had been sent once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytestmark = pytest.mark.flights

RADIUS_M, RATE, END_S = 15.0, 0.25, 20.0
ROBOTS = {"a": (1.0, 2.0), "b": (-2.0, -1.0), "c": (2.5, -2.5)}


def _heading(t):
    return 0.3 + RATE * t


def _world(sea):
    """Return a drone that circles still robots and looks at the middle, with an RTK receiver."""
    return sea.World(
        drone=lambda t: (*(-RADIUS_M * np.array([np.cos(_heading(t)), np.sin(_heading(t))])), 20.0),
        rpy_deg=lambda t: (0.0, np.degrees(np.arctan2(20.0, RADIUS_M)), np.degrees(_heading(t))),
        robots={name: lambda _t, place=place: place for name, place in ROBOTS.items()},
        pixel_sigma=1.0, seed=1,
    )  # fmt: skip


def _fly(sea, monkeypatch, source, again):
    """Return the last result where an input measures once a second, and sends that at 20 Hz."""
    world, engine = _world(sea), sea.estimator({"noise.set": "rtk"})
    add, last = getattr(engine, f"add_{source}"), []

    def sent(sample):
        if not last or sample.stamp_ns - last[-1].stamp_ns >= 999_000_000:
            last.append(sample)
            add(sample)
        elif again:
            add(replace(last[-1], stamp_ns=sample.stamp_ns))

    monkeypatch.setattr(engine, f"add_{source}", sent)
    results = sea.play(engine, world, END_S, images=10)
    return next(one for one in results if one.stamp_ns >= sea.stamp(END_S - 3.0))


@pytest.mark.parametrize("source", ["fix", "gimbal"])
def test_what_images_told_before_it_was_found_does_no_harm(sea, monkeypatch, source):
    once, again = (_fly(sea, monkeypatch, source, again) for again in (False, True))
    found = {one.robot_id: one for one in again.estimates}
    assert sorted(found) == [f"aqua_{k}" for k in (1, 2, 3)]
    for one in once.estimates:
        other = found[one.robot_id]
        assert np.linalg.norm(one.position - other.position) < 0.5 * one.sigma
        assert other.sigma < 1.5 * one.sigma
