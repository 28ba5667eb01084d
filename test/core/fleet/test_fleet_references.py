# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What one drone sees of known position corrects the robots of all; a wrong one does no harm."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.fleet.common_share import CommonShare
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fault import FAULTS
from aerial_gnss_ros.core.fleet.fault_search import Found
from aerial_gnss_ros.core.fleet.fleet import Fleet
from aerial_gnss_ros.core.fleet.fleet_references import FleetReferences, staying_references
from aerial_gnss_ros.core.models.platform_model import COUNT
from aerial_gnss_ros.core.references.candidates import Expected
from aerial_gnss_ros.core.values.reference_place import ReferencePlace
from aerial_gnss_ros.simulation.sensors import START_NS

pytestmark = pytest.mark.flights

PIER, OURS = 0, 4
"""Robots of which only drone a, or only drone b, has boxes."""


@pytest.fixture(scope="module")
def flown(fleet_of):
    """Two drones with consumer receivers; only a sees the pier, only b sees the fifth robot."""
    return flown_with(fleet_of, 5.0)


def flown_with(fleet_of, images):
    places = 8.0 * np.array([[0.0, 0.0], [0.8, 0.5], [-1.0, 0.3], [0.4, -0.9], [-0.5, 1.0]])
    made = fleet_of(robots=5, places=places, duration=14.0, images=images, seed=21, height_m=25.0)
    for drone, hidden in (("a", OURS), ("b", PIER)):
        made.sightings[drone] = [shown(made, drone, seen, hidden) for seen in made.sightings[drone]]
    return made


def shown(flown, drone, seen, hidden):
    """Return a sighting without one robot; the pier is a beacon."""
    result = next(r for r in flown.alone[drone] if r.stamp_ns == seen.stamp_ns)
    true = {label: k for label, (_, k) in flown.errors(result.estimates).items()}
    keep = [k for k, label in enumerate(seen.labels) if label and true[label] != hidden]
    return replace(
        seen,
        labels=tuple(seen.labels[k] for k in keep),
        tracks=tuple(seen.tracks[k] for k in keep),
        class_ids=tuple(
            "beacon" if true[seen.labels[k]] == PIER else seen.class_ids[k] for k in keep
        ),
        pixels=seen.pixels[keep].reshape(-1, 2),
        doubt=seen.doubt[keep].reshape(-1, 2, 2),
    )


def true_place(flown, robot):
    return flown.made["a"].swarm.positions([0.0])[robot, 0, :2]


def stating(flown, references):
    """Return a drone's configuration with references, positions in metres from the origin."""
    stated = {}
    for name, position in references.items():
        degrees = np.degrees(flown.local.places(np.array([position]))).ravel().tolist()
        stated[name] = {"class": "beacon", "position": degrees, "sigma_m": 0.05}
    settings = {"noise.set": "consumer", "fix.altitude_datum": "ellipsoid", "references": stated}
    return estimator_config(settings | {"tracks.find_moored": False})


def together(flown, moving=None, **references):
    """Return the fleet, its updates and what was said.

    Args:
        flown: the drones.
        moving: offset of the pier's own fixes, which drone a hears, m.
        references: by drone and name.
    """
    configs = flown.configs | {drone: stating(flown, of) for drone, of in references.items()}
    sightings = dict(flown.sightings)
    if moving is not None:
        lat, lon = flown.local.places(np.array([true_place(flown, PIER) + moving]))
        place = ReferencePlace("boat", "beacon", lat[0], lon[0], 0.03**2 * np.eye(2), moves=True)
        sightings["a"] = [replace(seen, references=(place,)) for seen in sightings["a"]]
    fleet, updates = replace(flown, configs=configs, sightings=sightings).together()
    return fleet, updates, [note for _, _, update in updates for note in update.notes]


def of_robot(flown, updates, robot, after_s=9.0):
    """Return the estimates of a true robot after some time."""
    found = []
    for _, seen, update in updates:
        if (seen.stamp_ns - START_NS) * 1e-9 >= after_s:
            of = flown.errors(update.estimates)
            found += [one for one in update.estimates if of[one.robot_id][1] == robot]
    return found


def rms(flown, estimates, robot):
    apart = [
        flown.local.positions([one.latitude], [one.longitude])[0] - true_place(flown, robot)
        for one in estimates
    ]
    return math.sqrt(float(np.mean(np.square(apart).sum(axis=1))))


