# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Flights with faulty inputs: nobody dies, nothing is confident and wrong, names are kept."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.telemetry.input_status import InputState
from aerial_gnss_ros.core.values.samples import Scalar

pytestmark = pytest.mark.flights

NO_ORIGIN = {"map.latitude_deg": math.nan, "map.longitude_deg": math.nan}
ROBOTS = {"a": (3.0, 22.0), "b": (-12.0, 25.0), "c": (14.0, 34.0)}
BEGIN_S, END_S, LASTS_S = 9.0, 14.0, 20.0


class Sea:
    """A drone that flies slowly east over robots that stay, measured with noise."""

    def __init__(self, sea, values):
        robots = {name: (lambda _t, place=place: place) for name, place in ROBOTS.items()}
        self.world = sea.World(drone=lambda t: (0.5 * t, 0.0, 30.0), robots=robots, pixel_sigma=1.0)
        self.of_heights = np.random.default_rng(1)
        self.engine = sea.estimator(NO_ORIGIN | values)
        self.fix, self.gimbal, self.frame = self.world.fix, self.world.gimbal, self.world.frame

    def height(self, t):
        return Scalar(self.world.height(t).stamp_ns, 30.0 + 0.03 * self.of_heights.normal())


class Beginnings:
    """What comes before a fault, flown once for all faults that begin then."""

    def __init__(self, sea):
        self.sea, self._flown = sea, {}

    def until(self, begin, values):
        """Return a copy of a flight until just before a time, and its results."""
        key = begin, repr(values)
        if key not in self._flown:
            flight = Sea(self.sea, values)
            results = []
            if begin > 0.0:
                results = self.sea.play(flight.engine, flight, begin - 0.05, until_flush=False)
            self._flown[key] = flight, results
        return copy.deepcopy(self._flown[key], {id(self.sea.camera): self.sea.camera})


class Flight:
    """A flight with a fault in one input."""

    def __init__(
        self, beginnings, name="", change=None, begin=BEGIN_S, end=END_S, values=None, too_high=0.0,
        noise_px=0.0,
    ):  # fmt: skip
        sea = beginnings.sea
        flight, self.results = beginnings.until(begin, values or {})
        height, frame, more = flight.height, flight.frame, np.random.default_rng(2)
        flight.height = lambda t: replace(
            one := height(t), value=one.value + too_high * (begin <= t < end)
        )

        def noisy(t):
            boxes = frame(t)
            noise = noise_px * more.standard_normal(boxes.centers.shape)
            return replace(boxes, centers=boxes.centers + noise) if begin <= t < end else boxes

        flight.frame = noisy
        if name:
            true = getattr(flight, name)
            setattr(flight, name, lambda t: change(true(t), t) if begin <= t < end else true(t))
        self.world, self.engine = flight.world, flight.engine
        self.results += sea.play(flight.engine, flight, LASTS_S - begin, begin=begin)
        self.start_ns = sea.stamp(0.0)

    def rows(self):
        """Yield time, estimate and its distance to the next robot, m."""
        true = np.array(list(ROBOTS.values()))
        for result in self.results:
            for estimate in result.estimates:
                # by place on Earth: map's own origin is the first fix
                found = self.world.local.positions([estimate.latitude], [estimate.longitude])[0]
                error = true - found
                best = error[int(np.argmin(np.linalg.norm(error, axis=1)))]
                yield (result.stamp_ns - self.start_ns) * 1e-9, estimate, best

    def wrong(self):
        """Return how many positions are beyond 4 sigma and 5 m from every robot."""
        return sum(
            float(best @ np.linalg.solve(estimate.covariance[:2, :2], best)) > 16.0
            and math.hypot(*best) > 5.0
            for _, estimate, best in self.rows()
        )

    def reasons(self):
        """Return the reasons of refused boxes."""
        return {str(one.reason) for result in self.results for one in result.rejections}

    def check(self, input_name, since=END_S):
        """Demand what must hold after every fault."""
        assert self.wrong() == 0
        assert self.reasons() <= {f"bad_{input_name}"}
        late = [(one, best) for t, one, best in self.rows() if t > since + 3.0]
        assert {one.robot_id for one, _ in late} == {"aqua_1", "aqua_2", "aqua_3"}
        assert all(math.hypot(*best) < 1.0 for _, best in late)
        assert len(late) == 3 * sum(
            (r.stamp_ns - self.start_ns) * 1e-9 > since + 3.0 for r in self.results
        )


