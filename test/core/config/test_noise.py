# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sets of sensor noise, and what is stated beside them."""

from __future__ import annotations

from dataclasses import fields

import pytest

from aerial_gnss_ros.core.config.noise import SETS, Noise


@pytest.mark.parametrize("name", SETS)
def test_a_set_has_every_number(name):
    noise = Noise(set=name)
    names = [one.name for one in fields(Noise) if one.name != "set"]
    assert set(names) == set(SETS[name])
    for one in names:
        assert noise.value(one) == SETS[name][one]


def test_what_is_stated_counts_even_if_it_is_0():
    noise = Noise(set="rtk", heading_deg=0.0, height_m=0.7)
    assert noise.value("heading_deg") == 0.0
    assert noise.value("height_m") == 0.7
    assert noise.value("gnss_offset_m") == SETS["rtk"]["gnss_offset_m"]


def test_rtk_is_better_where_it_differs():
    better = [name for name in SETS["rtk"] if SETS["rtk"][name] != SETS["consumer"][name]]
    assert better
    assert all(SETS["rtk"][name] < SETS["consumer"][name] for name in better)


def test_equal_noise_has_one_hash():
    assert hash(Noise(**SETS["rtk"], set="rtk")) == hash(Noise(**SETS["rtk"], set="rtk"))
