# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a model file says of itself is text from a stranger: read within bounds, or refused."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.onnx_model import class_names
from aerial_gnss_ros.detection.second_look_terms import METADATA, Terms


@pytest.mark.parametrize(
    "text",
    [
        "{0: 'a', 2: 'b'}",
        "__import__('os')",
        "{1e999: 'a'}",
        "'" + "a" * 2_000_000,
        "[" * 3000,
        "-" * 200_000 + "1",
        "(" * 90 + "1" + ")" * 90,
        "{0: 'a'\0}",
        "9" * 5000,
    ],
    ids=lambda text: text[:12],
)
def test_names_that_are_none_are_refused_in_a_sentence(text):
    with pytest.raises(ModelError, match=r"m\.onnx carries class names") as caught:
        class_names({"names": text}, (), "m.onnx")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "[" * 100_000,
        '{"side": 1e999}',
        '{"side": "a"}',
        '{"side": 100000000}',
        '{"side": 64.5}',
        '{"near": NaN}',
        '{"near": -1}',
        '{"wide": 1}',
        '{"from_score": 0.9}',
        '{"to_score": 2}',
        '{"other": 2}',
        '{"side": 64, "side": 32}',
    ],
    ids=lambda text: text[:24],
)
def test_terms_that_are_none_are_refused(text):
    with pytest.raises(ModelError, match="not a network for the second look"):
        Terms.read({METADATA: text}, "m.onnx")


def test_terms_are_read():
    assert Terms.read({METADATA: Terms().text}, "m.onnx") == Terms()
    assert Terms.read({METADATA: '{"side": 32.0, "wide": 2}'}, "m.onnx") == Terms(side=32, wide=2)
