# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters as dataclasses: types, ranges, and messages for the reader."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from aerial_gnss_ros.core.config.schema import build, flatten, group, key, leaves, unknown
from aerial_gnss_ros.core.values.errors import ConfigError


@dataclass(frozen=True)
class Inner:
    """A group."""

    ratio: float = key(0.5, "A share.", low=0.0, high=1.0)
    size_m: float = key(math.nan, "A size.", unit="m", low=0.1, optional=True)
    north: str = key("true", "Which.", choices=("true", "magnetic"))


@dataclass(frozen=True)
class Outer:
    """A group with a group."""

    count: int = key(3, "A number.", low=1, high=10, dynamic=True)
    on: bool = key(False, "A switch.")
    name: str = key("", "A text.")
    offset: tuple[float, ...] = key((0.0, 0.0), "A place.", unit="m", low=-5.0, length=2)
    classes: tuple[str, ...] = key((), "Names.")
    inner: Inner = group(Inner)


def test_leaves_have_dotted_names_defaults_and_meaning_in_order():
    found = list(leaves(Outer))
    assert [leaf.name for leaf in found] == [
        "count", "on", "name", "offset", "classes", "inner.ratio", "inner.size_m", "inner.north",
    ]  # fmt: skip
    assert found[0].default == 3
    assert found[0].kind is int
    assert found[0].key.dynamic
    assert found[3].key.unit == "m"


def test_nested_and_dotted_values_build_the_same_and_the_rest_keeps_its_default():
    nested = build(Outer, {"count": 4, "inner": {"ratio": 0.25}})
    dotted = build(Outer, {"count": 4, "inner.ratio": 0.25})
    assert repr(nested) == repr(dotted)  # NaN is not equal to itself
    assert (nested.inner.ratio, nested.inner.north, nested.on) == (0.25, "true", False)
    assert flatten({"a": {"b": {"c": 1}}, "d": 2}) == {"a.b.c": 1, "d": 2}


def test_an_empty_mapping_is_no_value_but_a_group_may_hold_none():
    assert build(Outer, {"inner": {}}).inner.ratio == build(Outer, {}).inner.ratio
    for values in ({"count": {}}, {"inner": {"ratio": {}}}):
        with pytest.raises(ConfigError, match=r"must be a .*number.*, not \{\}"):
            build(Outer, values)


def test_a_whole_number_is_accepted_where_a_number_is_meant():
    made = build(Outer, {"inner.ratio": 1, "offset": [1, 2.5]})
    assert made.inner.ratio == 1.0
    assert isinstance(made.inner.ratio, float)
    assert made.offset == (1.0, 2.5)
    assert all(isinstance(item, float) for item in made.offset)


def test_a_truth_value_is_accepted_where_its_word_is_a_choice():
    assert build(Outer, {"inner.north": True}).inner.north == "true"


@pytest.mark.parametrize("value", [1e-320, -1e-31])
def test_numbers_whose_squares_vanish_are_refused(value):
    with pytest.raises(ConfigError, match=r"inner\.ratio must be 0 or at least 1e-30 in size"):
        build(Outer, {"inner.ratio": value})


def test_a_name_without_its_group_names_every_parameter_that_ends_so():
    known = ["wait", "fix.gap", "gimbal.gap", *(f"{place}.topic" for place in "abcdefg")]
    for name, meant in (
        ("gap", "did you mean fix.gap or gimbal.gap?"),
        ("gpa", "did you mean fix.gap or gimbal.gap?"),
        ("topic", "did you mean a.topic, b.topic, c.topic, d.topic, e.topic or one of 2 more?"),
        ("gimball.gap", "did you mean gimbal.gap?"),
        ("zzz.gap", "did you mean fix.gap?"),
        ("wiat", "did you mean wait?"),
        ("zzz", "remove it, or see the files in config/."),
    ):
        assert str(unknown(name, [*known, *known])) == f"{name} is not a parameter; {meant}"


def test_not_given_is_nan_only_where_that_is_allowed():
    assert math.isnan(build(Outer, {"inner.size_m": math.nan}).inner.size_m)
    with pytest.raises(ConfigError, match=r"inner\.ratio must be a number, not NaN"):
        build(Outer, {"inner.ratio": math.nan})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"cuont": 4}, r"cuont is not a parameter; did you mean count\?"),
        ({"ratio": 0.5}, r"did you mean inner\.ratio\?"),
        ({"zzzzzz": 4}, "remove it"),
        ({"count": 2.5}, r"count must be a whole number, not 2\.5"),
        ({"count": True}, "whole number, not True"),
        ({"count": 11}, "within 1 to 10, not 11"),
        ({"inner.ratio": "half"}, "must be a number, not 'half'"),
        ({"inner.ratio": True}, "must be a number, not True"),
        ({"inner.ratio": -0.1}, r"within 0 to 1, not -0\.1"),
        ({"inner.size_m": 0.01}, r"within 0\.1 to inf \(m\)"),
        ({"inner.north": "south"}, "one of true, magnetic, not 'south'"),
        ({"inner.north": False}, "must be text, not False"),
        ({"on": 1}, "true or false, not 1"),
        ({"name": 5}, "must be text, not 5"),
        ({"offset": [1.0]}, "must have 2 elements, not 1"),
        ({"offset": 1.0}, "must be a list of numbers"),
        ({"offset": [1.0, "x"]}, "must be a number"),
        ({"offset": [1.0, -6.0]}, "within -5 to inf"),
        ({"classes": "aqua"}, "must be a list of text"),
        ({"classes": [1]}, "must be text, not 1"),
    ],
)
def test_a_wrong_value_is_refused_with_its_name_and_the_value_seen(values, words):
    with pytest.raises(ConfigError, match=words):
        build(Outer, values)
