# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""References as they are stated, and what is refused of them."""

from __future__ import annotations

import math

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.errors import ConfigError

PIER = {"class": "beacon", "position": [13.194, -59.6415], "sigma_m": 0.05}
BOAT = {"class": "boat", "topic": "boat/fix"}


def test_what_is_stated_is_found_by_name():
    config = estimator_config({
        "references": {
            "pier": PIER,
            "buoy": {**PIER, "class": "buoy", "sigma_m": 1, "radius_m": 4.0, "height_m": 0.5},
            "boat": BOAT,
        }
    })  # fmt: skip
    boat, buoy, pier = config.references
    assert (boat.name, boat.class_id, boat.topic, boat.position) == ("boat", "boat", "boat/fix", ())
    assert math.isnan(boat.variance)
    assert buoy.height_m == 0.5
    assert buoy.variance == 1.0 + 4.0  # a disc of radius r has r²/4 on each axis
    assert pier.position == (13.194, -59.6415)
    assert pier.variance == pytest.approx(0.0025)


def test_without_references_there_are_none():
    assert estimator_config({}).references == ()


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ({"sigma_m": 0.0}, "references.pier.sigma_m is 0, but no position is known exactly"),
        ({"sigma_m": -1.0}, "references.pier.sigma_m must lie within 0 to 100 (m), not -1"),
        ({"sigma_m": math.nan}, "references.pier.sigma_m must say how well its position is known"),
        ({"class": ""}, "references.pier.class must be the name of a class: nothing is bound"),
        ({"class": 3}, "references.pier.class must be text, not 3"),
        ({"class": "bird"}, "which detections.classes (beacon, boat) refuses"),
        ({"position": []}, "references.pier must have a position or a topic, not neither"),
        ({"topic": "a/fix"}, "references.pier must have a position or a topic, not both"),
        ({"position": [91.0, 0.0]}, "must be [latitude, longitude] in degrees, not [91.0, 0.0]"),
        ({"position": [1.0, 2.0, 3.0]}, "must be [latitude, longitude] in degrees"),
        ({"position": [0.0, 0.0]}, "is [0, 0], what receivers send without a fix"),
        ({"colour": "red"}, "references.pier.colour is not a parameter; references.<name> has "),
        ({"class_id": "x"}, "references.pier.class_id is not a parameter"),
        ({"position": [], "topic": "a", "radius_m": 2.0}, "radius_m is for what stays"),
    ],
)
def test_a_wrong_entry_is_one_sentence(entry, sentence):
    values = {"references": {"pier": PIER | entry}, "detections.classes": ["beacon", "boat"]}
    with pytest.raises(ConfigError) as refused:
        estimator_config(values)
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("pair", "sentence"),
    [
        ({"a": PIER, "b": PIER}, "references.a and references.b are of one class at one place"),
        ({"a": BOAT, "b": BOAT}, "references.a and references.b have one topic, boat/fix"),
        ({"Pier": PIER}, "references.Pier: use lower-case letters"),
    ],
)
def test_references_that_cannot_both_be_are_refused(pair, sentence):
    with pytest.raises(ConfigError) as refused:
        estimator_config({"references": pair})
    assert sentence in str(refused.value)


def test_one_place_may_have_two_things_of_different_classes():
    both = {"a": PIER, "b": PIER | {"class": "post"}}
    assert len(estimator_config({"references": both}).references) == 2
