# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Requests to change parameters: single keys, whole entries as text, and what is none."""

from __future__ import annotations

from array import array

import pytest

from aerial_gnss_ros.adapters.parameter_changes import after
from aerial_gnss_ros.core.values.errors import ConfigError

GROUPS = ("classes", "references")
VALUES = {"max_wait": 3.0, "references.pier.class": "beacon", "references.pier.sigma_m": 0.05}


def test_a_key_is_replaced_added_and_deleted():
    new = after(VALUES, {"max_wait": 2.0, "classes.aqua.max_speed": 1.0}, GROUPS)
    assert new == {**VALUES, "max_wait": 2.0, "classes.aqua.max_speed": 1.0}
    assert after(new, {"classes.aqua.max_speed": None}, GROUPS) == {**VALUES, "max_wait": 2.0}
    assert after({}, {"a": array("d", [1.0]), "b": ["x"]}, ())["a"] == (1.0,)


def test_an_entry_is_replaced_as_a_whole_and_removed():
    text = "{class: buoy, position: [13.2, -59.6]}"
    new = after(VALUES, {"references.pier": text, "references.mast": "{topic: t}"}, GROUPS)
    assert new == {
        "max_wait": 3.0,
        "references.pier.class": "buoy",
        "references.pier.position": [13.2, -59.6],
        "references.mast.topic": "t",
    }
    for nothing in ("", " ", None):
        assert after(new, {"references.pier": nothing}, GROUPS) == {
            "max_wait": 3.0,
            "references.mast.topic": "t",
        }


@pytest.mark.parametrize("text", ["pier", "[1, 2]", "{}", 3.0, "{a: 1", "{a: 1, a: 2}"])
def test_an_entry_that_is_no_mapping_is_refused(text):
    with pytest.raises(ConfigError, match=r"references\.pier"):
        after(VALUES, {"references.pier": text}, GROUPS)


def test_other_groups_have_no_entries():
    assert after({}, {"robots.leader": "{class: aqua}"}, GROUPS) == {
        "robots.leader": "{class: aqua}"
    }
