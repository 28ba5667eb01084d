# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One level of evidence, in three forms."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.models.evidence import CLEAR_NATS, TUNING, UNCLEAR


def test_log_odds_and_probability_are_those_of_the_odds():
    assert math.exp(CLEAR_NATS) == pytest.approx(TUNING.clear_odds)
    assert UNCLEAR * TUNING.clear_odds == pytest.approx(1.0)
    assert TUNING.forgotten < UNCLEAR < 0.5