def covariance(values, bias=33.0):
    """Return what states a covariance and is wrong by so many metres."""

    def change(fix, _t):
        stated = np.asarray(values, dtype=np.float64).reshape(3, 3)
        return replace(fix, covariance=stated, latitude=fix.latitude + bias / 6.4e6)

    return change


@pytest.fixture(scope="module")
def beginnings(sea):
    """Return what all flights have in common."""
    return Beginnings(sea)


INF, NAN = math.inf, math.nan
FIXES = {
    "zeros": lambda fix, _t: replace(fix, latitude=0.0, longitude=0.0),
    "longitude's sign": lambda fix, _t: replace(fix, longitude=-fix.longitude),
    "latitude + 60 deg": lambda fix, _t: replace(fix, latitude=fix.latitude + math.radians(60.0)),
    "swapped": lambda fix, _t: replace(fix, latitude=fix.longitude, longitude=fix.latitude),
    "longitude 500": lambda fix, _t: replace(fix, longitude=math.radians(500.0)),
    "1 km off": lambda fix, _t: replace(fix, latitude=fix.latitude + 1.57e-4),
    "infinite": covariance([INF, 0, 0, 0, INF, 0, 0, 0, INF]),
    "not a number": covariance([NAN] * 9),
    "negative": covariance([-1, 0, 0, 0, -1, 0, 0, 0, -1]),
    "not positive": covariance([1, 2, 0, 2, 1, 0, 0, 0, 1]),
    "altitude 1e18": lambda fix, _t: replace(fix, altitude=1e18),
}


@pytest.mark.parametrize("name", FIXES)
def test_a_fix_that_cannot_be_is_refused_in_flight(beginnings, name):
    flight = Flight(beginnings, "fix", FIXES[name])
    flight.check("fix")
    status = flight.engine.inputs["fix"]
    assert status.bad == 100  # 5 s at 20 Hz
    assert status.state is InputState.OK
    assert sum("A message on fix is of no use" in one for one in flight.engine.events) == 1


@pytest.mark.parametrize("seconds", [0.1, 0.5, 1.0, 2.0])
def test_zeros_before_the_first_fix_are_refused(beginnings, seconds):
    flight = Flight(beginnings, "fix", FIXES["zeros"], begin=0.0, end=seconds)
    flight.check("fix", since=seconds)
    reported = [one for one in flight.engine.events if one.startswith("The origin of map")]
    assert len(reported) == 1
    assert reported[0].startswith("The origin of map is 13.19")


def test_first_fixes_far_away_are_outvoted_and_the_origin_moves(beginnings):
    """Half a second of a place that may be: no robot is confirmed in it."""
    values = {"tracks.confirm_hits": 10}
    change = FIXES["latitude + 60 deg"]
    flight = Flight(beginnings, "fix", change, begin=0.0, end=0.5, values=values)
    flight.check("fix", since=3.5)
    assert math.degrees(flight.results[-1].datum.latitude) == pytest.approx(13.194, abs=1e-3)
    assert all(result.datum is None for result in flight.results[:15])


def test_robots_found_from_a_wrong_place_are_given_up(beginnings):
    flight = Flight(beginnings, "fix", FIXES["latitude + 60 deg"], begin=0.0, end=2.0)
    rows = [one.robot_id for t, one, _ in flight.rows() if t > 6.0]
    assert set(rows) == {"aqua_4", "aqua_5", "aqua_6"}
    assert all(math.hypot(*best) < 1.0 for t, _, best in flight.rows() if t > 6.0)
    reported = [one for one in flight.engine.events if "m from its earlier fixes" in one]
    assert len(reported) == 1
    assert "robots get new labels" in reported[0]


def test_longitude_500_all_flight_gives_no_position(beginnings):
    flight = Flight(beginnings, "fix", FIXES["longitude 500"], begin=0.0, end=99.0)
    assert list(flight.rows()) == []
    assert flight.reasons() == {"bad_fix"}
    status = flight.engine.inputs["fix"]
    assert status.state is InputState.BAD
    assert "500 is not on Earth" in status.trouble
    assert any("No message on fix has been of use for 10 s" in one for one in flight.engine.events)


def stuck(value):
    return lambda height, _t: Scalar(height.stamp_ns, value)


