# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""WGS84 against published vectors and an independent library."""

from __future__ import annotations

import csv
import math

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.core.geometry import geodesy
from aerial_gnss_ros.core.values.estimates import MapDatum

latitudes = st.floats(-89.9, 89.9)
longitudes = st.floats(-180.0, 180.0)


def _rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_geodesics_agree_with_karneys_vectors(shared_data):
    rows = _rows(shared_data / "geodesy_vectors" / "geodesic_wgs84_karney20.csv")
    assert len(rows) == 20
    for row in rows:
        lat1, lon1, azi1, lat2, lon2, azi2 = (
            math.radians(float(row[name]))
            for name in ("lat1", "lon1", "azi1", "lat2", "lon2", "azi2")
        )
        length = float(row["s12_m"])
        distance, out, onward = geodesy.geodesic_inverse(lat1, lon1, lat2, lon2)
        assert distance == pytest.approx(length, abs=1e-7)
        assert math.cos(out - azi1) == pytest.approx(1.0, abs=1e-15)
        assert math.cos(onward - azi2) == pytest.approx(1.0, abs=1e-15)


def test_earth_centred_coordinates_agree_with_published_vectors(shared_data):
    rows = _rows(shared_data / "geodesy_vectors" / "ecef_aer.csv")
    checked = 0
    for row in rows:
        values = {name: float(value) for name, value in row.items() if value and name != "kind"}
        if row["kind"] != "geodetic2ecef":
            continue
        place = math.radians(values["in1"]), math.radians(values["in2"]), values["in3"]
        expected = [values["out1"], values["out2"], values["out3"]]
        assert geodesy.ecef_from_geodetic(*place) == pytest.approx(expected, abs=0.03)
        checked += 1
    assert checked > 0


@given(latitudes, longitudes, st.floats(-500.0, 10000.0))
def test_earth_centred_coordinates_agree_with_pymap3d_and_come_back(lat, lon, alt):
    xyz = geodesy.ecef_from_geodetic(math.radians(lat), math.radians(lon), alt)
    assert xyz == pytest.approx(pymap3d.geodetic2ecef(lat, lon, alt), abs=1e-6)
    back = geodesy.geodetic_from_ecef(xyz)
    again = geodesy.ecef_from_geodetic(*back)
    assert again == pytest.approx(xyz, abs=1e-5)  # PROJ's own inverse is good to micrometres
    assert float(back[2]) == pytest.approx(alt, abs=1e-5)


@given(latitudes, longitudes, st.tuples(*[st.floats(-2000.0, 2000.0)] * 3))
def test_local_coordinates_agree_with_pymap3d_and_come_back(lat0, lon0, enu):
    origin = math.radians(lat0), math.radians(lon0), 30.0
    place = geodesy.geodetic_from_enu(*enu, *origin)
    there = pymap3d.enu2geodetic(*enu, lat0, lon0, 30.0)
    assert pymap3d.geodetic2enu(*there, lat0, lon0, 30.0) == pytest.approx(enu, abs=1e-5)
    assert math.degrees(place[0]) == pytest.approx(there[0], abs=1e-10)
    assert geodesy.enu_from_geodetic(*place, *origin) == pytest.approx(enu, abs=1e-5)


def test_many_points_at_once_and_one_alone_agree():
    rng = np.random.default_rng(3)
    enu = rng.normal(scale=100.0, size=(6, 3))
    origin = 0.23, -1.04, 5.0
    lat, lon, alt = geodesy.geodetic_from_enu(enu[:, 0], enu[:, 1], enu[:, 2], *origin)
    assert geodesy.enu_from_geodetic(lat, lon, alt, *origin) == pytest.approx(enu, abs=1e-6)
    one = geodesy.geodetic_from_enu(*enu[4], *origin)
    assert (float(one[0]), float(one[1])) == (lat[4], lon[4])


def test_axes_point_east_north_and_up():
    axes = geodesy.enu_axes(0.0, 0.0)
    assert axes == pytest.approx(np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]))


def test_across_the_antimeridian_east_stays_small():
    west, east = math.radians(-179.9999), math.radians(179.9999)
    enu = geodesy.enu_from_geodetic(0.0, west, 0.0, 0.0, east, 0.0)
    assert enu[0] == pytest.approx(0.0002 * 111319.49, abs=0.01)


def test_haversine_is_the_spheres_distance():
    degree = math.radians(1.0)
    assert geodesy.haversine(0.0, 0.0, degree, 0.0) == pytest.approx(111195.08, abs=0.1)
    exact, _, _ = geodesy.geodesic_inverse(0.0, 0.0, degree, 0.0)
    assert exact == pytest.approx(110574.39, abs=0.01)


@given(st.lists(st.tuples(st.floats(-90.0, 90.0), longitudes, st.floats(-500.0, 1e4)), max_size=12))
def test_few_points_become_geodetic_as_many_do(places):
    lat, lon, alt = np.array(places, dtype=np.float64).reshape(-1, 3).T
    xyz = geodesy.ecef_from_geodetic(np.radians(lat), np.radians(lon), alt)
    few = geodesy.geodetic_from_ecef(xyz)
    many = geodesy.geodetic_from_ecef(np.concatenate([xyz, np.full((13, 3), 6.3e6)]))
    for one, other, off in zip(few, many, (1e-15, 1e-15, 1e-8), strict=True):
        assert one == pytest.approx(other[: len(places)], abs=off)


@given(
    st.floats(-80.0, 80.0),
    st.floats(-180.0, 180.0),
    st.floats(-20_000.0, 20_000.0),
    st.floats(-20_000.0, 20_000.0),
)
def test_the_map_there_and_back_to_a_millimetre_within_20_km(latitude, longitude, east, north):
    local = geodesy.LocalMap(MapDatum(math.radians(latitude), math.radians(longitude), math.nan))
    there = local.places(np.array([[east, north]]))
    assert local.positions(*there)[0] == pytest.approx([east, north], abs=1e-3)


def test_distances_in_the_map_are_those_on_the_ellipsoid():
    origin = MapDatum(math.radians(13.194), math.radians(-59.6415), math.nan)
    latitude, longitude = geodesy.LocalMap(origin).places(np.array([[300.0, -400.0]]))
    distance, azimuth, _ = geodesy.geodesic_inverse(
        origin.latitude, origin.longitude, float(latitude[0]), float(longitude[0])
    )
    assert distance == pytest.approx(500.0, abs=1e-3)
    assert math.degrees(azimuth) == pytest.approx(
        180.0 - math.degrees(math.atan2(300.0, 400.0)), abs=1e-3
    )


@pytest.mark.parametrize("latitude", [-70.0, 0.0, 13.0, 54.0])
def test_a_radian_is_as_long_as_pymap3d_says(latitude):
    east, north = geodesy.metres_per_radian(math.radians(latitude))
    step = 1e-5
    for d_lat, d_lon, metres in ((0.0, step, east), (step, 0.0, north)):
        enu = pymap3d.geodetic2enu(latitude + d_lat, d_lon, 0.0, latitude, 0.0, 0.0)
        assert math.hypot(*enu[:2]) == pytest.approx(metres * math.radians(step), rel=1e-6)
