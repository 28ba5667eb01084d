# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots are followed in the picture while images have no pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.association.image_labels import TUNING as IMAGE_LABELS
from aerial_gnss_ros.core.association.image_tracks import TUNING as IMAGE_TRACKS
from aerial_gnss_ros.core.association.image_tracks import ImageTracks

START = np.array([[400.0, 300.0], [700.0, 350.0], [500.0, 500.0]])
NAMES = ("a", "b", "c")
HEIGHT = 20.0
"""45 px on a metre, of the camera with a focal length of 900 px."""


class Pictures:
    """Images one after the other; robots a, b, c are the rows of the places given."""

    def __init__(self, sea, images=10):
        self.sea, self.step, self.t = sea, 1.0 / images, 0.0
        self.tracks = ImageTracks(pixel_sigma=2.0, speed_sigma=0.75)

    def frame(self, places):
        self.t += self.step
        return self.sea.boxes(self.t, places)

    def posed(self, places, named=None):
        named = dict(enumerate(NAMES[: len(places)])) if named is None else named
        return self.tracks.measured(self.frame(places), self.sea.camera, HEIGHT, named)

    def blind(self, places):
        return self.tracks.followed(self.frame(places))


@pytest.fixture
def pictures(sea):
    made = Pictures(sea)
    for _ in range(5):
        made.posed(START)
    return made


def reported(labels, index):
    """The factors of a, b, c and of any other robot."""
    return [labels[index].factor(name) for name in (*NAMES, "other")]


def test_robots_that_change_places_are_followed(pictures):
    """50 images in which a and b go round one another, while the camera flies on."""
    middle, arm = START[:2].mean(axis=0), START[0] - START[:2].mean(axis=0)
    for i in range(1, 51):
        angle = np.pi * i / 50
        turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ arm
        places = np.array([middle + turned, middle - turned, START[2]]) + np.array([2.0, -1.0]) * i
        labels = pictures.blind(places[[2, 0, 1]])
    labels = pictures.posed(places[[1, 0, 2]], named={})
    for index, own in enumerate((1, 0, 2)):
        factors = reported(labels, index)
        assert factors[own] > 0.99
        assert sum(factors) == pytest.approx(factors[own] + 3 * IMAGE_LABELS.unmodelled_probability)


def test_two_that_met_may_be_either(pictures):
    """They come to one place and part again."""
    share = 0.5 * np.sin(np.linspace(0.0, np.pi, 120))
    for one in share:
        places = START.copy()
        places[0] += one * (START[1] - START[0])
        places[1] -= one * (START[1] - START[0])
        labels = pictures.blind(places)
    assert reported(labels, 0)[:2] == pytest.approx([0.5, 0.5], abs=0.2)
    assert reported(labels, 1)[:2] == pytest.approx(reported(labels, 0)[1::-1], abs=0.05)
    assert reported(labels, 2)[2] > 0.99


def test_a_robot_missed_for_a_moment_is_found_again(pictures):
    for i in range(1, 20):
        places = START + np.array([8.0 * i, 0.0])
        shown = places if not 5 <= i < 9 else places[1:]
        labels = pictures.blind(shown)
    assert reported(labels, 0)[0] > 0.98
    assert reported(labels, 1)[1] > 0.98


def test_a_robot_gone_for_long_may_be_what_comes_up_anywhere(pictures):
    for _ in range(20):
        pictures.blind(START[1:])
    labels = pictures.blind(np.array([*START[1:], [900.0, 600.0]]))
    a, b, c, other = reported(labels, 2)
    assert b == c == IMAGE_LABELS.unmodelled_probability
    assert a == pytest.approx(other, abs=0.01)
    assert other > 0.99  # a, or a robot never seen: its position must decide


def test_pictures_far_apart_tell_nothing(sea):
    slow = Pictures(sea, images=0.4)
    for _ in range(3):
        slow.posed(START)
    labels = slow.blind(START)
    assert reported(labels, 0) == [1.0] * 4