@pytest.mark.parametrize("value", [1e18, -1e18, NAN, 0.0, 0.3, 0.5, 1.0, 60.0])
def test_a_height_that_cannot_be_is_refused_in_flight(beginnings, value):
    flight = Flight(beginnings, "height", stuck(value))
    flight.check("height")
    assert flight.engine.inputs["height"].bad == 100


def test_one_wild_height_costs_the_images_beside_it(beginnings):
    flight = Flight(beginnings, "height", stuck(1e18), begin=9.0, end=9.04)
    flight.check("height", since=9.0)
    assert sum(len(result.rejections) for result in flight.results) == 3


def test_a_range_finder_at_its_stop_from_the_start(beginnings):
    flight = Flight(beginnings, "height", stuck(0.3), begin=0.0, end=2.0)
    flight.check("height", since=5.0)
    assert any("cannot see robots" in one for one in flight.engine.events)


def test_the_fixs_altitude_is_judged_where_height_is_made_of_it(beginnings):
    values = {"height.source": "none", "fix.altitude_datum": "ellipsoid", "surface.altitude": 0.0}
    change = lambda fix, _t: replace(fix, altitude=1.0)  # noqa: E731
    Flight(beginnings, "fix", change, values=values).check("fix")
    Flight(beginnings, "fix", change).check("fix")  # not used, so nothing happens


def test_a_receiver_and_a_height_that_jump_together_leave_robots_where_they_were(beginnings):
    """Boxes then fit robots a quarter nearer, and the filter bent their places to fit."""
    flight = Flight(beginnings, name="fix", change=_east(50.0))
    low = Flight(beginnings, name="fix", change=_east(50.0), too_high=5.0)
    for one in (flight, low):
        assert one.wrong() == 0
        late = [(row, best) for t, row, best in one.rows() if t > END_S + 3.0]
        assert {row.robot_id for row, _ in late} == {"aqua_1", "aqua_2", "aqua_3"}
        assert all(math.hypot(*best) < 1.0 for _, best in late)
        # and they are as sure of it as if nothing had happened
        assert all(np.trace(row.covariance[:2, :2]) < 2.0 * 1.6**2 for row, _ in late)
    during = [(row, best) for t, row, best in low.rows() if BEGIN_S + 3.5 < t < END_S]
    assert all(math.hypot(*best) < 6.0 for _, best in during)  # the jump is taken out
    assert all(np.trace(row.covariance[:2, :2]) > 2.0 * (50.0**2 / 9.0) for row, _ in during)


def _east(metres):
    def change(fix, _t):
        return replace(fix, longitude=fix.longitude + metres / 6.2e6)

    return change


def test_boxes_of_ten_times_the_noise_exchange_no_names(beginnings):
    flight = Flight(beginnings, noise_px=20.0)
    assert flight.wrong() == 0
    places = flight.world.local.places(np.array(list(ROBOTS.values())))
    own: dict[str, int] = {}
    for t, row, _ in flight.rows():
        apart = np.hypot(row.latitude - places[0], (row.longitude - places[1]) * math.cos(0.23))
        nearest = int(np.argmin(apart))
        if t < BEGIN_S:
            own[row.robot_id] = nearest
        elif t > END_S + 3.0:
            assert own.get(row.robot_id, nearest) == nearest


def test_positions_that_a_driver_sends_again_do_not_make_the_drone_jump(sea):
    """Measured 4 times a second, sent 20 times; the drone flies 4 m/s to and fro over two robots.

    Taken for measurements they put it up to a metre behind.
    """

    def drone(t):
        return 8.0 * math.sin(0.5 * t), 0.0, 30.0

    robots = {"a": lambda _t: (1.0, 17.0), "b": lambda _t: (-4.0, 20.0)}
    world = sea.World(drone=drone, robots=robots, pixel_sigma=1.0)
    sent = {name: getattr(world, name) for name in ("fix", "gimbal", "height")}
    for name, measured in sent.items():
        setattr(world, name, lambda t, measured=measured: replace(
            measured(math.floor(4.0 * t + 1e-6) / 4.0), stamp_ns=sea.stamp(t)
        ))  # fmt: skip
    engine = sea.estimator({"method": "single"})
    results = sea.play(engine, world, 12.0)
    truth = np.array([place(0.0) for place in robots.values()])
    errors = [
        np.linalg.norm(truth - one.position, axis=1).min()
        for result in results[20:]
        for one in result.estimates
    ]
    assert len(errors) == 2 * len(results[20:])
    assert max(errors) < 0.3
    assert sum("sent several times" in one for one in engine.events) == 1