def test_it_does_not_matter_which_drone_s_images_come_first(flown):
    """Images without the pier, taken at the same time, take no decision for those that show it."""
    fleet, _ = replace(
        flown, configs=flown.configs | {"a": stating(flown, {"pier": true_place(flown, PIER)})}
    ).together(order="ba")
    assert [one.name for one in staying_references(fleet._drones)] == ["pier"]
    assert list(links(fleet)) == ["pier"]


def test_a_fleet_that_begins_anew_finds_its_references_again(flown):
    fleet, updates, _ = together(flown, a={"pier": true_place(flown, PIER)})
    label = links(fleet)["pier"]
    agreed = SimpleNamespace(errors=np.zeros(COUNT), matched=[])
    fleet._blame(Found(1, FAULTS[2], agreed))
    assert not links(fleet)
    for name, seen, _ in updates[-20:]:
        again = fleet.update(name, later(seen, 10**10))
        assert not again.notes  # said already
    assert links(fleet) == {"pier": label}


def links(fleet):
    return fleet._references._references.links


def later(seen, step_ns):
    pose = replace(seen.pose, stamp_ns=seen.pose.stamp_ns + step_ns)
    return replace(seen, stamp_ns=seen.stamp_ns + step_ns, pose=pose)


def same(updates, others):
    for (_, _, one), (_, _, other) in zip(updates, others, strict=True):
        assert [e.robot_id for e in one.estimates] == [e.robot_id for e in other.estimates]
        for a, b in zip(one.estimates, other.estimates, strict=True):
            np.testing.assert_array_equal(a.position, b.position)
            np.testing.assert_array_equal(a.covariance, b.covariance)


def test_robots_that_stay_are_corrected_in_either_law(flown):
    configs = flown.configs | {"a": stating(flown, {"pier": true_place(flown, PIER)})}
    asked = {
        name: replace(one, tracks=replace(one.tracks, find_moored=True))
        for name, one in configs.items()
    }
    fleet, updates = replace(flown, configs=asked).together()
    _, plain = replace(flown, configs=configs).together()
    law = fleet.table.staying.law
    assert np.count_nonzero(law.sway) >= 3
    assert list(links(fleet)) == ["pier"]
    mean, _ = fleet._references.published(law, fleet.table.state.joint)
    (slot,) = np.flatnonzero(law.ids == fleet.table.state.joint.ids[pier_of(fleet)])
    np.testing.assert_allclose(mean[slot, :2], true_place(flown, PIER), atol=0.1)
    after, before = (of_robot(flown, which, OURS)[-1] for which in (updates, plain))
    assert after.sigma < 1.05 * before.sigma
    assert rms(flown, [after], OURS) < 2.5 * after.sigma


def pier_of(fleet):
    return [robot.class_id for robot in fleet.table.robots].index("beacon")


def test_all_drones_profit_from_what_one_sees(flown):
    """Receivers of both share half of their variance; the pier is surveyed to 5 cm."""
    _, without, _ = together(flown)
    for drone in "ab":  # whose configuration states it
        fleet, updates, notes = together(flown, **{drone: {"pier": true_place(flown, PIER)}})
        (ours,) = (robot for robot in fleet.table.robots if robot.labels.keys() == {1})
        (pier,) = (robot for robot in fleet.table.robots if robot.class_id == "beacon")
        assert notes == [f"Reference pier is {pier.name}: positions refer to it."]
        before, after = (of_robot(flown, which, OURS) for which in (without, updates))
        assert {one.robot_id for one in after} == {ours.name}
        assert rms(flown, before, OURS) > 1.0
        assert rms(flown, after, OURS) < 0.3
        assert before[-1].sigma > 1.0
        assert after[-1].sigma < 0.35
        assert rms(flown, after, OURS) < 2.5 * after[-1].sigma
        (of_pier,) = of_robot(flown, updates[-1:], PIER)
        assert rms(flown, [of_pier], PIER) < 0.1
        receivers = {one.name: one for one in updates[-1][2].platform}
        for axis in ("a gnss_east", "b gnss_north"):
            plain = {one.name: one for one in without[-1][2].platform}[axis]
            assert receivers[axis].sigma < 0.4 < plain.sigma
            assert abs(receivers[axis].value - plain.value) < 4.0 * plain.sigma


