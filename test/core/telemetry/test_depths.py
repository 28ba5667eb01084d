# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Depths that robots send, and their share in what is published."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.corrections import DepthConfig
from aerial_gnss_ros.core.telemetry.depths import Depths
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.samples import Scalar

SECOND = 1_000_000_000


def test_what_is_sent_counts_while_it_is_fresh_and_for_its_class() -> None:
    depths = Depths(DepthConfig(robots_m=0.2, topics=("red=red/depth",), max_age=5.0))
    assert depths.add("red", Scalar(10 * SECOND, 0.7)) == ""
    both = ("red", "aqua")
    np.testing.assert_array_equal(depths.at(both, 9 * SECOND), [0.2, 0.2])  # not yet sent
    np.testing.assert_array_equal(depths.at(both, 15 * SECOND), [0.7, 0.2])
    np.testing.assert_array_equal(depths.at(both, 15 * SECOND + 1), [0.2, 0.2])  # too old
    depths.clear()
    np.testing.assert_array_equal(depths.at(both, 15 * SECOND), [0.2, 0.2])


def test_a_topic_for_all_and_one_for_a_class() -> None:
    depths = Depths(DepthConfig(topics=("depth", "red=red/depth")))
    depths.add("", Scalar(0, 0.5))
    depths.add("red", Scalar(0, -0.1))  # above the surface counts as at it
    np.testing.assert_array_equal(depths.at(("aqua", "red"), SECOND), [0.5, 0.0])


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (math.nan, "its value is nan"),
        (35.0, "35 m is deeper than any robot"),
        (-0.8, "-0.8 m is above the surface; depths are positive downward"),
    ],
)
def test_a_depth_that_cannot_be_is_refused_and_the_last_one_holds(value: float, words: str) -> None:
    depths = Depths(DepthConfig(topics=("depth",)))
    depths.add("", Scalar(0, 0.5))
    assert words in depths.add("", Scalar(SECOND, value))
    np.testing.assert_array_equal(depths.at(("aqua",), 2 * SECOND), [0.5])


def test_without_any_depth_nothing_is_computed() -> None:
    assert Depths(DepthConfig(sigma_m=0.3)).at(("aqua",), 0) is None


@pytest.mark.parametrize("topics", [("a=x", "a=y"), ("aqua=",), ("x", "y")])
def test_topics_that_contradict_one_another_are_refused(topics: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError, match=r"depth.topics must hold one topic"):
        Depths(DepthConfig(topics=topics))


def test_a_sent_depth_moves_the_published_position_by_snell(sea) -> None:
    """Seen 60 deg off the vertical and 1 m deep: 0.85 m farther north than at the surface."""
    away = 30.0 * math.tan(math.radians(60.0))
    world = sea.World(robots={"a": lambda _t: (0.0, away)}, rpy_deg=lambda _t: (0.0, 35.0, 90.0))
    places = {}
    for sent in (None, 1.0):
        engine = sea.estimator({"depth.topics": ["aqua=aqua/depth"]})
        if sent is not None:
            engine.add_depth("aqua", Scalar(sea.stamp(-0.5), sent))
        places[sent] = sea.play(engine, world, 2.0)[-1].estimates[0].position
        assert engine.inputs["depth_aqua"].count == (sent is not None)
    np.testing.assert_allclose(places[1.0] - places[None], [0.0, 0.847], atol=0.02)


def test_an_uncertain_depth_widens_the_covariance_along_the_view_and_never_averages_out(
    sea,
) -> None:
    """One sigma of 1 m at 60 deg: 0.847 m along the view, none across, however many images."""
    away = 30.0 * math.tan(math.radians(60.0))
    world = sea.World(robots={"a": lambda _t: (0.0, away)}, rpy_deg=lambda _t: (0.0, 35.0, 90.0))
    covariance = {
        sigma: sea.play(sea.estimator({"depth.sigma_m": sigma}), world, 10.0)[-1]
        .estimates[0].covariance
        for sigma in (0.0, 1.0)
    }  # fmt: skip
    more = covariance[1.0] - covariance[0.0]
    np.testing.assert_allclose(more[:2, :2], [[0.0, 0.0], [0.0, 0.847**2]], atol=0.01)
    np.testing.assert_allclose(more[2:], 0.0, atol=1e-9)


def test_a_message_stamped_in_the_past_does_not_replace_a_newer_one() -> None:
    depths = Depths(DepthConfig(topics=("depth",)))
    newer = Scalar(3 * SECOND, 0.9)
    depths.add("", newer)
    depths.add("", replace(newer, stamp_ns=SECOND, value=0.1))
    np.testing.assert_array_equal(depths.at(("aqua",), 4 * SECOND), [0.9])
