# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values on the command line."""

from __future__ import annotations

import argparse

import pytest

from aerial_gnss_ros.commands.argument_types import add_rosbag_version, numbers, sigma, size


@pytest.mark.parametrize(
    ("parse", "text", "value"),
    [
        (numbers(2), "1,-2.5", (1.0, -2.5)),
        (numbers(2, 3), "1,2,3e1", (1.0, 2.0, 30.0)),
        (size, "1280x720", (1280, 720)),
        (size, "64X8192", (64, 8192)),
        (sigma, "gnss_offset_m=0.02", ("gnss_offset_m", 0.02)),
        (sigma, "heading_deg=0", ("heading_deg", 0.0)),
    ],
)
def test_a_value_is_read(parse, text, value):
    assert parse(text) == value


@pytest.mark.parametrize(
    ("parse", "text", "words"),
    [
        (numbers(2), "1", "2 numbers separated by commas"),
        (numbers(2, 3), "1,2,3,4", "2 or 3 numbers"),
        (numbers(2), "1,north", "'1,north' is not 2 numbers"),
        (numbers(2), "1,inf", "is not 2 numbers"),
        (size, "1280", "such as 1280x720"),
        (size, "-5x100", "such as 1280x720"),
        (size, "63x100", "64 to 8192"),
        (size, "100x8193", "64 to 8192"),
        (sigma, "gnss_offset_m", "NAME=VALUE"),
        (sigma, "gnss=1", "NAME=VALUE"),
        (sigma, "gnss_offset_m=-1", "NAME=VALUE"),
        (sigma, "gnss_offset_m=nan", "NAME=VALUE"),
    ],
)
def test_what_is_no_value_is_refused(parse, text, words):
    with pytest.raises(argparse.ArgumentTypeError, match=words):
        parse(text)


def test_a_bag_can_be_written_for_an_older_ros():
    parser = argparse.ArgumentParser()
    add_rosbag_version(parser)
    assert parser.parse_args(["--rosbag-version", "8"]).rosbag_version == 8
    assert parser.parse_args([]).rosbag_version is None