def test_a_picture_that_jumps_tells_no_names(pictures):
    pictures.blind(START)
    labels = pictures.blind(START + np.array([320.0, 150.0]))
    assert max(reported(labels, 0)[:1] + reported(labels, 1)[1:2]) <= reported(labels, 0)[3]


def test_robots_in_no_image_before_stay_unknown(pictures):
    labels = pictures.blind(np.array([*START, [900.0, 600.0]]))
    assert reported(labels, 3)[:3] == [IMAGE_LABELS.unmodelled_probability] * 3
    assert reported(labels, 3)[3] > 0.99


def test_false_boxes_take_no_names(pictures):
    rng = np.random.default_rng(1)
    for _ in range(30):
        labels = pictures.blind(np.array([*START, *rng.uniform((0, 0), (1280, 720), (2, 2))]))
    assert [reported(labels, i)[i] > 0.9 for i in range(3)] == [True] * 3


def test_other_images_have_no_labels(pictures):
    assert pictures.posed(START) == {}
    pictures.blind(START)
    assert set(pictures.posed(START, named={0: "a"})) == {1, 2}
    for _ in range(11):
        labels = pictures.posed(START, named={0: "a"})
    assert labels == {}  # the picture had its say


def test_a_box_that_measures_a_robot_is_that_robot(pictures):
    """Whatever the image evidence: here of two that met."""
    for _ in range(3):
        pictures.blind(np.array([START[0], START[0], START[2]]))
    pictures.posed(START[[0, 0, 2]], named={0: "b", 2: "c"})
    labels = pictures.posed(START[[0, 2]], named={})
    assert reported(labels, 0)[1] > 0.4
    assert reported(labels, 1)[2] > 0.99


@pytest.mark.parametrize("count", [33, 200])
def test_a_picture_full_of_boxes_is_followed_no_further(pictures, count):
    rng = np.random.default_rng(1)
    labels = pictures.blind(rng.uniform((0, 0), (1280, 720), (count, 2)))
    assert all(reported(labels, i) == [1.0] * 4 for i in labels)


def test_before_any_robot_is_known_there_is_nothing_to_follow(sea):
    assert Pictures(sea).blind(START) == {}


def test_numbers_beyond_any_picture_do_no_harm(pictures):
    labels = pictures.blind(np.array([*START, [1e300, -1e300]]))
    assert reported(labels, 1)[1] > 0.99


class _Pause:
    """Five seconds without a fix, or off; two robots change places meanwhile, 2.4 m apart."""

    begin, end, arm = 5.0, 10.0, 1.2

    @classmethod
    def robots(cls):
        def angle(t):
            return np.pi * min(max((t - cls.begin) / (cls.end - cls.begin), 0.0), 1.0)

        return {
            "one": lambda t: (cls.arm * np.cos(angle(t)), 20.0 + cls.arm * np.sin(angle(t))),
            "other": lambda t: (-cls.arm * np.cos(angle(t)), 20.0 - cls.arm * np.sin(angle(t))),
            "third": lambda _t: (6.0, 24.0),
        }

    @classmethod
    def world(cls, sea, hidden=False, fault="fix"):
        def fails(t):
            return cls.begin <= t < cls.end

        class Failing(sea.World):
            def fix(self, t):
                return replace(super().fix(t), valid=fault != "fix" or not fails(t))

            def gimbal(self, t):
                self.rpy_bias_deg = (0.0, -100.0 * (fault == "gimbal" and fails(t)), 0.0)
                return super().gimbal(t)

        made = Failing(robots=cls.robots(), pixel_sigma=1.0)
        if hidden:
            made.hidden = lambda _name, t: fails(t)
        return made


