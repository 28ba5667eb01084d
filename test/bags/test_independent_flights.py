# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights of another simulation, replayed with default parameters: nobody states what is unusual.

Which robots stay, how large errors are and how long they last is in no message and in no parameter.
Limits leave room: a flight is one draw.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.detection.config import DetectorConfig

pytestmark = pytest.mark.flights

EARTH_M = 6_371_000.0
LIMITS = {
    "orbit30_still": (0.08, 1.0, 0.95),
    "transit30_still": (0.15, 1.0, 0.95),
    "hover30_mixed": (0.5, 1.0, 0.95),
    "orbit20_mixed_noisy": (1.8, 2.0, 0.95),
    "orbit40_moving_quiet": (0.6, 1.0, 0.95),
    "transit25_late": (3.0, 1.5, 0.95),
    "orbit60_coloured": (0.5, 1.5, 0.95),
    "orbit30_slow": (1.5, 1.0, 0.9),
}
"""Largest RMS error, m, and NEES/2, and least share of boxes with positions, of the last third."""

CONFIG = estimator_config({})  # nothing is stated


def no_detector(_config):
    raise AssertionError("the bag has boxes")


def replayed(path):
    """Return the errors (n, 2) of the last third in m, their covariances, and the share of boxes.

    Names count as those of the nearest robot: these swim or lie metres apart.
    """
    truth = json.loads(path.with_name(f"{path.name}.truth.json").read_text())
    place = {stamp: i for i, stamp in enumerate(truth["stamp_ns"])}
    east = np.radians(truth["lon"]) * EARTH_M * math.cos(math.radians(truth["lat"][0][0]))
    north = np.radians(truth["lat"]) * EARTH_M
    seen = np.array(truth["seen"])
    first = 2 * len(seen) // 3
    errors, covariances = [], []
    with open_bag([path]) as bag:
        for result in Replay(bag, CONFIG, DetectorConfig(), no_detector).results():
            image = place.get(result.stamp_ns, -1)
            if image < first:
                continue
            scale = EARTH_M * math.cos(math.radians(truth["lat"][0][0]))
            for one in result.estimates:
                if one.state is State.CONFIRMED:
                    off = np.stack(
                        [one.longitude * scale - east[image], one.latitude * EARTH_M - north[image]]
                    )
                    nearest = int(np.argmin(np.hypot(*off)))
                    errors.append(off[:, nearest])
                    covariances.append(one.covariance[:2, :2])
    return np.array(errors), np.array(covariances), len(errors) / seen[first:].sum()


@pytest.mark.parametrize("flight", LIMITS)
def test_nothing_needs_to_be_stated(flight, shared_data):
    folder = shared_data / "independent_flights"
    if not folder.is_dir():
        pytest.skip(f"no independent flights: {folder} is absent")
    errors, covariances, share = replayed(folder / flight)
    rms_m, nees, least = LIMITS[flight]
    squared = np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors)
    assert share > least
    assert math.sqrt(np.mean((errors**2).sum(axis=1))) < rms_m
    assert squared.mean() / 2.0 < nees
