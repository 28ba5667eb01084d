# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two estimators and the fleet as processes: what is joined live is what a replay joins."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
from aerial_gnss_ros.adapters.fleet_messages import drone_parameters
from aerial_gnss_ros.adapters.fleet_overview import DRONES
from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS, sent_sighting
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.fleet.agreement import DroneReport
from aerial_gnss_ros.core.fleet.clocks import ClockOffset
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.shore import TUNING as SHORE
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.core.values.events import WarningText
from aerial_gnss_ros.nodes import qos
from aerial_gnss_ros.nodes.diagnostics import WARN
from aerial_gnss_ros.nodes.fleet_node import FleetNode
from aerial_gnss_ros.nodes.ros_messages import message, message_class
from aerial_gnss_ros.nodes.supervised import Given
from aerial_gnss_ros.simulation.sensors import START_NS

SIM_TIME = ("--ros-args", "-p", "use_sim_time:=true")
OUTAGE = range(30, 60)
STEP_NS = 100_000_000


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Return the bags of two drones, both in one, and what a replay of them gives."""
    folder = tmp_path_factory.mktemp("drones")
    arguments = ["--no-images", "--duration", "9", "--drones", "2", "--seed", "3"]
    assert main(["simulate", "-o", str(folder / "two"), *arguments]) == 0
    bags = {name: folder / "two" / name for name in "ab"}
    given = [part for name, bag in bags.items() for part in ("--drone", f"{name}={bag}")]
    quick = ["--no-bag", "--no-figures", "--json"]
    assert main(["replay", *given, "-o", str(folder / "joined"), *quick]) == 0
    with open_bag(bags["a"]) as a, open_bag(bags["b"]) as b, BagWriter(folder / "all") as out:
        recorded = [
            ((one.log_ns, name), name, bag, one)
            for name, bag in (("a", a), ("b", b))
            for one in bag.messages({topic for topic in bag.topics if "truth" not in topic})
        ]
        for _, name, bag, one in sorted(recorded, key=lambda r: r[0]):
            topic = bag.topics[one.topic]
            out.write(f"/{name}{one.topic}", topic.msgtype, one.log_ns, one.raw, topic.qos[0])
    return folder


def rows(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def connected(node):
    """Return whether both drones and the fleet have found one another."""
    heard = all(node.count_subscribers(f"/{name}/sightings") for name in "ab")
    return heard and all(map(node.count_publishers, ("/a/sightings", "/b/raw/sightings")))


class Link:
    """Passes b's sightings on, but for those of an outage; what is sent again passes.

    Attributes:
        newest_ns: stamp of the newest image that came, ns.
        came: by drone and number; of both drones.
        lost: sequence numbers of those that did not pass.
        out: publishes what passes.
        heard: subscriptions to both drones.
    """

    def __init__(self, ros):
        self.lost, self.newest_ns, self.came, node = set(), 0, {}, ros.node("link")
        kind = message_class(SIGHTINGS[1])
        self.out = node.create_publisher(kind, "/b/sightings", qos.sightings())
        self.heard = [
            node.create_subscription(kind, topic, receive, qos.sightings())
            for topic, receive in (("/a/sightings", self._note), ("/b/raw/sightings", self._pass))
        ]

    def _note(self, msg):
        sent = sent_sighting(msg.data)
        self.came[sent.drone, sent.sequence] = sent
        return sent

    def _pass(self, msg):
        sent = self._note(msg)
        self.newest_ns = max(self.newest_ns, sent.sighting.stamp_ns)
        if sent.sequence in OUTAGE and sent.sequence not in self.lost:
            self.lost.add(sent.sequence)
        else:
            self.out.publish(msg)


def joined(came):
    """Return robots and names after the sightings that came, in the order of their scenes."""
    order = sorted(came.values(), key=lambda one: (one.sighting.pose.stamp_ns, one.drone))
    first = order[0].sighting.pose
    datum = MapDatum(first.latitude, first.longitude, math.nan)
    fleet = Fleet(dict.fromkeys("ab", EstimatorConfig()), LocalMap(datum))
    names = {}
    for one in order:
        update = fleet.update(one.drone, one.sighting)
        names[one.drone] = update.names
    return {estimate.robot_id: estimate for estimate in update.estimates}, names


def stamp_ns(fix):
    return nanoseconds(fix.header.stamp)


def apart_m(fix, latitude_deg, longitude_deg):
    """Return the distance of a fix from a place."""
    north = (fix.latitude - latitude_deg) * 111_000.0
    east = (fix.longitude - longitude_deg) * 108_000.0
    return math.hypot(north, east)


@pytest.mark.slow
def test_two_live_drones_with_an_outage_are_joined_as_in_a_replay(two, start, ros, in_step):
    drones = [
        start(
            "aerial_gnss_ros.nodes.estimator", *SIM_TIME, "-p", f"sightings.drone:={name}",
            "-r", f"__ns:=/{name}", *more,
        )
        for name, more in (("a", ()), ("b", ("-r", "sightings:=raw/sightings")))
    ]  # fmt: skip
    fleet = start(
        "aerial_gnss_ros.cli", "run", "--node", "fleet", *SIM_TIME, "-p", "drones:=[a, b]"
    )
    link, told, fixes = Link(ros), [], {}
    listener = ros.node("listener")
    listener.create_subscription(
        message_class(DRONES[1]), DRONES[0], lambda m: told.append(json.loads(m.data)),
        qos.latched(),
    )  # fmt: skip
    shown = []
    listener.create_subscription(
        message_class(OVERVIEW[1]), OVERVIEW[0], lambda m: shown.append(json.loads(m.data)),
        qos.latched(),
    )  # fmt: skip
    for name in ("aqua_1", "aqua_2", "aqua_3"):
        listener.create_subscription(
            message_class("sensor_msgs/msg/NavSatFix"), f"/robots/{name}/fix",
            lambda m, name=name: fixes.setdefault(name, {}).__setitem__(stamp_ns(m), m),
            qos.latched(),
        )  # fmt: skip
    for program in (*drones, fleet):
        program.wait_for("method filter|joins")
    ros.spin_until(lambda: connected(listener))
    ros.connect(link.out)
    ros.spin_until(lambda: all(one.get_publisher_count() for one in link.heard))
    ros.spin(1.0)
    heard = [f"/{name}/{topic}" for name in "ab" for topic in ("detections", "gimbal", "fix")]
    player = in_step("/b/detections", two / "all", "--wait-for", *heard, "--after", "1")
    # An image before the origin of map is known has no sighting: the player may be ahead by 3.
    player.play(ros, lambda: max((link.newest_ns - START_NS) // STEP_NS, 0) + 3)
    ros.spin_until(lambda: told and all(one["missing"] == 0 for one in told[-1]["drones"]))
    estimates, names = joined(link.came)

    def last_fixes():
        # Of the last image: two seconds after it, predictions with later stamps follow.
        return {name: fixes.get(name, {}).get(same.stamp_ns) for name, same in estimates.items()}

    def caught_up():
        return fixes.keys() == estimates.keys() and all(
            fix and apart_m(fix, math.degrees(same.latitude), math.degrees(same.longitude)) < 1e-3
            for fix, same in zip(last_fixes().values(), estimates.values(), strict=True)
        )

    ros.spin_until(caught_up)
    ros.spin(2.0)  # and stays there
    assert caught_up()
    assert link.lost == set(OUTAGE)
    seen = {one["name"]: set(one["sees"]) for one in shown[-1]["drones"]}
    assert seen.keys() == {"a", "b"}
    assert all(seen[name] and seen[name] <= {*names[name].values()} for name in "ab")
    assert {one["id"] for one in shown[-1]["robots"]} == fixes.keys()
    last = {one["drone"]: one for one in told[-1]["drones"]}
    assert [last[name]["lost"] for name in "ab"] == [0, 0]
    assert not [key for one in last.values() for key in one if key.startswith("refused")]
    assert {name: last[name]["names"] for name in "ab"} == names
    for name, fix in last_fixes().items():
        same = estimates[name]
        assert fix.position_covariance[0] == pytest.approx(same.covariance[0, 0], rel=1e-6)
    # Live, heights are stamped on arrival, and whose robots are confirmed first gives them names.
    replayed = [
        row
        for row in rows(two / "joined" / "positions.csv")
        if int(row["stamp_ns"]) == next(iter(estimates.values())).stamp_ns
    ]
    assert len(replayed) == len(fixes)
    for row in replayed:
        place = float(row["latitude_deg"]), float(row["longitude_deg"])
        assert min(apart_m(fix, *place) for fix in last_fixes().values()) < 0.1
    assert all(program.end() == 0 for program in (*drones, fleet))


def said(node):
    return {status.name: status for status in node.statuses()}


def test_what_is_wrong_with_a_drone_is_said_and_the_other_goes_on(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("fleet: {ros__parameters: {drones: [a, b]}}", encoding="utf-8")
    node = ros.add(FleetNode(Given(files=[path])))
    warned = []
    node.warn_seldom = warned.append
    assert said(node)["positions"].message == "no drone has told its parameters yet"
    parameters = {"version": 1, "drone": "a", "parameters": {}, "datum": None}
    string = "std_msgs/msg/String"
    node._describe("a", message(string, {"data": json.dumps(parameters)}))
    node._describe("b", message(string, {"data": json.dumps(parameters)}))
    assert "both call themselves drone a" in warned[-1]
    node._take("b", message(string, {"data": "{}"}))
    assert warned[-1].startswith("b: a sighting is of version")
    for _ in range(SHORE.most_read_hz):
        node._take("b", message(string, {"data": "{}"}))
    assert "more than 300 messages a second" in warned[-1]
    assert drone_parameters(json.dumps(parameters)).drone == "a"
    assert said(node)["drone a"].message == "no image yet"
    link = node._shore.links["a"]
    link.delay_s = 4.0
    assert said(node)["drone a"].level == WARN
    assert "4.0 s late" in said(node)["drone a"].message
    nothing = np.zeros(2)
    report = DroneReport("a", 0, 1.0, 2, nothing, nothing, True, "compass")
    link.update, link.delay_s = SimpleNamespace(report=report, names={}), 0.1
    assert said(node)["drone a"].level == WARN
    assert "its compass is wrong" in said(node)["drone a"].message
    link.update.report = replace(report, fault="")
    assert "contradicts the others" in said(node)["drone a"].message
    link.update.report = replace(report, fault="", clock=ClockOffset(0.3, 0.01))
    assert "its clock is 0.30 s ahead of the others'" in said(node)["drone a"].message


def test_a_sighting_that_fails_is_logged_and_counted(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("fleet: {ros__parameters: {drones: [a]}}", encoding="utf-8")
    node = ros.add(FleetNode(Given(files=[path])))
    assert node._node_status().values == {"internal_errors": 0}
    node._shore.history = SimpleNamespace(failures=[ValueError("of no use")], advance=list)
    node._advance()
    assert node._shore.history.failures == []
    assert node._node_status().level == WARN
    assert node._node_status().message == "1 internal error: ValueError: of no use"


def test_while_all_drones_are_silent_predictions_are_published_once_a_second(
    ros, tmp_path, monkeypatch
):
    path = tmp_path / "p.yaml"
    path.write_text("fleet: {ros__parameters: {drones: [a, b]}}", encoding="utf-8")
    node = ros.add(FleetNode(Given(files=[path])))
    told = []
    node._positions = SimpleNamespace(departures=SimpleNamespace(present=[1]), send=told.append)
    node._overviews = SimpleNamespace(keep=lambda _result: None)
    node._shore = SimpleNamespace(
        follow_clock=lambda _now: False, advance=lambda: None, history=None,
        predicted=lambda stamp_ns: FrameResult(stamp_ns, "", (), (), None),
        notes=["Reference pier is a_1.", WarningText("Reference mark is not used.")],
    )  # fmt: skip
    logged = []
    log = SimpleNamespace(
        info=lambda words: logged.append(("info", words)),
        warning=lambda words: logged.append(("warning", words)),
    )
    monkeypatch.setattr(node, "get_logger", lambda: log)
    node._advance()
    assert logged == [
        ("info", "Reference pier is a_1."), ("warning", "Reference mark is not used.")
    ]  # fmt: skip
    assert not node._shore.notes
    assert not told
    node._overdue.processed(10**18, node._passing_ns() - 5 * 10**9)
    node._advance()
    node._advance()
    assert [round(1e-9 * (one.stamp_ns - 10**18)) for one in told] == [5]


@pytest.mark.usefixtures("ros")
def test_a_fleet_without_drones_is_refused():
    with pytest.raises(ConfigError, match="drones is empty"):
        FleetNode()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--vehicle", "anafi"], "--vehicle is for the nodes of a drone: the fleet has none"),
        (["--session", "x"], "--session is for the nodes of a drone"),
        ([], "drones is empty: give the drones' namespaces"),
    ],
)
def test_what_is_not_of_a_fleet_is_one_sentence(capsys, arguments, words):
    assert main(["run", "--node", "fleet", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "Traceback" not in said
