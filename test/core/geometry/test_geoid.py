# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""EGM96 against NGA's published points, and where the grid ends: poles and 180 deg."""

from __future__ import annotations

import csv
import math

import pytest

from aerial_gnss_ros.core.geometry import geoid
from aerial_gnss_ros.core.values.errors import InputError


def at(latitude_deg, longitude_deg):
    return geoid.undulation(math.radians(latitude_deg), math.radians(longitude_deg))


def test_ngas_published_points(shared_data):
    with (shared_data / "geodesy_vectors" / "egm96_nga.csv").open(newline="") as file:
        rows = [[float(text) for text in row.values()] for row in csv.DictReader(file)]
    assert len(rows) == 6
    for latitude, longitude, expected in rows:
        assert at(latitude, longitude) == pytest.approx(expected, abs=0.012)


def test_known_extremes_and_poles():
    assert at(90.0, 12.0) == pytest.approx(13.61, abs=0.005)  # NGA's grid value at the pole
    assert at(-90.0, -100.0) == pytest.approx(-29.53, abs=0.005)
    assert at(4.75, 78.75) == pytest.approx(-106.99, abs=0.3)  # the low south of Sri Lanka
    assert at(13.25, -59.75) == pytest.approx(-47.44, abs=0.01)  # a grid point, Barbados


@pytest.mark.parametrize("latitude", [-89.99, -16.5, 0.0, 51.37, 89.99])
def test_nothing_jumps_at_the_antimeridian_or_between_cells(latitude):
    assert at(latitude, 180.0) == pytest.approx(at(latitude, -180.0), abs=1e-9)
    assert at(latitude, 179.999999) == pytest.approx(at(latitude, -179.999999), abs=1e-4)
    assert at(latitude, 359.5) == pytest.approx(at(latitude, -0.5), abs=1e-9)
    assert at(latitude - 1e-7, 10.25) == pytest.approx(at(latitude + 1e-7, 10.25), abs=1e-4)


def test_no_place_is_refused():
    for latitude, longitude in ((math.nan, 0.0), (2.0, 0.0), (0.0, math.inf)):
        with pytest.raises(InputError, match="not on Earth"):
            geoid.undulation(latitude, longitude)


def test_a_missing_grid_is_named(monkeypatch, tmp_path):
    geoid._grid.cache_clear()
    monkeypatch.setattr(geoid, "GRID", tmp_path / "absent.npz")
    with pytest.raises(InputError, match=r"absent\.npz is missing"):
        at(1.0, 2.0)
    geoid._grid.cache_clear()
