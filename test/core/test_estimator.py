# SPDX-License-Identifier: Apache-2.0
"""The engine: every refusal, waiting, latency, clocks, order, restarts."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.core.errors import ConfigError
from aerial_gnss_ros.core.estimator import MAX_WAITING
from aerial_gnss_ros.core.inputs import InputState
from aerial_gnss_ros.core.rejection import Reason
from aerial_gnss_ros.core.values import Fix, Orientation, Scalar, State

MIDDLE = [640.0, 360.0]
NAN4 = np.full(4, math.nan)
BODY = {"gimbal.reference": "heading"}


class Scene:
    """One image at t = 1 s with everything it needs, from which a test takes something away."""

    def __init__(self, sea, values=None):
        self.sea = sea
        self.engine = sea.estimator(values)
        self.world = sea.World()
        self.boxes = sea.boxes(1.0, [MIDDLE])
        self.camera = (0.0, sea.camera)
        self.samples = {name: (0.9, 1.1) for name in ("fix", "attitude", "gimbal", "height")}
        self.change = {}

    def _value(self, name, t):
        if name in self.change:
            return self.change[name](self.sea.stamp(t))
        if name == "attitude":
            return Orientation(self.sea.stamp(t), np.array([0.0, 0.0, 0.0, 1.0]))
        return getattr(self.world, name)(t)

    def feed(self):
        if self.camera is not None:
            self.engine.add_camera(self.sea.stamp(self.camera[0]), self.camera[1])
        for name, times in self.samples.items():
            for t in times:
                getattr(self.engine, f"add_{name}")(self._value(name, t))
        self.engine.add_detections(self.boxes)

    def run(self):
        self.feed()
        results = self.engine.advance(self.sea.stamp(1.2))
        results += self.engine.advance(self.sea.stamp(30.0))
        assert [result.stamp_ns for result in results] == [self.boxes.stamp_ns]
        return results[0]


def _without(name):
    def change(scene):
        scene.samples[name] = ()

    return change


def _late(name):
    def change(scene):
        scene.samples[name] = (0.5, 0.9)

    return change


def _gap(name):
    def change(scene):
        scene.samples[name] = (-2.0, 2.0)

    return change


def _value(name, make):
    def change(scene):
        scene.change[name] = make

    return change


def _boxes(**fields):
    def change(scene):
        scene.boxes = replace(scene.boxes, **fields)

    return change


def _camera(value):
    def change(scene):
        scene.camera = value

    return change


def _nothing(_scene):
    pass


REFUSALS = [
    (Reason.LOW_SCORE, {"detections.min_score": 0.95}, _nothing),
    (Reason.WRONG_CLASS, {"detections.classes": ["boat"]}, _nothing),
    (Reason.BAD_DETECTIONS, {}, _boxes(centers=np.array([[math.nan, 1.0]]))),
    (Reason.BAD_DETECTIONS, {}, _boxes(scores=np.array([math.nan]))),
    (Reason.BAD_DETECTIONS, {}, _boxes(sizes=np.array([[-1.0, 3.0]]))),
    (Reason.NO_CAMERA_INFO, {}, _camera(None)),
    (Reason.NO_CAMERA_INFO, {}, lambda s: setattr(s, "camera", (1.5, s.sea.camera))),
    (Reason.BAD_CAMERA_INFO, {}, _camera((0.0, None))),
    (Reason.OUTSIDE_CALIBRATED_IMAGE, {}, _boxes(centers=np.array([[1500.0, 360.0]]))),
    (
        Reason.ABOVE_HORIZON,
        {},
        lambda s: setattr(s.world, "rpy_deg", lambda _t: (0.0, -5.0, 90.0)),
    ),
    (Reason.OUT_OF_RANGE, {"surface.max_range": 20.0}, _nothing),
    (Reason.NO_FIX, {}, _without("fix")),
    (Reason.NO_ATTITUDE, BODY, _without("attitude")),
    (Reason.NO_GIMBAL, {}, _without("gimbal")),
    (Reason.NO_HEIGHT, {}, _without("height")),
    (Reason.STALE_FIX, {}, _late("fix")),
    (Reason.STALE_ATTITUDE, BODY, _late("attitude")),
    (Reason.STALE_GIMBAL, {}, _late("gimbal")),
    (Reason.STALE_HEIGHT, {}, _late("height")),
    (Reason.GAP_FIX, {}, _gap("fix")),
    (Reason.GAP_ATTITUDE, BODY, _gap("attitude")),
    (Reason.GAP_GIMBAL, {}, _gap("gimbal")),
    (Reason.GAP_HEIGHT, {}, _gap("height")),
    (Reason.BAD_FIX, {}, _value("fix", lambda ns: Fix(ns, 0.2, -1.0, 3.0, valid=False))),
    (Reason.BAD_FIX, {}, _value("fix", lambda ns: Fix(ns, math.nan, -1.0, 3.0))),
    (Reason.BAD_ATTITUDE, BODY, _value("attitude", lambda ns: Orientation(ns, np.zeros(4)))),
    (Reason.BAD_GIMBAL, {}, _value("gimbal", lambda ns: Orientation(ns, NAN4))),
    (Reason.BAD_GIMBAL, {}, _value("gimbal", lambda ns: Orientation(ns, np.full(4, 0.6)))),
    (Reason.BAD_HEIGHT, {}, _value("height", lambda ns: Scalar(ns, math.nan))),
    (Reason.BAD_HEIGHT, {}, _value("height", lambda ns: Scalar(ns, -2.0))),
]


@pytest.mark.parametrize(
    ("reason", "values", "change"), REFUSALS, ids=[f"{i}-{r[0]}" for i, r in enumerate(REFUSALS)]
)
def test_every_refusal_by_its_smallest_scene(sea, reason, values, change):
    scene = Scene(sea, values)
    change(scene)
    result = scene.run()
    assert [rejection.reason for rejection in result.rejections] == [reason]
    assert scene.engine.counts == Counter({reason: 1})
    u, v = result.rejections[0].u_px, result.rejections[0].v_px
    assert [u, v] == pytest.approx(scene.boxes.centers[0], nan_ok=True)
    assert result.estimates == ()


def test_the_table_above_leaves_out_no_reason():
    told = {reason for reason, _, _ in REFUSALS}
    assert set(Reason) - told == {Reason.GATED}  # in test_tracks: a second box on a robot


def test_nothing_is_refused_where_nothing_is_missing(sea):
    result = Scene(sea, {"tracks.confirm_hits": 1}).run()
    assert result.rejections == ()
    # 30 m up, 60 deg below the horizon: 30 / tan 60 deg = 17.3205 m ahead (north)
    assert result.estimates[0].position == pytest.approx([0.0, 17.3205], abs=1e-3)
    assert result.estimates[0].state is State.CONFIRMED
    assert result.pose.oldest_age_s == pytest.approx(0.1)


def test_one_bad_neighbour_refuses_the_scene_between(sea):
    scene = Scene(sea)
    scene.change["gimbal"] = lambda ns: (
        scene.world.gimbal(0.9) if ns < sea.stamp(1.0) else Orientation(ns, NAN4)
    )
    assert [r.reason for r in scene.run().rejections] == [Reason.BAD_GIMBAL]


def test_constants_need_no_messages(sea):
    values = {
        "fix.source": "constant",
        "fix.latitude_deg": sea.origin["map.latitude_deg"],
        "fix.longitude_deg": sea.origin["map.longitude_deg"],
        "gimbal.source": "constant",
        "gimbal.rpy_deg": [0.0, 60.0, 90.0],
        "height.source": "constant",
        "height.value_m": 30.0,
        "camera.source": "parameters",
        "camera.focal_length_mm": 9.0,
        "camera.sensor_width_mm": 12.8,
        "camera.image_width_px": 1280,
        "camera.image_height_px": 720,
        "tracks.confirm_hits": 1,
    }
    engine = sea.estimator(values)
    engine.add_detections(sea.boxes(1.0, [MIDDLE]))
    results = engine.advance(sea.stamp(1.0))
    assert results[0].estimates[0].position == pytest.approx([0.0, 17.3205], abs=1e-3)
    states = {name: status.state for name, status in engine.inputs.items()}
    assert states.pop("detections") is InputState.OK
    assert states.pop("attitude") is InputState.UNUSED
    assert set(states.values()) == {InputState.CONSTANT}


def test_a_mast_without_a_map_origin_has_its_own_place(sea):
    engine = sea.estimator(
        {"map.latitude_deg": math.nan, "map.longitude_deg": math.nan}
        | {"fix.source": "constant", "fix.latitude_deg": 10.0, "fix.longitude_deg": 20.0}
    )
    engine.add_detections(sea.boxes(1.0, []))
    datum = engine.flush()[0].datum
    assert math.degrees(datum.latitude) == pytest.approx(10.0)


# --- time ------------------------------------------------------------------------------------


def test_an_image_waits_for_late_telemetry_and_no_longer_than_max_wait(sea):
    scene = Scene(sea)
    scene.samples["height"] = (0.9,)
    scene.feed()
    assert scene.engine.advance(sea.stamp(1.1)) == []
    assert scene.engine.advance(sea.stamp(4.0)) == []
    scene.engine.add_height(scene.world.height(1.1))
    results = scene.engine.advance(sea.stamp(4.05))
    assert results[0].rejections == ()

    late = Scene(sea)
    late.samples["height"] = (0.9,)
    late.feed()
    assert late.engine.advance(sea.stamp(1.1)) == []
    assert [r.reason for r in late.engine.advance(sea.stamp(4.1))[0].rejections] == [
        Reason.STALE_HEIGHT
    ]


@pytest.mark.parametrize("latency", [-2.25, -0.5, 0.0, 0.4, 2.25])
def test_latency_of_both_signs(sea, latency):
    """The drone flies east at 5 m/s, so a latency that is not taken out shows as 5 m a second."""
    engine = sea.estimator({"camera.latency_s": latency, "tracks.confirm_hits": 1})
    world = sea.World(drone=lambda t: (5.0 * t, 0.0, 30.0))
    engine.add_camera(sea.stamp(-5.0), sea.camera)
    # an image stamped 1 s shows the scene at 1 s - latency, where the robot was straight ahead
    results = []
    for i in range(-40, 90):
        t = 0.1 * i
        if i == 10:
            engine.add_detections(sea.boxes(1.0, [MIDDLE]))
        for name in ("fix", "gimbal", "height"):
            getattr(engine, f"add_{name}")(getattr(world, name)(t))
        results += engine.advance(sea.stamp(t))
    assert [result.rejections for result in results] == [()]
    assert results[0].stamp_ns == sea.stamp(1.0)
    ahead = 5.0 * (1.0 - latency)
    assert results[0].estimates[0].position == pytest.approx([ahead, 17.3205], abs=2e-3)


def test_results_come_in_stamp_order_and_late_images_are_counted(sea):
    engine, world = sea.estimator(), sea.World()
    engine.add_camera(sea.stamp(0.0), sea.camera)
    for t in (0.4, 0.2, 0.3, 0.3):
        engine.add_detections(sea.boxes(t, [MIDDLE]))
    for t in (0.0, 0.5):
        for name in ("fix", "gimbal", "height"):
            getattr(engine, f"add_{name}")(getattr(world, name)(t))
    results = engine.advance(sea.stamp(0.5))
    assert [r.stamp_ns for r in results] == [sea.stamp(t) for t in (0.2, 0.3, 0.4)]
    engine.add_detections(sea.boxes(0.35, [MIDDLE]))
    engine.add_detections(sea.boxes(0.4, [MIDDLE]))
    assert engine.advance(sea.stamp(0.6)) == []
    assert engine.dropped == {"duplicate": 2, "out_of_order": 1}


@pytest.mark.parametrize("source", ["fix", "gimbal", "detections", "clock"])
def test_time_that_goes_backward_clears_and_says_so_once(sea, source):
    engine = sea.estimator()
    world = sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    first = sea.play(engine, world, 3.0, begin=100.0, until_flush=False)
    assert first[-1].estimates[0].robot_id == "aqua_1"
    engine.take_events()
    if source == "detections":
        engine.add_detections(sea.boxes(0.0, []))
    elif source == "clock":
        engine.advance(sea.stamp(0.0))
    else:
        getattr(engine, f"add_{source}")(getattr(world, source)(0.0))
    again = sea.play(engine, world, 2.0, begin=0.1)
    told = engine.take_events()
    assert len(told) == 1
    assert "Time went backward by 10" in told[0]
    assert source in told[0]
    assert [e.robot_id for e in again[-1].estimates] == ["aqua_2"]  # no name is used twice
    stamps = [result.stamp_ns for result in again]
    assert stamps == sorted(stamps)


def test_a_sample_a_little_out_of_order_is_no_backward_clock(sea):
    engine, world = sea.estimator(), sea.World()
    engine.add_fix(world.fix(2.0))
    engine.add_fix(world.fix(0.5))
    assert not any("backward" in sentence for sentence in engine.events)


def test_the_newest_camera_not_later_than_the_image_is_used(sea):
    """Zoom: twice the focal length from 1 s on; the same pixel lies nearer to the axis."""
    scene = Scene(sea, {"tracks.confirm_hits": 1})
    K = sea.camera.K.copy()
    K[0, 0] = K[1, 1] = 1800.0
    zoomed = type(sea.camera)(1280, 720, "plumb_bob", K)
    later = type(sea.camera)(1280, 720, "plumb_bob", K * [[4.0], [4.0], [1.0]])
    scene.engine.add_camera(sea.stamp(0.99), zoomed)
    scene.engine.add_camera(sea.stamp(1.01), later)
    scene.boxes = sea.boxes(1.0, [[740.0, 360.0]])
    east = scene.run().estimates[0].position[0]
    assert east == pytest.approx(100.0 / 1800.0 * 30.0 / math.sin(math.radians(60)), abs=1e-3)


def test_a_refused_image_still_gives_the_coasting_robots(sea):
    engine, world = sea.estimator(), sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    sea.play(engine, world, 2.0, until_flush=False)
    engine.add_detections(world.frame(3.0))
    result = engine.flush()[0]
    assert [r.reason for r in result.rejections] == [Reason.STALE_FIX]
    assert [(e.robot_id, e.state) for e in result.estimates] == [("aqua_1", State.COASTING)]
    assert result.pose is None


def test_flush_leaves_nothing_behind_and_memory_is_bounded(sea):
    engine = sea.estimator()
    for i in range(MAX_WAITING + 5):
        engine.add_detections(sea.boxes(0.01 * i, [MIDDLE]))
    assert len(engine.advance(sea.stamp(0.0))) == 5
    assert len(engine.flush()) == MAX_WAITING
    assert engine.flush() == []
    for i in range(20_000):
        engine.add_height(Scalar(sea.stamp(0.01 * i), 30.0))
    assert len(engine._inputs._series["height"]) < 6_100  # a minute's worth


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.sampled_from("fghcdnl"), st.integers(0, 80)), max_size=60))
def test_any_order_of_arrival_gives_each_image_one_result(sea, messages):
    """No exception, whatever comes; every image is answered once or counted as dropped."""
    engine, world = sea.estimator(), sea.World(robots={"a": lambda _t: (3.0, 22.0)})
    answered, images = [], 0
    for kind, tenth in messages:
        t = 0.1 * tenth
        if kind == "f":
            engine.add_fix(world.fix(t))
        elif kind == "g":
            engine.add_gimbal(world.gimbal(t))
        elif kind == "h":
            engine.add_height(world.height(t))
        elif kind == "l":
            engine.add_water_level(Scalar(sea.stamp(t), 0.1))
        elif kind == "c":
            engine.add_camera(sea.stamp(t), sea.camera)
        elif kind == "d":
            engine.add_detections(world.frame(t))
            images += 1
        else:
            answered += engine.advance(sea.stamp(t))
    answered += engine.flush()
    assert len(answered) + sum(engine.dropped.values()) == images
    assert all(np.isfinite(e.covariance).all() for r in answered for e in r.estimates)


# --- methods, names, what is told ------------------------------------------------------------


def test_single_publishes_each_point_by_itself(sea):
    world = {"robots": {"a": lambda _t: (3.0, 22.0)}, "pixel_sigma": 2.0, "seed": 5}
    spread, sigma = {}, {}
    for method in ("filter", "single", "paper"):
        results = sea.play(sea.estimator({"method": method}), sea.World(**world), 20.0)
        found = [r.estimates[0] for r in results[50:] if r.estimates[0].state is State.CONFIRMED]
        spread[method] = np.std([e.position for e in found], axis=0).max()
        sigma[method] = np.sqrt(found[-1].covariance[0, 0])
        assert all(np.linalg.eigvalsh(e.covariance).min() > 0.0 for e in found)
        assert {e.robot_id for e in found} == {"aqua_1"}
    assert spread["filter"] < 0.7 * spread["single"]
    assert spread["paper"] == pytest.approx(spread["single"], rel=0.1)
    assert 1.2 < sigma["filter"] < sigma["single"]


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


def test_a_state_file_that_cannot_be_written_is_told_once_and_stops_nothing(sea, tmp_path):
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
        "The origin of map is 13.1940000, -59.6415000 (the first accepted fix)."
    ]


def test_an_unknown_altitude_is_told_once(sea):
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
