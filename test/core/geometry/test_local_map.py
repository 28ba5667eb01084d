# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The frame `map` there and back, and against geodesics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse
from aerial_gnss_ros.core.geometry.local_map import LocalMap
from aerial_gnss_ros.core.values.estimates import MapDatum


@given(
    st.floats(-80.0, 80.0),
    st.floats(-180.0, 180.0),
    st.floats(-20_000.0, 20_000.0),
    st.floats(-20_000.0, 20_000.0),
)
def test_there_and_back_to_a_millimetre_within_20_km(latitude, longitude, east, north):
    local = LocalMap(MapDatum(math.radians(latitude), math.radians(longitude), math.nan))
    there = local.places(np.array([[east, north]]))
    assert local.positions(*there)[0] == pytest.approx([east, north], abs=1e-3)


def test_distances_are_those_on_the_ellipsoid():
    origin = MapDatum(math.radians(13.194), math.radians(-59.6415), math.nan)
    latitude, longitude = LocalMap(origin).places(np.array([[300.0, -400.0]]))
    distance, azimuth, _ = geodesic_inverse(
        origin.latitude, origin.longitude, float(latitude[0]), float(longitude[0])
    )
    assert distance == pytest.approx(500.0, abs=1e-3)
    assert math.degrees(azimuth) == pytest.approx(
        180.0 - math.degrees(math.atan2(300.0, 400.0)), abs=1e-3
    )
