# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rays to the curved water against published vectors and pymap3d."""

from __future__ import annotations

import csv
import math

import numpy as np
import pymap3d.los
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, yaw_from_heading
from aerial_gnss_ros.core.geometry.water_surface import SurfaceView
from aerial_gnss_ros.core.values.camera_pose import CameraPose


def _view(lat_deg, lon_deg, height, altitude=None):
    altitude = height if altitude is None else altitude
    return SurfaceView(
        CameraPose(0, math.radians(lat_deg), math.radians(lon_deg), height, altitude, np.eye(3))
    )


def _ray(azimuth_deg, tilt_deg):
    pitch = math.radians(90.0 - tilt_deg)
    return matrix_from_rpy(0.0, pitch, yaw_from_heading(math.radians(azimuth_deg)))[None, :, 0]


def test_rays_meet_the_ellipsoid_where_the_published_vectors_say(shared_data):
    with (shared_data / "geodesy_vectors" / "ray_to_ellipsoid.csv").open(newline="") as file:
        rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]
    missed = 0
    for row in rows:
        view = _view(row["lat0"], row["lon0"], row["h0_m"])
        ray = _ray(row["azimuth_deg"], row["tilt_from_nadir_deg"])
        distance = view.distances(ray)
        if math.isnan(row["slant_range_m"]):
            assert math.isnan(distance[0])
            missed += 1
            continue
        lat, lon, altitude = view.geodetic(ray * distance[:, None])
        assert distance[0] == pytest.approx(row["slant_range_m"], abs=0.03)
        assert math.degrees(lat[0]) == pytest.approx(row["lat"], abs=1e-6)
        assert math.degrees(lon[0]) == pytest.approx(row["lon"], abs=1e-6)
        assert altitude[0] == pytest.approx(0.0, abs=1e-6)
    assert 0 < missed < len(rows)


@given(
    st.floats(-85.0, 85.0),
    st.floats(-179.0, 179.0),
    st.floats(1.0, 500.0),
    st.floats(0.0, 360.0),
    st.floats(0.0, 85.0),
)
def test_rays_agree_with_pymap3d(lat, lon, height, azimuth, tilt):
    expected = pymap3d.los.lookAtSpheroid(lat, lon, height, azimuth, tilt)
    view = _view(lat, lon, height)
    ray = _ray(azimuth, tilt)
    distance = view.distances(ray)
    assert distance[0] == pytest.approx(float(expected[2]), abs=1e-4)
    there = np.degrees(np.array(view.geodetic(ray * distance[:, None])[:2])).ravel()
    assert there[0] == pytest.approx(float(expected[0]), abs=1e-9)
    across = (there[1] - float(expected[1])) * math.cos(math.radians(lat))
    assert across == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("level", [-40.0, 0.0, 100.0])
def test_points_lie_on_the_waters_level(level):
    view = _view(13.2, -59.6, 30.0, 30.0 + level)
    rays = np.vstack([_ray(azimuth, 60.0) for azimuth in (0, 77, 200)])
    offsets = rays * view.distances(rays)[:, None]
    assert view.geodetic(offsets)[2] == pytest.approx(level, abs=2e-4)
    up = view.normals(offsets)
    assert np.linalg.norm(up, axis=1) == pytest.approx(1.0)
    assert up[:, 2] == pytest.approx(1.0, abs=1e-9)
    assert up[:, :2] == pytest.approx(offsets[:, :2] / 6.37e6, abs=1e-7)


def test_an_unknown_datum_moves_nothing_by_a_millimetre_at_working_range():
    # Barbados: the sea lies 40 m below the ellipsoid. 60 deg off nadir from 50 m: 87 m away.
    ray = _ray(120.0, 60.0)
    known, unknown = _view(13.2, -59.6, 50.0, 10.0), _view(13.2, -59.6, 50.0, math.nan)
    there = [view.geodetic(ray * view.distances(ray)[:, None])[:2] for view in (known, unknown)]
    moved = (np.array(there[0]) - np.array(there[1])).ravel() * 6.4e6
    assert 1e-5 < np.linalg.norm(moved) < 1e-3


def test_the_horizon_dips_with_height():
    # sqrt(2 h / R): 30 m gives 10.5 minutes of arc
    view = _view(0.0, 0.0, 30.0)
    assert math.degrees(view.dip) * 60.0 == pytest.approx(10.55, abs=0.01)
    just_above, just_below = view.dip - 2e-5, view.dip + 2e-5
    rays = np.vstack([_ray(0.0, 90.0 - math.degrees(down)) for down in (just_above, just_below)])
    assert np.isnan(view.distances(rays)).tolist() == [True, False]
