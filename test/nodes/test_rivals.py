# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A second node of a kind in a namespace is noticed by both, and said."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.nodes.rivals import FIRST_LOOKS, LEASE_LOOKS, Rivals

OWN, OTHER = "/d/estimator", "/d/estimator_2"


def test_it_is_reported_once_and_stays_in_the_diagnostics_until_it_is_over():
    rivals = Rivals("estimator")
    alone = ({"/d/map_datum": [OWN]}, [OWN, "/d/detector"])
    shared = ({"/d/map_datum": [OWN, OTHER]}, [OWN, OTHER])
    assert [rivals.look(OWN, *alone) for _ in range(FIRST_LOOKS)] == [""] * FIRST_LOOKS
    assert rivals.look(OWN, *shared) == ""  # may be one that just ends
    said = rivals.look(OWN, *shared)
    assert said.startswith("/d/estimator_2 publishes /d/map_datum, too:")
    assert "Only one estimator may run in a namespace" in said
    assert (rivals.look(OWN, *shared), rivals.trouble) == ("", said)
    assert (rivals.look(OWN, *alone), rivals.trouble) == ("", "")
    assert [rivals.look(OWN, *shared) for _ in range(2)] == ["", said]


def test_one_of_the_same_name_counts_before_it_publishes():
    rivals = Rivals("estimator")
    found = [rivals.look(OWN, {}, [OWN, OWN]) for _ in range(LEASE_LOOKS)]
    assert found[:-1] == [""] * (LEASE_LOOKS - 1)  # it may be what this node replaces
    assert found[-1].startswith(f"another node named {OWN} runs:")
    assert not any(rivals.look(OWN, {}, [OWN, "/e/estimator"]) for _ in range(3))


def test_a_player_of_recorded_results_is_one_too():
    rivals = Rivals("estimator")
    found = [rivals.look(OWN, {"/d/map_datum": ["/player", OWN]}, [OWN]) for _ in range(25)]
    assert found[-1].startswith("/player publishes /d/map_datum, too:")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "topic"),
    [("estimator", "/d/(map_datum|overview|robots/markers)"), ("detector", "/d/detections")],
)
def test_two_in_a_namespace_both_say_so(start, module, topic):
    arguments = ("--ros-args", "-r", "__ns:=/d")
    programs = [start(f"aerial_gnss_ros.nodes.{module}", *arguments) for _ in range(2)]
    for program in programs:
        program.wait_for(rf"another node named /d/{module} publishes {topic}, too: ")
        program.wait_for(f"Only one {module} may run in a namespace")
    for program in programs:
        assert program.end() == 0, program.text
