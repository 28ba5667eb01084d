# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Depths as they are stated, class by class."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.config.corrections import DepthConfig
from aerial_gnss_ros.core.values.errors import ConfigError


def test_a_class_has_its_own_depth_or_that_of_all():
    config = DepthConfig(robots_m=0.4, classes=("aqua=0.8", "a=b=20", "boat=0"))
    np.testing.assert_array_equal(config.of(["boat", "buoy", "aqua", "a=b"]), [0.0, 0.4, 0.8, 20.0])
    assert config.of([]).shape == (0,)


@pytest.mark.parametrize(
    "entry", ["aqua", "=0.8", "aqua=", "aqua=deep", "aqua=-0.1", "aqua=20.1", "aqua=nan"]
)
def test_an_entry_that_is_no_depth_of_a_class_is_refused(entry):
    with pytest.raises(ConfigError, match=r"depth\.classes must hold entries such as aqua=0\.8"):
        DepthConfig(classes=("boat=1", entry)).of(["boat"])


def test_topics_are_found_by_class():
    config = DepthConfig(topics=("depth", " red = red/depth", "a=b=c"))
    assert config.by_topic() == {"": "depth", "red": "red/depth", "a=b": "c"}


@pytest.mark.parametrize("topics", [("red=",), ("",), ("x", "y"), ("red=x", "red=y")])
def test_topics_that_contradict_one_another_are_refused(topics):
    with pytest.raises(ConfigError, match=r"depth\.topics must hold one topic for all robots"):
        DepthConfig(topics=topics).by_topic()
