# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The laws beside the joint states take in the same images, and begin anew together."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.alternative_laws import AlternativeLaws
from aerial_gnss_ros.core.models.platform_model import COUNT, PlatformModel


class Asked:
    """Notes what a law is asked for; answers an update with whether another time is assumed."""

    def __init__(self, asked, name, answer=False):
        self._asked, self._name, self._answer = asked, name, answer

    def __getattr__(self, verb):
        def note(*_):
            self._asked.append(f"{self._name} {verb}")
            return self._answer

        return note


@pytest.fixture
def laws():
    return AlternativeLaws(PlatformModel(estimator_config({}).noise, "earth"), find_moored=True)


def asked_of(laws, changed=False):
    """Let laws note what they are asked for."""
    asked = []
    laws.moored, laws.times = Asked(asked, "moored"), Asked(asked, "times", changed)
    return asked


def test_while_the_latency_is_unknown_no_correlation_time_is_weighed(laws):
    for late, expected in (
        (True, ["moored predict"]),
        (False, ["times predict", "moored predict"]),
    ):
        asked = asked_of(laws)
        laws.predict([SimpleNamespace()], 0.1, np.eye(COUNT), None, late)
        assert asked == expected


@pytest.mark.parametrize(
    ("first", "changed", "expected"),
    [
        (False, True, ["moored update"]),
        (True, False, ["moored update", "times update"]),
        (True, True, ["moored update", "times update", "moored reset"]),
    ],
)
def test_only_the_first_group_tells_the_time_and_another_one_is_another_law(
    laws, first, changed, expected
):
    asked = asked_of(laws, changed)
    assert laws.update(None, first, None, None, None, 1.0) is (first and changed)
    assert asked == expected


def test_that_robots_stay_is_only_weighed_if_it_is_asked(laws):
    asked = asked_of(laws)
    laws.restart()
    laws.moored = None
    laws.restart()
    assert asked == ["moored reset", "times restart", "times restart"]
    model = PlatformModel(estimator_config({}).noise, "earth")
    assert AlternativeLaws(model, find_moored=False).moored is None


def test_all_laws_jump_with_the_receiver(laws):
    asked = asked_of(laws)
    laws.shift(np.zeros(2))
    assert asked == ["moored shift", "times shift"]
    laws.moored = None
    laws.shift(np.zeros(2))
    assert asked[2:] == ["times shift"]
