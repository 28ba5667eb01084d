# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Uncaught errors are counted and logged once for each place; a flood ends the node."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.nodes import internal_errors
from aerial_gnss_ros.nodes.internal_errors import MOST_A_SECOND, InternalErrors


def caught(make):
    try:
        make()
    except Exception as error:  # noqa: BLE001 - of any kind
        return error
    raise AssertionError


def test_each_place_is_reported_once_and_each_error_is_counted():
    errors = InternalErrors()
    one, other = (lambda: 1 // 0), (lambda: {}["a"])
    assert errors.last == ""
    reported = [errors.add(caught(make)) for make in (one, one, other, one)]
    assert [bool(text) for text in reported] == [True, False, True, False]
    assert "ZeroDivisionError" in reported[0]
    assert "Traceback" in reported[0]
    assert (errors.count, errors.last.split(":")[0]) == (4, "ZeroDivisionError")


def test_an_error_without_a_place_is_reported_once():
    errors = InternalErrors()
    assert errors.add(ValueError("odd"))
    assert not errors.add(ValueError("odd"))


@pytest.mark.parametrize(("passed_s", "ends"), [(0.9, True), (1.1, False)])
def test_too_many_within_a_second_are_no_longer_survived(monkeypatch, passed_s, ends):
    now = [0.0]
    monkeypatch.setattr(internal_errors.time, "monotonic", lambda: now[0])
    errors, error = InternalErrors(), ValueError("odd")
    for _ in range(MOST_A_SECOND):
        errors.add(error)
    now[0] = passed_s
    if ends:
        with pytest.raises(ValueError, match="odd"):
            errors.add(error)
    else:
        errors.add(error)
    assert errors.count == MOST_A_SECOND + 1