@pytest.mark.parametrize("off", [(5.0, 0.0), (0.0, -5.0), (-3.6, 3.6), (900.0, 0.0)])
def test_a_wrong_one_is_refused_said_and_does_no_harm(flown, off):
    """Off as seen: by chance the receivers may be off the same way, which nothing shows."""
    _, without, _ = together(flown)
    (seen,) = of_robot(flown, without[-1:], PIER)
    place = flown.local.positions([seen.latitude], [seen.longitude])[0] + off
    _, updates, notes = together(flown, a={"pier": place})
    same(updates, without)
    (sentence,) = notes
    assert sentence.startswith("Reference pier is not used: aqua_")
    assert "contradicts the receiver" in sentence


def test_of_two_drones_that_state_one_name_differently_the_right_one_counts(flown):
    right = true_place(flown, PIER)
    other = right + np.array([0.0, 9.0])
    same_twice, differ = (
        staying_references([Drone(name, stating(flown, {"pier": at})) for name, at in places])
        for places in ((("a", right), ("b", right)), (("a", other), ("b", right)))
    )
    assert [one.name for one in same_twice] == ["pier"]
    assert [one.name for one in differ] == ["pier", "pier of b"]
    _, updates, notes = together(flown, a={"pier": other}, b={"pier": right})
    assert sorted(note.partition(":")[0] for note in notes) == [
        "Reference pier is not used",
        "Reference pier of b is aqua_2",
    ]
    assert rms(flown, of_robot(flown, updates, OURS), OURS) < 0.3


def test_a_boat_whose_fixes_one_drone_hears_corrects_all(flown):
    _, without, _ = together(flown)
    fleet, updates, notes = together(flown, moving=(0.0, 0.0))
    assert updates[-1][0] == "b"
    assert links(fleet) == {"boat": "aqua_2"}
    assert [note.partition(":")[0] for note in notes] == ["Reference boat is aqua_2"]
    ours = of_robot(flown, updates, OURS)
    assert rms(flown, ours, OURS) < 0.3
    # The other drone's images, which do not tell where the boat is, are corrected as well.
    assert max(one.sigma for one in ours) < 0.4
    _, updates, notes = together(flown, moving=(40.0, 0.0))
    same(updates, without)
    assert [note.partition(":")[0] for note in notes] == ["Reference boat is not used"]


def test_what_is_gone_is_remembered_as_the_receivers_drift(fleet_of):
    flown = flown_with(fleet_of, 10.0)
    sightings = flown.sightings | {
        "a": [seen for seen in flown.sightings["a"] if seen.stamp_ns < START_NS + 9 * 10**9]
    }
    gone = replace(flown, sightings=sightings)
    fleet, updates, _ = together(gone, moving=(0.0, 0.0))
    assert not links(fleet)
    last = of_robot(gone, updates[-1:], OURS)
    assert rms(gone, last, OURS) < 0.4
    drift = 1.2 * math.sqrt(1.0 - math.exp(-2.0 * 5.0 / 300.0))
    (before,) = of_robot(gone, [u for u in updates if u[0] == "a"][-1:], OURS, 0.0)
    assert before.sigma < last[0].sigma < math.hypot(before.sigma, drift) + 0.05


def test_what_stands_out_of_the_water_is_expected_between_where_the_drones_show_it(flown):
    (place,) = staying_references([Drone("a", stating(flown, {"pier": true_place(flown, PIER)}))])
    high = replace(place, height=2.0)
    fleet = Fleet(flown.configs, flown.local)
    references = FleetReferences(fleet._drones, (high,), fleet.table.state, CommonShare(0.5))
    seen = [flown.sightings[name][-1] for name in "ab"]
    shown = [Expected.of(high, one.pose, flown.local).position for one in seen]
    assert np.linalg.norm(shown[1] - shown[0]) > 1.0

    def expected(number, sighting):
        fleet._drones[number].last = sighting
        return references._expected(high, number, sighting, flown.local)

    one = expected(0, seen[0])
    np.testing.assert_allclose(one.position, shown[0])
    np.testing.assert_allclose(one.spread, high.covariance)
    without = expected(1, seen[1])  # it shows no beacon: the other one's place counts
    np.testing.assert_allclose(without.position, shown[0])
    both = expected(1, replace(seen[1], class_ids=("beacon", *seen[1].class_ids[1:])))
    half = 0.5 * (shown[1] - shown[0])
    np.testing.assert_allclose(both.position, shown[0] + half)
    np.testing.assert_allclose(both.spread, high.covariance + np.outer(half, half))
