# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is looked at again, and how the file of a network says it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.second_look_terms import METADATA, Terms, log_odds, traits

_NEWER = ("ways", "again_from")
TERMS = Terms(32, 1.5, 4.0, 20.0, 0.1, 0.7)


def test_what_a_file_says_is_read_back():
    assert Terms.read({METADATA: TERMS.text}, "a.onnx") == TERMS
    several = replace(TERMS, ways=8, again_from=0.2)
    assert Terms.read({METADATA: several.text}, "a.onnx") == several


def test_a_file_from_before_there_were_several_ways_has_one():
    stored = {key: value for key, value in asdict(TERMS).items() if key not in _NEWER}
    assert Terms.read({METADATA: json.dumps(stored)}, "a.onnx").ways == 1


@pytest.mark.parametrize(
    "changes",
    [
        {"side": 7}, {"side": 2000}, {"side": 32.5}, {"near": 0.0}, {"near": 5.0}, {"wide": 101.0},
        {"least": -1.0}, {"from_score": 0.8}, {"to_score": 1.1}, {"near": float("nan")},
        {"unknown": 1}, {"ways": 0}, {"ways": 9}, {"ways": 2.5}, {"again_from": -0.1},
        {"again_from": 1.1},
    ],
)  # fmt: skip
def test_terms_that_no_network_was_made_for_are_refused(changes):
    text = json.dumps(asdict(TERMS) | changes)
    with pytest.raises(ModelError, match=r"a\.onnx is not a network for the second look"):
        Terms.read({METADATA: text}, "a.onnx")


@pytest.mark.parametrize("metadata", [{}, {METADATA: "{"}, {METADATA: "[1]"}])
def test_a_network_for_something_else_is_refused(metadata):
    with pytest.raises(ModelError, match="is not a network for the second look"):
        Terms.read(metadata, "a.onnx")


def test_doubtful_are_boxes_between_the_scores_and_the_best_of_many():
    scores = np.array([0.9, 0.7, 0.69, 0.3, 0.1, 0.09])
    assert TERMS.doubtful(scores).tolist() == [2, 3, 4]
    many = replace(TERMS, from_score=0.0).doubtful(np.full(100, 0.5))
    assert many.tolist() == list(range(32))


@pytest.mark.parametrize(
    ("score", "odds"), [(0.5, 0.0), (0.75, np.log(3.0)), (0.2, -np.log(4.0)), (1.0, np.log(9999.0))]
)
def test_log_odds_are_finite(score, odds):
    assert log_odds(score) == pytest.approx(odds)
    assert log_odds(1.0 - score) == pytest.approx(-odds)


def test_traits_are_odds_size_and_shape():
    boxes = np.array([[5.0, 5.0, 40.0, 20.0], [0.0, 0.0, 10.0, 80.0], [0.0, 0.0, 0.0, 0.0]])
    found = traits(boxes, np.array([0.5, 0.75, 0.5]))
    assert found.dtype == np.float32
    assert found[0] == pytest.approx([0.0, 0.0, np.log(2.0)])
    assert found[1] == pytest.approx([np.log(3.0) / 3.0, np.log(2.0), -np.log(8.0)])
    assert np.isfinite(found[2]).all()
