# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the engine publishes and reports: methods, labels over a restart, the map, diagnostics."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.telemetry.input_status import InputState
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.samples import Orientation, Scalar

NAN4 = np.full(4, math.nan)


def test_names_outlive_the_program(sea, tmp_path):
    path = tmp_path / "names.json"
    values = {"state_file": str(path)}
    robots = {"a": lambda t: (-6.0 + 0.05 * t, 17.0), "b": lambda _t: (6.0, 20.0)}
    before = sea.play(sea.estimator(values), sea.World(robots=robots), 3.0)
    where = {e.robot_id: e.position for e in before[-1].estimates}
    assert sorted(json.loads(path.read_text())["robots"]) == ["aqua_1", "aqua_2"]
    # half a minute later, seen in another order: the second robot comes into view first
    world = sea.World(robots=robots, hidden=lambda name, t: name == "a" and t < 41.5, seed=8)
    after = sea.play(sea.estimator(values), world, 4.0, begin=40.0)
    for estimate in after[-1].estimates:
        moved = np.hypot(*(estimate.position - where[estimate.robot_id]))
        assert moved < 3.0
    assert len(after[-1].estimates) == 2

    path.write_text("{")
    with pytest.raises(ConfigError, match="damaged"):
        sea.estimator(values)


def test_a_state_file_that_cannot_be_written_is_reported_once_and_stops_nothing(sea, tmp_path):
    folder = tmp_path / "usb"
    folder.mkdir()
    engine = sea.estimator({"state_file": str(folder / "names.json")})
    folder.rmdir()
    results = sea.play(engine, sea.World(robots={"a": lambda _t: (3.0, 22.0)}), 15.0)
    assert results[-1].estimates[0].robot_id == "aqua_1"
    assert sum("cannot be written" in sentence for sentence in engine.events) == 1


def test_a_name_bound_to_a_start(sea):
    latitude, longitude = sea.World().local.places(np.array([[6.0, 20.0]]))
    start = [math.degrees(latitude[0]), math.degrees(longitude[0])]
    engine = sea.estimator({"robots": {"leader": {"class": "aqua", "start": start}}})
    robots = {"a": lambda _t: (-8.0, 17.0), "b": lambda _t: (6.0, 20.0)}
    last = sea.play(engine, sea.World(robots=robots), 2.0)[-1]
    east = {e.robot_id: e.position[0] for e in last.estimates}
    assert east == pytest.approx({"aqua_1": -8.0, "leader": 6.0}, abs=0.01)


def test_map_datum_is_the_first_accepted_fix(sea):
    engine = sea.estimator({"map.latitude_deg": math.nan, "map.longitude_deg": math.nan})
    engine.add_detections(sea.boxes(0.0, []))
    assert engine.flush()[0].datum is None
    world = sea.World()
    engine.add_fix(replace(world.fix(0.1), valid=False))
    engine.add_fix(world.fix(0.2))
    engine.add_fix(replace(world.fix(0.3), latitude=0.1))
    engine.add_detections(sea.boxes(0.4, []))
    datum = engine.flush()[0].datum
    assert datum.latitude == world.fix(0.2).latitude
    assert math.isnan(datum.altitude)  # fix.altitude_datum is unknown
    assert engine.take_events() == [
        "A message on fix is of no use: the receiver reports no fix.",
        "Altitude of the fix: from an unknown datum, not used; height: height above the water.",
        "The origin of map is 13.1940000, -59.6415000 (the first accepted fix).",
    ]


def test_an_unknown_altitude_is_reported_once(sea):
    engine = sea.estimator()
    sea.play(engine, sea.World(), 2.0)
    assert sum("altitudes are NaN" in sentence for sentence in engine.events) == 1
    known = sea.estimator({"fix.altitude_datum": "ellipsoid"})
    results = sea.play(known, sea.World(robots={"a": lambda _t: (3.0, 22.0)}), 2.0)
    assert results[-1].estimates[0].altitude == pytest.approx(0.0, abs=1e-3)
    assert not any("altitudes" in sentence for sentence in known.events)


def test_water_level_holds_until_replaced(sea):
    """Height above home 32 m, water 2 m above home: 30 m; then the tide falls to 0: 32 m."""
    engine = sea.estimator({"tracks.confirm_hits": 1, "tracks.gate_probability": 0.5})
    world = sea.World()
    engine.add_camera(sea.stamp(0.0), sea.camera)
    engine.add_water_level(Scalar(sea.stamp(0.0), 2.0))
    heights = {}
    for i in range(1000):
        t = 0.1 * i
        if i == 500:
            engine.add_water_level(Scalar(sea.stamp(t), 0.0))
        engine.add_fix(world.fix(t))
        engine.add_gimbal(world.gimbal(t))
        engine.add_height(Scalar(sea.stamp(t), 32.0))
        engine.add_detections(sea.boxes(t, []))
        for result in engine.advance(sea.stamp(t)):
            heights[i] = result.pose.height
    assert [heights[i] for i in (0, 499, 500, 999)] == [30.0, 30.0, 32.0, 32.0]


def test_input_states_for_diagnostics(sea):
    engine, world = sea.estimator(), sea.World()
    assert engine.inputs["fix"].state is InputState.WAITING
    engine.add_fix(world.fix(0.0))
    engine.add_gimbal(Orientation(sea.stamp(0.0), NAN4))
    states = {name: status.state for name, status in engine.inputs.items()}
    assert states["fix"] is InputState.OK
    assert states["gimbal"] is InputState.BAD
    assert states["height"] is InputState.WAITING
    assert states["attitude"] is InputState.UNUSED
    assert states["water_level"] is InputState.CONSTANT
    engine.add_detections(sea.boxes(10.0, []))
    assert engine.inputs["fix"].state is InputState.STALE
    assert (engine.inputs["gimbal"].count, engine.inputs["gimbal"].bad) == (1, 1)


def test_same_messages_same_results(sea):
    def fly():
        world = sea.World(robots={"a": lambda t: (0.2 * t, 20.0)}, pixel_sigma=2.0, clutter=0.3)
        results = sea.play(sea.estimator(), world, 5.0)
        return [
            (e.robot_id, e.position.tobytes(), e.covariance.tobytes())
            for r in results
            for e in r.estimates
        ]

    assert fly() == fly()
