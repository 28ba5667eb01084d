# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A sighting sent is the sighting received, to the last bit; whatever else arrives is refused."""

from __future__ import annotations

import contextlib
import json
import math
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerial_gnss_ros.adapters.sighting_messages import sent_sighting, sighting_text
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.fleet.outbox import SentSighting
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.reference_place import ReferencePlace

CAMERA = CameraModel(1280, 720, "plumb_bob", [[853.9, 0, 643.3], [0, 853.9, 356.9], [0, 0, 1]])
POSE = CameraPose(
    1_735_689_607_900_000_001, 0.2302783004909383, -1.0409396313733303, 15.016793256589324,
    math.nan, np.eye(3)[[1, 2, 0]], np.array([[0.3, 0.1], [0.1, 0.2]]), 0.1 + 0.2,
    np.arange(6.0) / 3.0, np.full(6, 0.1),
)  # fmt: skip
SEEN = Sighting(
    1_735_689_607_900_000_003, "camera", CAMERA, POSE, np.array([0.1, 1 / 3, 0.0]),
    np.array([1e-300, -2.5]), ("aqua_1", ""), (7, 0), ("Aqua", "Aqua"),
    np.array([[154.46940643369953, 416.1], [2 / 3, 1.0]]),
    np.array([np.eye(2), np.zeros((2, 2))]), 1.7, np.array([[31.2, 18.0], [5.5, 0.1]]),
    np.array([0.871, 0.05]),
)  # fmt: skip
BOAT = ReferencePlace("boat", "Boat", 0.23027, -1.0409, np.diag([1e-4, 1 / 3]), 0.5, True)
SENT = SentSighting("drone1", 1_735_689_600_123_456_789, 79, 3, SEEN)


def same(one, other):
    if is_dataclass(one):
        return type(one) is type(other) and all(
            same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return all(map(same, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.tobytes() == other.tobytes() and (
            one.shape == other.shape
        )  # fmt: skip
    if isinstance(one, float) and math.isnan(one):
        return math.isnan(other)
    return type(one) is type(other) and one == other


@st.composite
def sightings(draw):
    number = st.floats(-1e6, 1e6)
    count = draw(st.integers(0, 4))

    def array(*shape):
        size = math.prod(shape)
        return np.array(draw(st.lists(number, min_size=size, max_size=size))).reshape(shape)

    root = array(count, 2, 2) * 1e-3
    q, _ = np.linalg.qr(array(3, 3) + np.eye(3))
    q *= np.sign(np.linalg.det(q))
    spread = array(2, 2) * 1e-3
    pose = CameraPose(
        draw(st.integers(0, 2**62)), draw(st.floats(-1.5, 1.5)), draw(st.floats(-3.1, 3.1)),
        draw(st.floats(0.1, 1e3)), draw(st.one_of(number, st.just(math.nan))), q,
        draw(st.sampled_from([None, spread @ spread.T])), draw(st.floats(0, 9)),
        np.abs(array(6)), np.abs(array(6)),
    )  # fmt: skip
    seen = Sighting(
        draw(st.integers(0, 2**62)), draw(st.text(max_size=8)),
        replace(CAMERA, width=draw(st.integers(700, 2000))), pose, array(3), array(2),
        tuple(f"aqua_{k}" if k else "" for k in range(count)), tuple(range(5, 5 + count)),
        tuple(draw(st.lists(st.text(max_size=4), min_size=count, max_size=count))),
        array(count, 2), root @ root.transpose(0, 2, 1), draw(st.floats(0.1, 10.0)),
        draw(st.sampled_from([None, np.abs(array(count, 2))])),
        draw(st.sampled_from([None, np.abs(array(count)) * 1e-6])),
        draw(st.sampled_from([(), (BOAT,), (BOAT, replace(BOAT, name="rtk"))])),
    )  # fmt: skip
    whole = st.integers(0, 2**62)
    return SentSighting("drone_b", draw(whole), draw(whole), draw(whole), seen)


@given(sightings())
@settings(max_examples=60, deadline=None)
def test_what_is_sent_is_what_is_received(sent):
    assert same(sent_sighting(sighting_text(sent)), sent)


def test_a_camera_is_checked_once():
    one, other = sent_sighting(sighting_text(SENT)), sent_sighting(sighting_text(SENT))
    assert same(one, SENT)
    assert one.sighting.camera is other.sighting.camera


def test_a_sighting_of_an_earlier_release_has_no_sizes_and_scores():
    document = json.loads(sighting_text(SENT))
    del document["sighting"]["sizes"], document["sighting"]["scores"]
    read = sent_sighting(json.dumps(document)).sighting
    assert (read.sizes, read.scores) == (None, None)
    assert same(read, replace(SEEN, sizes=None, scores=None))


def test_references_are_sent_where_there_are_any_so_that_earlier_releases_read_the_rest():
    assert "references" not in json.loads(sighting_text(SENT))["sighting"]
    sent = replace(SENT, sighting=replace(SEEN, references=(BOAT,)))
    assert same(sent_sighting(sighting_text(sent)), sent)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"moves": False}, "impossible reference"),
        ({"latitude": 1.6}, "impossible reference"),
        ({"longitude": -6.3}, "impossible reference"),
        ({"height": -1.0}, "impossible reference"),
        ({"name": "../fix"}, "impossible reference"),
        ({"covariance": np.diag([1e-4, -1e-4])}, "must have a covariance above 0"),
        ({"covariance": np.array([[1.0, 2.0], [2.0, 1.0]])}, "not symmetric and positive"),
        ({"covariance": np.eye(3)}, "the covariance of a sighting must be 2 x 2 finite"),
    ],
)
def test_a_reference_that_cannot_be_is_refused(more, sentence):
    sent = replace(SENT, sighting=replace(SEEN, references=(replace(BOAT, **more),)))
    with pytest.raises(InputError, match=sentence):
        sent_sighting(sighting_text(sent))
    twice = replace(SENT, sighting=replace(SEEN, references=(BOAT, BOAT)))
    with pytest.raises(InputError, match="two references of one name"):
        sent_sighting(sighting_text(twice))


