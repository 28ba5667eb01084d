# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real flights become bags, and what default parameters reach on them is held."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import real_flights
import real_water
from box_chains import chains

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion

LIMITS = {
    "DJI_0011_d3": (0.9, 1.1),
    "DJI_0032": (0.85, 1.1),
    "DJI_0063": (0.9, 1.15),
    "NorthSea_Fri_DJI_0113": (0.9, 1.15),
    "NorthSea_Fri_DJI_0114": (0.57, 1.15),
    "NorthSea_Fri_DJI_0116": (0.73, 1.4),
    "NorthSea_Sat_DJI_0122": (0.88, 1.1),
    "NorthSea_Thu_DJI_0107": (0.75, 1.4),
    "NorthSea_Thu_DJI_0108": (0.8, 1.2),
}
"""Least share of the boxes steeper than 15 deg that are used, and most names an object, by flight:
what is reached, with room."""
SPREAD_M = (1.2, 4.0)
"""Median and 90 % of the spread of the buoys seen steeply from NorthSea_Fri_DJI_0113, m: what is
reached, with room; 3 m are the aim for the latter."""
HEAD = (
    "frame_no,t_s,latitude_deg,longitude_deg,height_above_takeoff_m,compass_heading_deg,"
    "gimbal_heading_deg,gimbal_pitch_down_deg,datetime_utc,width_px,height_px\n"
)


@pytest.fixture
def folder(tmp_path):
    """Return a flight that looks East, then South, 30 deg down; its third image has no box."""
    flight = tmp_path / "flight"
    flight.mkdir()
    at = "53.72,7.16,30.0,80.0"
    (flight / "telemetry.csv").write_text(
        f"{HEAD}0,0.0,{at},90.0,30.0,12:00:00,3840,2160\n15,0.5,{at},90.0,30.0,12:00:00,3840,2160\n"
        f"30,1.0,{at},180.0,30.0,12:00:01,3840,2160\n"
    )
    (flight / "boxes.csv").write_text(
        "frame_no,class,x_px,y_px,width_px,height_px\n0,buoy,1900,1060,40,40\n"
        "15,buoy,1900,1060,40,40\n15,boat,100,200,60,20\n30,,,,,\n"
    )
    return flight


def test_a_flight_becomes_a_bag_with_each_sample_once(folder, tmp_path):
    counts = real_water.write_bag(real_water.Tables.of(folder), tmp_path / "bag")
    assert counts == {
        "/camera/camera_info": 3, "/detections": 3, "/fix": 2, "/gimbal": 2, "/height": 2,
    }  # fmt: skip
    with open_bag([tmp_path / "bag"]) as bag:
        found = [(one.topic, one.log_ns, one.message()) for one in bag.messages(list(counts))]
    boxes = [message.detections for topic, _, message in found if topic == "/detections"]
    assert [len(one) for one in boxes] == [1, 2, 0]
    centre = boxes[0][0].bbox.center.position
    assert (centre.x, centre.y) == (1920.0, 1080.0)
    stamps = [log_ns for topic, log_ns, _ in found if topic == "/fix"]
    assert stamps[1] - stamps[0] == 1_000_000_000
    counts = real_water.write_bag(real_water.Tables.of(folder, True), tmp_path / "each")
    assert [counts[f"/{name}"] for name in ("fix", "gimbal", "height")] == [3, 3, 3]


def test_a_flight_backwards_has_its_samples_at_the_same_moments(folder):
    """Two were written, at 0 s and at 1 s: the second one comes first, half a second ahead."""
    tables = real_water.Tables.of(folder).backwards()
    assert [row["t_s"] for row in tables.rows] == ["0.0", "0.5", "1.0"]
    assert [row["frame_no"] for row in tables.rows] == ["30", "15", "0"]
    assert [(row["frame_no"], row["t_s"]) for row in tables.samples] == [
        ("30", "0.0"),
        ("0", "1.0"),
    ]
    assert [box["frame_no"] for box in tables.boxes] == ["30", "15", "15", "0"]
    late = real_water.Tables.of(folder).part(0.4, 1.0)
    assert [len(table) for table in (late.rows, late.samples, late.boxes)] == [2, 1, 3]


def test_headings_count_from_north_and_pitch_downward(folder):
    rows = real_water.read(folder / "telemetry.csv")
    along = [matrix_from_quaternion(real_water.gimbal(row).quaternion)[:, 0] for row in rows]
    down = math.sin(math.radians(30.0))
    np.testing.assert_allclose(along[0], [math.sqrt(1 - down**2), 0.0, -down], atol=1e-9)
    np.testing.assert_allclose(along[2], [0.0, -math.sqrt(1 - down**2), -down], atol=1e-9)


def test_boxes_that_shift_together_are_chained():
    def image(second, shift, objects):
        at = round(second * 1e9)
        return [((at, u + shift, 500.0), kind) for u, kind in objects]

    objects = [(100.0, "buoy"), (400.0, "buoy"), (900.0, "boat")]
    boxes = image(0.0, 0.0, objects) + image(0.5, 320.0, objects) + image(1.0, 640.0, objects[1:])
    lengths = sorted((len(one), one[0][0][1]) for one in chains(boxes))
    # A shift of nearly the distance between two objects of a class does not exchange them.
    assert lengths == [(2, 100.0), (3, 400.0), (3, 900.0)]
    late = image(0.0, 0.0, objects) + image(5.0, 0.0, objects)
    assert {len(one) for one in chains(late)} == {1}


@pytest.mark.parametrize("name", LIMITS)
def test_nothing_but_that_the_latency_is_unknown_is_stated(name, shared_data):
    flights = shared_data / "real_water" / "flights"
    if not flights.is_dir():
        pytest.skip(f"no real flights: {flights} is absent")
    tables = real_water.Tables.of(flights / name)
    flight = real_flights.fly(tables, estimator_config({"camera.find_latency": True}))
    least, most = LIMITS[name]
    assert flight.used(flight.steep) > least
    names = [len({one.robot_id for one in found}) for _, found in flight.objects()]
    assert np.mean(names) <= most
    apart, whole, _ = real_flights.moored(flight)
    if name == "NorthSea_Fri_DJI_0113":
        assert np.median(apart) < SPREAD_M[0]
        assert np.percentile(apart, 90) < SPREAD_M[1]
        assert np.mean(whole < real_flights.CHI2_90) > 0.75


@pytest.mark.parametrize(("text", "value"), [("true", True), ("-9", -9.0), ("home", "home")])
def test_parameters_of_any_kind_can_be_set(text, value):
    key, given = real_flights._halves(f"height.reference={text}")
    assert key == "height.reference"
    assert real_flights._value(given) == value
    assert type(real_flights._value(given)) is type(value)
