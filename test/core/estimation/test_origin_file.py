# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A node that is started again goes on in the same frame `map`, with the same names."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.estimation.origin_file import OriginKeeper
from aerial_gnss_ros.core.values.estimates import MapDatum


def flown(sea, session, begin, **values):
    """Fly over a robot, the drone under way to the east; return the last result."""
    engine = Estimator(estimator_config(values), session=session)
    world = sea.World(drone=lambda t: (0.5 * t, 0.0, 30.0), robots={"a": lambda t: (0.5 * t, 17.0)})
    results = sea.play(engine, world, 5.0, begin=begin, until_flush=False)
    return results[-1]


def test_names_and_origin_outlive_a_node_that_is_killed(sea, tmp_path):
    session = tmp_path / "names.json"
    before, after = (flown(sea, session, begin) for begin in (0.0, 8.0))
    assert [one.robot_id for one in after.estimates] == ["aqua_1"]
    assert after.datum.latitude == pytest.approx(before.datum.latitude, abs=1e-12)
    assert after.datum.longitude == pytest.approx(before.datum.longitude, abs=1e-12)
    moved = after.estimates[0].position - before.estimates[0].position
    assert moved == pytest.approx([4.0, 0.0], abs=0.5)
    fresh = flown(sea, None, 8.0)
    assert fresh.datum.longitude > before.datum.longitude


def test_another_session_begins_with_new_names_where_it_is(sea, tmp_path):
    flown(sea, tmp_path / "one.json", 0.0)
    other = flown(sea, tmp_path / "two.json", 8.0)
    # the robot is 6.5 m east by then, the drone began at 4 m
    assert other.estimates[0].position[0] == pytest.approx(2.5, abs=0.5)


def test_a_configured_origin_goes_before(sea, tmp_path):
    session = tmp_path / "names.json"
    flown(sea, session, 0.0)
    given = {"map.latitude_deg": 13.19, "map.longitude_deg": -59.64}
    assert math.degrees(flown(sea, session, 8.0, **given).datum.latitude) == pytest.approx(13.19)


@pytest.mark.parametrize("text", ["", "[1, 2]", '["a", 2, 3]', "[95.0, 0.0, 1.0]", "{}"])
def test_a_damaged_file_is_left_out(tmp_path, text):
    session = tmp_path / "names.json"
    (tmp_path / "names.origin.json").write_text(text)
    assert OriginKeeper(session).load() is None


def test_an_unknown_altitude_stays_unknown(tmp_path):
    session = tmp_path / "names.json"
    OriginKeeper(session).keep(MapDatum(0.2, -1.0, math.nan))
    loaded = OriginKeeper(session).load()
    assert (loaded.latitude, loaded.longitude) == (pytest.approx(0.2), pytest.approx(-1.0))
    assert math.isnan(loaded.altitude)
    OriginKeeper(tmp_path / "absent" / "names.json").keep(loaded)  # a full disk ends no flight