def changed(path, value):
    document = json.loads(sighting_text(SENT))
    inner = document
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return json.dumps(document)


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        (("version",), 2, "version 2, this program reads 1"),
        (("version",), True, "version True"),
        (("sighting", "sizes"), [[1.0, 2.0]], "1 sizes for 2 boxes"),
        (("sighting", "sizes"), [[1.0, -2.0], [1, 1]], "a box of negative size"),
        (("sighting", "scores"), [0.5, 1.5], "a score that is not within 0 to 1"),
        (
            ("sighting", "scores"),
            [[0.5], [0.5]],
            "the scores of a sighting must be n finite numbers",
        ),
        (("drone",), "Drone 1", "a drone's name cannot be 'Drone 1'"),
        (("drone",), "", "a drone's name cannot be"),
        (("drone",), 7, "a drone's name cannot be 7"),
        (
            ("sequence",),
            -1,
            "the sequence of a sighting must be a whole number from 0 to 2^63 - 1, not -1",
        ),
        (("session",), 2**63, "2^63 - 1, not 9223372036854775808"),
        (("sighting",), [], "a sighting must be an object, not []"),
        (("sighting", "camera"), "x7", "the camera of a sighting must be an object, not 'x7'"),
        (("sighting", "more"), 1, "a sighting has unknown keys: more."),
        (("sighting", "camera", "K"), [[0.0] * 3] * 3, "the camera of a sighting is refused"),
        (
            ("sighting", "camera", "model"),
            "own",
            "the camera of a sighting is refused: CameraInfo has distortion mo",
        ),
        (("sighting", "camera", "rectified"), 0, "must be true or false, not 0"),
        (("sighting", "labels"), ["aqua_1", "aqua_1"], "two boxes of one robot"),
        (("sighting", "tracks"), [3, 3], "two boxes of one track"),
        (("sighting", "tracks"), [3, -1], "2^63 - 1, not -1"),
        (("sighting", "labels"), ["aqua_1", "../fix"], "a robot's name cannot be '../fix'"),
        (("sighting", "labels"), ["aqua_1"], "1 labels for 2 boxes"),
        (("sighting", "labels"), "ab", "must be a list, not 'ab'"),
        (
            ("sighting", "pixels"),
            [[1.0], [2.0]],
            "the pixels of a sighting must be n x 2 finite numbers",
        ),
        (
            ("sighting", "pixels"),
            [[1.0, None], [2.0, 1.0]],
            "the pixels of a sighting must be n x 2",
        ),
        (("sighting", "pixels"), [[1.0, 2.0], [3.0]], "the pixels of a sighting must be n x 2"),
        (("sighting", "doubt", 0), [[1.0, 0.0], [0.0, -1.0]], "not symmetric and positive"),
        (("sighting", "doubt", 0), [[1.0, 0.5], [0.0, 1.0]], "not symmetric and positive"),
        (("sighting", "level"), 0.0, "the level of a sighting must lie within 0 to 1e6, not 0"),
        (("sighting", "level"), None, "the level of a sighting must be a number, but has no value"),
        (("sighting", "pose", "height"), 0.0, "0 m above the water is refused"),
        (("sighting", "pose", "latitude"), 1.6, "camera at latitude 91.67"),
        (("sighting", "pose", "enu_from_camera", 0), [1.0, 0.0, 0.0], "not a rotation matrix"),
        (
            ("sighting", "pose", "fix_covariance"),
            [[-1.0, 0.0], [0.0, 1.0]],
            "not symmetric and positive",
        ),
        (("sighting", "pose", "gaps_s"), [-1.0] * 6, "negative"),
    ],
)
def test_what_cannot_be_is_refused_with_what_it_was(path, value, sentence):
    with pytest.raises(InputError) as refused:
        sent_sighting(changed(path, value))
    assert sentence in str(refused.value)


@pytest.mark.parametrize("text", ["", "[]", "{}", "1", "null", "[" * 9999, "x" * 2_000_000])
def test_what_is_no_message_is_refused(text):
    with pytest.raises(InputError, match="a sighting"):
        sent_sighting(text)


def test_a_mirrored_camera_is_refused():
    turned = POSE.enu_from_camera * np.array([1.0, 1.0, -1.0])
    with pytest.raises(InputError, match="not a rotation matrix"):
        sent_sighting(changed(("sighting", "pose", "enu_from_camera"), turned.tolist()))


PLACES = [
    (*path, key)
    for path, inside in [
        ((), SENT), (("sighting",), SEEN), (("sighting", "pose"), POSE),
        (("sighting", "camera"), CAMERA),
    ]
    for key in (f.name for f in fields(inside))
]  # fmt: skip
ANYTHING = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text()),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=2),
)


@given(st.sampled_from(PLACES), ANYTHING)
@settings(max_examples=300, deadline=None)
def test_whatever_stands_in_a_message_it_is_read_or_refused(path, value):
    sent = None
    with contextlib.suppress(InputError):
        sent = sent_sighting(changed(path, value))
    assert sent is None or same(sent_sighting(sighting_text(sent)), sent)