def _whose(world, result):
    """Return which robot each name is on."""
    t = (result.stamp_ns - 1_700_000_000 * 10**9) * 1e-9
    found = {}
    for one in result.estimates:
        if one.state.value == "confirmed":
            apart = {k: np.hypot(*np.subtract(f(t), one.position)) for k, f in world.robots.items()}
            found[one.robot_id] = min(apart, key=apart.get)
    return found


@pytest.mark.parametrize("fault", ["fix", "gimbal"])
def test_names_are_kept_by_what_the_picture_shows(sea, fault):
    """Without a fix; and while the camera seems to look into the sky."""
    world = _Pause.world(sea, fault=fault)
    results = sea.play(sea.estimator(), world, 14.0)
    before = next(_whose(world, r) for r in results if len(r.estimates) == 3)
    assert set(before) == {"aqua_1", "aqua_2", "aqua_3"}
    assert _whose(world, results[-1]) == before


def test_without_a_picture_nobody_knows(sea):
    """They went by one another unseen; whoever is named anew or not, no name is surely wrong."""
    world = _Pause.world(sea, hidden=True)
    results = sea.play(sea.estimator(), world, 14.0)
    before = next(_whose(world, r) for r in results if len(r.estimates) == 3)
    after = _whose(world, results[-1])
    for one in results[-1].estimates:
        if one.robot_id in before and after.get(one.robot_id) != before[one.robot_id]:
            off = np.subtract(world.robots[before[one.robot_id]](14.0), one.position)
            assert off @ np.linalg.solve(one.covariance[:2, :2], off) < 13.8


def test_in_a_short_pause_no_box_goes_to_a_robot_that_the_picture_shows_elsewhere(sea, monkeypatch):
    """Two robots exchange places within 1.5 s: after so little a box in the gate would do."""
    monkeypatch.setattr(_Pause, "end", 6.5)
    monkeypatch.setattr(_Pause, "arm", 0.6)
    world = _Pause.world(sea)
    results = sea.play(sea.estimator(), world, 14.0, images=10)
    before = next(_whose(world, r) for r in results if len(r.estimates) == 3)
    assert _whose(world, results[-1]) == before


@pytest.mark.parametrize("count", [IMAGE_TRACKS.most_points, IMAGE_TRACKS.most_points + 1])
def test_what_the_picture_shows_next_is_expected_unless_there_is_too_much_in_it(sea, count):
    pictures, places = Pictures(sea), np.stack([np.full(count, 600.0), 20.0 * np.arange(count)], 1)
    for _ in range(3):
        pictures.tracks.measured(pictures.frame(places), sea.camera, HEIGHT, {5: "a", 9: "b"})
    labels = pictures.tracks.expected(pictures.frame(places))
    if count > IMAGE_TRACKS.most_points:
        assert labels == {}
    else:
        assert labels[5].factor("a") > 0.9
        assert labels[5].contradicts("b")


def test_a_label_that_is_given_up_stands_for_no_robot(pictures):
    """It was given to a's box while poses were wrong."""
    pictures.blind(START)
    pictures.posed(START, named={0: "wrong", 1: "b", 2: "c"})
    frame = pictures.frame(START)
    assert pictures.tracks.expected(frame)[0].contradicts("a")
    pictures.tracks.keep_labels(set(NAMES))
    labels = pictures.tracks.expected(frame)
    assert not labels[0].contradicts("a")
    assert labels[0].factor("a") > 0.99
    assert labels[0].contradicts("b")
    assert "wrong" not in labels[0].names


def test_a_picture_that_pans_is_followed_as_it_did_while_it_had_a_pose(sea):
    """By 60 px an image, as far as robots are apart: two come to lie where the next ones were."""
    row = np.array([[300.0, 300.0], [360.0, 300.0], [420.0, 300.0]])
    pan = Pictures(sea)
    for i in range(5):
        pan.posed(row + np.array([60.0 * i, 0.0]))
    labels = pan.blind(row[:2] + np.array([300.0, 0.0]))
    for index in range(2):
        assert reported(labels, index)[index] > 0.7
